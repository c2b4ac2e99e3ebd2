# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Single faults that are put into a good sequence, each with the rule that must find it.

`python -m tests.validate.faults` makes them all and prints what was found.
"""

from __future__ import annotations

import shutil
import struct
import sys
import tempfile
import zlib
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from tumtools.images import png

if TYPE_CHECKING:
    from collections.abc import Callable

Pixels = npt.NDArray[np.generic]


@dataclass(frozen=True)
class Fault:
    """A fault.

    Attributes:
        name: What is done.
        code: The rule that must find it.
        inject: Does it to the files of a folder.
        errors: Other rules that may report errors because of it.

    """

    name: str
    code: str
    inject: Callable[[Path], None]
    errors: tuple[str, ...] = ()


def _lines(path: Path) -> tuple[list[str], list[str]]:
    lines = path.read_text().splitlines(keepends=True)
    head = [line for line in lines if line.startswith("#")]
    return head, lines[len(head) :]


def rows(file: str, edit: Callable[[list[str]], list[str]]) -> Callable[[Path], None]:
    """Edit the rows of a text file."""

    def inject(folder: Path) -> None:
        head, body = _lines(folder / file)
        (folder / file).write_text("".join(head + edit(body)))

    return inject


def numbers(
    file: str, edit: Callable[[npt.NDArray[np.float64]], npt.NDArray[np.float64]], decimals: int
) -> Callable[[Path], None]:
    """Edit the values of a trajectory or accelerometer file, all rows at once."""

    def inject(folder: Path) -> None:
        head, body = _lines(folder / file)
        fields = [row.split() for row in body]
        values = edit(np.array([[float(field) for field in row[1:]] for row in fields]))
        text = [
            " ".join([row[0], *(f"{value:.{decimals}f}" for value in line)]) + "\n"
            for row, line in zip(fields, values.tolist(), strict=True)
        ]
        (folder / file).write_text("".join(head + text))

    return inject


def stamps(file: str, edit: Callable[[str], str]) -> Callable[[Path], None]:
    """Edit the text of every stamp."""
    return rows(
        file, lambda body: [" ".join([edit(row.split()[0]), *row.split()[1:]]) + "\n" for row in body]
    )


def image(stream: str, edit: Callable[[Pixels], Pixels], number: int = 7) -> Callable[[Path], None]:
    """Edit the pixels of one image; number -1 for all."""

    def inject(folder: Path) -> None:
        files = sorted((folder / stream).iterdir())
        for path in files if number < 0 else [files[number]]:
            path.write_bytes(png.encode(edit(png.decode(path.read_bytes()))))

    return inject


def data(stream: str, edit: Callable[[bytes], bytes], number: int = 7) -> Callable[[Path], None]:
    """Edit the bytes of one image file."""

    def inject(folder: Path) -> None:
        path = sorted((folder / stream).iterdir())[number]
        path.write_bytes(edit(path.read_bytes()))

    return inject


def _swap(first: int, second: int) -> Callable[[list[str]], list[str]]:
    def edit(body: list[str]) -> list[str]:
        body[first], body[second] = body[second], body[first]
        return body

    return edit


def _replace(row: int, text: str) -> Callable[[list[str]], list[str]]:
    return lambda body: [*body[:row], text + "\n", *body[row + 1 :]]


def _cut(first: int, last: int) -> Callable[[list[str]], list[str]]:
    return lambda body: body[:first] + body[last:]


def _scaled_stamp(scale: int) -> Callable[[str], str]:
    return lambda text: str(round(float(text) * scale))


def _shift_stamp(seconds: float) -> Callable[[str], str]:
    def edit(text: str) -> str:
        whole, part = text.split(".")
        ticks = int(whole + part) + round(seconds * 10 ** len(part))
        return f"{ticks // 10 ** len(part)}.{ticks % 10 ** len(part):0{len(part)}d}"

    return edit


def _rename(folder: Path) -> None:
    path = sorted((folder / "rgb").iterdir())[5]
    path.rename(path.with_name("1305031000.999999.png"))
    text = (folder / "rgb.txt").read_text()
    (folder / "rgb.txt").write_text(text.replace(f"rgb/{path.name}", "rgb/1305031000.999999.png"))


def _number_names(folder: Path) -> None:
    text = (folder / "depth.txt").read_text()
    for number, path in enumerate(sorted((folder / "depth").iterdir())):
        path.rename(path.with_name(f"{number:05d}.png"))
        text = text.replace(f"depth/{path.name}", f"depth/{number:05d}.png")
    (folder / "depth.txt").write_text(text)


def _remove(name: str) -> Callable[[Path], None]:
    def inject(folder: Path) -> None:
        path = folder / name
        if path.is_dir():
            path = sorted(path.iterdir())[3]
        path.unlink()

    return inject


def _extra(folder: Path) -> None:
    path = min((folder / "depth").iterdir())
    shutil.copy(path, path.with_name("1305031009.000000.png"))


def _link_to_itself(folder: Path) -> None:
    path = min((folder / "rgb").iterdir())
    path.unlink()
    path.symlink_to(path.name)


def _repeat_image(folder: Path) -> None:
    files = sorted((folder / "rgb").iterdir())
    shutil.copy(files[8], files[9])


def _encode(file: str, encoding: str) -> Callable[[Path], None]:
    def inject(folder: Path) -> None:
        path = folder / file
        path.write_bytes(path.read_text().encode(encoding))

    return inject


def _text(file: str, edit: Callable[[str], str]) -> Callable[[Path], None]:
    def inject(folder: Path) -> None:
        path = folder / file
        path.write_bytes(edit(path.read_bytes().decode()).encode())

    return inject


def _wrong_crc(png_file: bytes) -> bytes:
    place = png_file.index(b"IDAT")
    (length,) = struct.unpack(">I", png_file[place - 4 : place])
    end = place + 4 + length
    return png_file[:end] + b"\0\0\0\0" + png_file[end + 4 :]


def _bad_deflate(png_file: bytes) -> bytes:
    """Damage the compressed data and make the checksum fit."""
    place = png_file.index(b"IDAT")
    (length,) = struct.unpack(">I", png_file[place - 4 : place])
    body = bytearray(png_file[place + 4 : place + 4 + length])
    body[len(body) // 2 :] = bytes(len(body) - len(body) // 2)
    crc = zlib.crc32(b"IDAT" + body)
    return png_file[: place + 4] + bytes(body) + struct.pack(">I", crc) + png_file[place + 8 + length :]


def _smaller(pixels: Pixels) -> Pixels:
    return np.ascontiguousarray(pixels[:-8, :-8])


def _grey(pixels: Pixels) -> Pixels:
    return np.ascontiguousarray(pixels[..., 1])


def _alpha(pixels: Pixels) -> Pixels:
    return np.concatenate([pixels, np.full((*pixels.shape[:2], 1), 255, np.uint8)], axis=2)


def _depth(factor: float) -> Callable[[Pixels], Pixels]:
    return lambda pixels: np.minimum(np.rint(pixels.astype(np.float64) * factor), 65535).astype(np.uint16)


def _no_reading(pixels: Pixels) -> Pixels:
    return np.where(pixels == 0, np.uint16(65535), pixels)


def _noise_of_ray_tracer(pixels: Pixels) -> Pixels:
    rows, columns = np.indices(pixels.shape)
    return (8000 + 31.7 * rows + 17.3 * columns + (rows * columns) % 7).astype(np.uint16)


def _quaternions(
    edit: Callable[[npt.NDArray[np.float64]], npt.NDArray[np.float64]],
) -> Callable[[npt.NDArray[np.float64]], npt.NDArray[np.float64]]:
    return lambda values: np.concatenate([values[:, :3], edit(values[:, 3:])], axis=1)


def _inverse(values: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    vector, w = values[:, 3:6], values[:, 6:]
    positions = -values[:, :3]
    cross = np.cross(-vector, positions)
    moved = positions + 2 * (w * cross + np.cross(-vector, cross))
    return np.concatenate([moved, -vector, w], axis=1)


def _set(row: int, column: int, value: float) -> Callable[[npt.NDArray[np.float64]], npt.NDArray[np.float64]]:
    def edit(values: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
        values[row, column] = value
        return values

    return edit


def _jump(values: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    values[100:, 0] += 0.4
    return values


def _spin(values: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    values[100, 3:] = [1, 0, 0, 0]
    return values


def _freeze(values: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    values[60:180] = values[60]
    return values


def _flip(values: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    values[50:, 3:] *= -1
    return values


def _float64(text: str) -> str:
    return f"{float(text) / 1e9 * 1e9:.9f}"


def _float32(text: str) -> str:
    return f"{float(np.float32(text)):.6f}"


RGB, DEPTH, POSES, ACCELERATIONS = "rgb.txt", "depth.txt", "groundtruth.txt", "accelerometer.txt"

FAULTS = [
    # files and text
    Fault("an image file removed (colour)", "TUM001", _remove("rgb")),
    Fault("an image file removed (depth)", "TUM001", _remove("depth")),
    Fault("rgb.txt removed", "TUM001", _remove(RGB)),
    Fault("depth.txt removed", "TUM001", _remove(DEPTH)),
    Fault(
        "a name that leads out of the folder",
        "TUM001",
        rows(RGB, lambda body: [*body[:3], body[3].split()[0] + " ../../x.png\n", *body[4:]]),
        ("TUM104",),
    ),
    Fault("an image that is a link to itself", "TUM001", _link_to_itself),
    Fault("an image that no list names", "TUM002", _extra),
    Fault("a row taken out of a list", "TUM002", rows(DEPTH, _cut(10, 11))),
    Fault("a word instead of a stamp", "TUM003", rows(POSES, _replace(20, "none 0 0 0 0 0 0 1"))),
    Fault(
        "a row with a column too few",
        "TUM003",
        rows(POSES, lambda body: [*body[:9], body[9].rsplit(" ", 1)[0] + "\n", *body[10:]]),
    ),
    Fault(
        "a row with a column too many",
        "TUM003",
        rows(ACCELERATIONS, lambda body: [*body[:9], body[9].strip() + " 1.0\n", *body[10:]]),
    ),
    Fault(
        "a stamp without a file name",
        "TUM003",
        rows(RGB, lambda body: [*body[:9], body[9].split()[0] + "\n", *body[10:]]),
    ),
    Fault("decimal commas", "TUM003", rows(POSES, lambda body: [row.replace(".", ",") for row in body])),
    Fault(
        "a header line without #", "TUM003", _text(RGB, lambda text: text.replace("# timestamp", "timestamp"))
    ),
    Fault(
        "a file cut in the middle of a row",
        "TUM003",
        _text(POSES, lambda text: text[: len(text) // 2 - 20].rsplit(" ", 2)[0]),
    ),
    Fault("UTF-16", "TUM003", _encode(DEPTH, "utf-16")),
    Fault(
        "a binary file instead of text",
        "TUM003",
        lambda folder: (folder / POSES).write_bytes(bytes(range(256)) * 20) and None,
    ),
    Fault(
        "no header",
        "TUM004",
        _text(DEPTH, lambda text: "".join(row for row in text.splitlines(True) if row[0] != "#")),
    ),
    Fault("a list without rows", "TUM005", rows(DEPTH, lambda _: [])),
    Fault("ground truth without rows", "TUM005", rows(POSES, lambda _: [])),
    Fault("CRLF", "TUM006", _text(RGB, lambda text: text.replace("\n", "\r\n"))),
    Fault(
        "CRLF in one row",
        "TUM006",
        _text(POSES, lambda text: text.replace("\n", "\r\n", 9).replace("\r\n", "\n", 8)),
    ),
    Fault("tabs", "TUM006", rows(POSES, lambda body: [row.replace(" ", "\t") for row in body])),
    Fault("commas", "TUM006", rows(ACCELERATIONS, lambda body: [row.replace(" ", ",") for row in body])),
    Fault("a byte-order mark", "TUM006", _encode(RGB, "utf-8-sig")),
    Fault("no final line end", "TUM006", _text(POSES, str.rstrip)),
    Fault(
        "backslashes in a list", "TUM006", rows(RGB, lambda body: [row.replace("/", "\\") for row in body])
    ),
    Fault(
        "an association file as list",
        "TUM006",
        rows(DEPTH, lambda body: [f"{row.strip()} {row}" for row in body]),
    ),
    # stamps
    Fault("two rows swapped (colour)", "TUM101", rows(RGB, _swap(10, 11))),
    Fault("two rows swapped (ground truth)", "TUM101", rows(POSES, _swap(50, 51))),
    Fault(
        "the clock set back by 10 s",
        "TUM101",
        rows(
            ACCELERATIONS,
            lambda body: (
                body[:700]
                + [
                    " ".join([_shift_stamp(-10)(row.split()[0]), *row.split()[1:]]) + "\n"
                    for row in body[700:]
                ]
            ),
        ),
    ),
    Fault("a row repeated", "TUM102", rows(POSES, lambda body: body[:30] + body[29:])),
    Fault("a colour row repeated", "TUM102", rows(RGB, lambda body: body[:30] + body[29:])),
    Fault("a dropped second (colour)", "TUM103", rows(RGB, _cut(15, 45))),
    Fault("a dropped second (ground truth)", "TUM103", rows(POSES, _cut(100, 200))),
    Fault("0.2 s of the accelerometer dropped", "TUM103", rows(ACCELERATIONS, _cut(500, 600))),
    Fault("a file renamed in folder and list", "TUM104", _rename),
    Fault(
        "the stamp of a row off by a microsecond",
        "TUM104",
        rows(
            RGB,
            lambda body: [
                *body[:9],
                " ".join([_shift_stamp(1e-6)(body[9].split()[0]), body[9].split()[1]]) + "\n",
                *body[10:],
            ],
        ),
    ),
    Fault("frame numbers as names", "TUM104", _number_names),
    Fault(
        "a stamp in milliseconds",
        "TUM105",
        rows(
            RGB,
            lambda body: [
                *body[:9],
                " ".join([_scaled_stamp(1000)(body[9].split()[0]), body[9].split()[1]]) + "\n",
                *body[10:],
            ],
        ),
    ),
    Fault("all stamps in milliseconds", "TUM105", stamps(POSES, _scaled_stamp(10**3))),
    Fault("all stamps in microseconds", "TUM105", stamps(DEPTH, _scaled_stamp(10**6))),
    Fault("all stamps in nanoseconds", "TUM105", stamps(ACCELERATIONS, _scaled_stamp(10**9))),
    Fault(
        "frame numbers instead of stamps",
        "TUM105",
        rows(POSES, lambda body: [" ".join([str(n), *row.split()[1:]]) + "\n" for n, row in enumerate(body)]),
    ),
    Fault(
        "seconds since the start",
        "TUM105",
        stamps(ACCELERATIONS, lambda text: f"{float(text) - 1305030999:.6f}"),
    ),
    Fault(
        "dates instead of stamps",
        "TUM105",
        stamps(POSES, lambda text: f"2011-05-10T12:{text[8:10]}:{text[11:13]}"),
    ),
    Fault("stamps through float32", "TUM106", stamps(POSES, _float32)),
    Fault("list stamps through float32", "TUM106", stamps(RGB, _float32)),
    Fault("stamps through float64", "TUM106", stamps(ACCELERATIONS, _float64)),
    Fault("stamps with two decimals", "TUM106", stamps(ACCELERATIONS, lambda text: f"{float(text):.2f}")),
    Fault("every second image left out", "TUM107", rows(RGB, lambda body: body[::2])),
    Fault("every tenth pose kept", "TUM107", rows(POSES, lambda body: body[::10])),
    Fault("depth stamps shifted by 10 s", "TUM108", stamps(DEPTH, _shift_stamp(10)), ("TUM104",)),
    Fault("ground truth of the first second only", "TUM109", rows(POSES, lambda body: body[:100])),
    Fault("ground truth of a single pose", "TUM109", rows(POSES, lambda body: body[:1])),
    Fault("ground truth shifted by an hour", "TUM109", stamps(POSES, _shift_stamp(3600))),
    # images
    Fault("a PNG file cut off", "TUM201", data("rgb", lambda file: file[: len(file) // 2])),
    Fault("a PNG file with a wrong CRC", "TUM201", data("depth", _wrong_crc)),
    Fault(
        "a PNG file with a flipped byte",
        "TUM201",
        data("rgb", lambda file: file[:200] + bytes([file[200] ^ 1]) + file[201:]),
    ),
    Fault("damaged deflate data under a right CRC", "TUM201", data("rgb", _bad_deflate)),
    Fault("an empty file", "TUM201", data("depth", lambda _: b"")),
    Fault("a text file named .png", "TUM201", data("rgb", lambda _: b"version https://git-lfs\n")),
    Fault("grey colour", "TUM202", image("rgb", _grey)),
    Fault("colour with alpha", "TUM202", image("rgb", _alpha)),
    Fault("another size", "TUM202", image("depth", _smaller)),
    Fault(
        "depth in an 8-bit PNG", "TUM202", image("depth", lambda pixels: (pixels >> 8).astype(np.uint8), -1)
    ),
    Fault(
        "depth as a colour picture",
        "TUM202",
        image("depth", lambda pixels: np.repeat((pixels >> 8).astype(np.uint8)[..., None], 3, 2), -1),
    ),
    Fault("a repeated image", "TUM203", _repeat_image),
    Fault("a black image", "TUM204", image("rgb", np.zeros_like)),
    Fault("an empty depth image", "TUM204", image("depth", np.zeros_like)),
    Fault("depth / 5 (millimetres)", "TUM301", image("depth", _depth(1 / 5), -1)),
    Fault("depth * 2", "TUM301", image("depth", _depth(2), -1)),
    Fault("depth * 0.8", "TUM301", image("depth", _depth(0.8), -1)),
    Fault("one image in millimetres", "TUM301", image("depth", _depth(1 / 5))),
    Fault("65535 for no reading", "TUM302", image("depth", _no_reading, -1)),
    Fault(
        "no depth but in a corner",
        "TUM303",
        image(
            "depth",
            lambda pixels: np.where(np.indices(pixels.shape)[0] < 30, pixels, 0).astype(np.uint16),
            -1,
        ),
    ),
    Fault(
        "holes filled",
        "TUM303",
        image("depth", lambda pixels: np.where(pixels == 0, np.uint16(15000), pixels), -1),
    ),
    Fault("big-endian depth", "TUM304", image("depth", lambda pixels: pixels.byteswap(), -1)),
    Fault("one big-endian depth image", "TUM304", image("depth", lambda pixels: pixels.byteswap())),
    Fault(
        "depth with 8 bits in 16",
        "TUM305",
        image("depth", lambda pixels: (pixels >> 8 << 8).astype(np.uint16), -1),
    ),
    Fault(
        "depth shifted down to 8 bits",
        "TUM305",
        image("depth", lambda pixels: (pixels >> 8).astype(np.uint16), -1),
    ),
    Fault("ray-traced depth", "TUM306", image("depth", _noise_of_ray_tracer, -1)),
    # poses
    Fault("quaternions of norm 0.9", "TUM401", numbers(POSES, _quaternions(lambda q: 0.9 * q), 4)),
    Fault(
        "one quaternion of norm 1.005",
        "TUM401",
        numbers(
            POSES,
            lambda v: np.where(
                np.arange(len(v))[:, None] == 40, v * [1, 1, 1, 1.005, 1.005, 1.005, 1.005], v
            ),
            4,
        ),
    ),
    Fault("NaN in a pose", "TUM402", numbers(POSES, _set(30, 4, np.nan), 4)),
    Fault("infinity in a position", "TUM402", numbers(POSES, _set(30, 0, np.inf), 4)),
    Fault(
        "a zero quaternion",
        "TUM402",
        numbers(POSES, lambda v: np.where(np.arange(len(v))[:, None] == 40, v * [1, 1, 1, 0, 0, 0, 0], v), 4),
    ),
    Fault("w first", "TUM403", numbers(POSES, _quaternions(lambda q: q[:, [3, 0, 1, 2]]), 4)),
    Fault("inverse poses", "TUM403", numbers(POSES, _inverse, 4)),
    Fault("the sign of a quaternion flipped", "TUM404", numbers(POSES, _flip, 4)),
    Fault("a jump of 0.4 m", "TUM405", numbers(POSES, _jump, 4)),
    Fault("one rotation from elsewhere", "TUM405", numbers(POSES, _spin, 4)),
    Fault("1.2 s of the same pose", "TUM406", numbers(POSES, _freeze, 4)),
    Fault("the accelerometer shifted by 200 ms", "TUM407", stamps(ACCELERATIONS, _shift_stamp(0.2))),
    # accelerometer
    Fault("the accelerometer in g", "TUM501", numbers(ACCELERATIONS, lambda v: v / 9.80665, 6)),
    Fault("gravity taken out", "TUM501", numbers(ACCELERATIONS, lambda v: v * 0.02, 6)),
    Fault("an infinite acceleration", "TUM503", numbers(ACCELERATIONS, _set(20, 1, np.inf), 6)),
    Fault("an acceleration that is no number", "TUM503", numbers(ACCELERATIONS, _set(9, 2, np.nan), 6)),
    Fault("six columns", "TUM502", numbers(ACCELERATIONS, lambda v: np.concatenate([v * 0.1, v], axis=1), 6)),
]


def main() -> None:
    """Print a table of the faults and of what was found, and end with 1 if any was missed."""
    from tumtools.convert import ConvertOptions, convert
    from tumtools.formats.options import WriteOptions
    from tumtools.synthetic import synthesize
    from tumtools.validate.engine import validate
    from tumtools.validate.finding import Severity

    missed = 0
    with tempfile.TemporaryDirectory() as scratch:
        good = Path(scratch, "good")
        convert(
            synthesize(60, width=96, height=72), good, "tum", WriteOptions(), ConvertOptions(verify=False)
        )
        for fault in FAULTS:
            folder = Path(shutil.copytree(good, Path(scratch, "bad")))
            fault.inject(folder)
            findings = validate(folder).findings
            shutil.rmtree(folder)
            hit = any(finding.code == fault.code for finding in findings)
            sorted(
                {
                    finding.code
                    for finding in findings
                    if finding.severity > Severity.INFO and finding.code != "TUM202"
                }
                | ({fault.code} if hit else set())
            )
            missed += not hit
            next((str(f.place) for f in findings if f.code == fault.code), "")
    sys.stdout.write(f"{len(FAULTS)} faults, {missed} missed\n")
    sys.exit(bool(missed))


if __name__ == "__main__":
    main()
