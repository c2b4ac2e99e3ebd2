# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Awkward sequences: what people's folders and recordings hold besides what the benchmark published."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from tests.memory import SECOND, START, Memory, accelerometer, groundtruth, picture
from tumtools.images.codec import image_of_pixels, image_of_png, png_of
from tumtools.model.image import ENCODINGS, Image
from tumtools.model.sequence import Frame, ImageStreamInfo, Sequence, SequenceInfo, frame_order
from tumtools.model.signals import Accelerometer, Trajectory
from tumtools.sources import open_source

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Iterator

    import numpy.typing as npt

    from tests.roundtrip.variants import Variant


FIXTURES: Final = Path(__file__).parents[2] / "fixtures"
NAME: Final = "synthetic_freiburg1_awkward"


class Made(Sequence):
    """A sequence of given images."""

    def __init__(self, **images: list[tuple[int, Image]]) -> None:
        self._images = images
        self.info = SequenceInfo(
            name=NAME,
            format="memory",
            camera="fr1",
            images={stream: _info([image for _, image in rows]) for stream, rows in images.items()},
        )

    def image_stamps(self, stream: str) -> npt.NDArray[np.int64]:
        return np.array([stamp for stamp, _ in self._images.get(stream, [])], np.int64)

    def images(
        self, streams: Collection[str] | None = None, start: int | None = None, end: int | None = None
    ) -> Iterator[Frame]:
        frames = [
            Frame(stream, stamp, row, lambda image=image: image)
            for stream, rows in self._images.items()
            if streams is None or stream in streams
            for row, (stamp, image) in enumerate(rows)
            if (start is None or stamp >= start) and (end is None or stamp <= end)
        ]
        return iter(sorted(frames, key=frame_order))


def _info(images: list[Image]) -> ImageStreamInfo:
    first = images[0]
    return ImageStreamInfo(
        count=len(images),
        encoding=first.encoding,
        width=first.width,
        height=first.height,
        depth_units_per_metre=first.depth_units_per_metre,
        nbytes=sum(image.nbytes for image in images),
        compression=first.compression,
    )


def _times(count: int = 3, first: int = START) -> list[int]:
    return [first + number * SECOND // 30 + number * 1000 for number in range(count)]


def _noise(encoding: str, width: int = 9, height: int = 7, seed: int = 0) -> Image:
    """Return random pixels of an encoding."""
    kind = ENCODINGS[encoding]
    shape = (height, width) if kind.channels == 1 else (height, width, kind.channels)
    values = np.random.default_rng(seed).integers(0, 256 ** min(kind.dtype.itemsize, 2), shape)
    return image_of_pixels(values.astype(kind.dtype), encoding)


def _colour(encoding: str, *, as_png: bool) -> Sequence:
    images = [_noise(encoding, seed=row) for row in range(3)]
    if as_png:
        images = [image_of_png(png_of(image)) for image in images]
    return Made(rgb=list(zip(_times(), images, strict=True)))


def _depth(pixels: npt.NDArray[np.uint16]) -> Image:
    return image_of_png(png_of(image_of_pixels(pixels, "16UC1", 5000.0)), 5000.0)


def _depth_values(*values: int) -> Sequence:
    images = [_depth(np.full((5, 6), value, np.uint16)) for value in values]
    images.append(_depth(np.arange(65_536, dtype=np.uint16).reshape(256, 256)))
    return Made(depth=list(zip(_times(len(images)), images, strict=True)))


def _sizes() -> Sequence:
    """Return images of one pixel, one column, one row, and odd sizes, one after another."""
    sizes = [(1, 1), (1, 17), (17, 1), (7, 5), (641, 3)]
    random = np.random.default_rng(5)
    depth = [_depth(random.integers(0, 65_536, (h, w)).astype(np.uint16)) for w, h in sizes]
    rgb = [_noise("rgb8", width, height) for width, height in sizes]
    times = _times(len(sizes))
    return Made(rgb=list(zip(times, rgb, strict=True)), depth=list(zip(times, depth, strict=True)))


def _memory(stamps: dict[str, list[int]], **content: Any) -> Memory:
    """Return pictures at the given stamps; the name tells the camera, unless it is given."""
    return Memory(stamps, **{"name": NAME, **content})


def _repeated(*, same_pixels: bool) -> Sequence:
    times = [START, START, START + SECOND, START + SECOND, START + SECOND]
    rows = [0, 0, 1, 1, 1] if same_pixels else [0, 1, 2, 3, 2]
    return Made(
        rgb=[(time, picture("rgb", row)) for time, row in zip(times, rows, strict=True)],
        depth=[(time, picture("depth", row)) for time, row in zip(times, rows, strict=True)],
    )


def _starting_at(seconds: int) -> Sequence:
    times = _times(3, seconds * SECOND)
    return _memory(
        {"rgb": times, "depth": times}, accelerometer=accelerometer(*times), groundtruth=groundtruth(*times)
    )


def _signals_only(*, poses: bool) -> Sequence:
    rows = _times(5)
    found = _memory({}, accelerometer=None if poses else accelerometer(*rows))
    found.groundtruth = groundtruth(*rows) if poses else None
    return found


def _not_numbers() -> Sequence:
    found = _memory(
        {"rgb": _times()}, groundtruth=groundtruth(*_times()), accelerometer=accelerometer(*_times())
    )
    assert found.groundtruth is not None
    assert found.accelerometer is not None
    found.groundtruth.positions[1] = [np.nan, np.inf, -0.0]
    found.accelerometer.values[2] = [1e-300, -1e300, np.nan]
    return found


def _unsorted() -> Sequence:
    times = [START + SECOND, START, START + 3 * SECOND, START + 2 * SECOND]
    return _memory(
        {"rgb": times, "depth": times[::-1], "ir": times},
        accelerometer=accelerometer(*times),
        groundtruth=groundtruth(*times),
    )


def _empty() -> Sequence:
    none = Accelerometer.empty()
    return _memory({"rgb": [], "depth": []}, accelerometer=none, groundtruth=Trajectory.empty())


# --- text -----------------------------------------------------------------------------------------------

POSE: Final = "1.25 -0.5 0.0625 0 0 0.6 0.8"


def _folder(folder: Path, texts: dict[str, str | bytes]) -> Sequence:
    """Write text files and the images that they name, and open them."""
    folder.mkdir()
    for name, text in texts.items():
        data = text if isinstance(text, bytes) else text.encode()
        (folder / f"{name}.txt").write_bytes(data)
        if name in {"rgb", "depth", "ir"}:
            lines = [
                line for line in data.decode("utf-8-sig").splitlines() if line and not line.startswith("#")
            ]
            for row, line in enumerate(lines):
                path = folder / line.replace(",", " ").split()[1]
                path.parent.mkdir(parents=True, exist_ok=True)
                path.write_bytes(picture(name, row).png or b"")
    return open_source(folder)


def _list(stream: str, *stamps: str) -> str:
    return "".join(f"{stamp} {stream}/{stamp}.png\n" for stamp in stamps)


def _text(**texts: str | bytes) -> Callable[[Path], Sequence]:
    return lambda folder: _folder(folder / "sequence", texts)


def _made(make: Callable[..., Sequence], *args: object, **options: object) -> Callable[[Path], Sequence]:
    return lambda _: make(*args, **options)


def _fixture(name: str) -> Callable[[Path], Sequence]:
    """Open a sequence of the folder of fixtures."""
    return lambda _: open_source(FIXTURES / name)


CRLF: Final = (
    "# color images\r\n# timestamp filename\r\n1.000000 rgb/1.000000.png\r\n2.000000 rgb/2.000000.png\r\n"
)

CONTENTS: Final[dict[str, Callable[[Path], Sequence]]] = {
    "the first releases: commas, imu.txt": _fixture("early"),
    "the third camera: no rows of accelerations": _fixture("fr3"),
    "somebody else's recorder: no headers, tabs": _fixture("foreign"),
    "no depth": _made(_memory, {"rgb": _times()}),
    "a name that does not tell the camera": _made(_memory, {"rgb": _times()}, name="kitchen"),
    "no colour": _made(_memory, {"depth": _times()}),
    "infrared": _made(_memory, {"ir": _times(), "depth": _times()}),
    "colour, depth and infrared": _made(_memory, {"rgb": _times(), "depth": _times(), "ir": _times()}),
    "ground truth only": _made(_signals_only, poses=True),
    "accelerometer only": _made(_signals_only, poses=False),
    "no ground truth": _made(
        _memory, {"rgb": _times(), "depth": _times()}, accelerometer=accelerometer(START)
    ),
    "images that repeat a stamp, the same pixels": _made(_repeated, same_pixels=True),
    "images that repeat a stamp, other pixels": _made(_repeated, same_pixels=False),
    "ground truth that repeats stamps": _made(
        lambda: _memory({"rgb": _times()}, groundtruth=groundtruth(START, START, START + 100, START + 100))
    ),
    "ground truth that repeats stamps, as text": _text(
        rgb=_list("rgb", "1.000000"),
        groundtruth=f"# poses\n1.0000 {POSE}\n1.0000 {POSE[::-1].replace('-', '')}\n1.0100 {POSE}\n",
    ),
    "unsorted rows": _made(_unsorted),
    "unsorted rows, as text": _text(
        rgb=_list("rgb", "2.000000", "1.000000", "3.000000"),
        groundtruth=f"2.0 {POSE}\n1.0 {POSE}\n3.0 {POSE}\n",
    ),
    "nine decimals": _text(
        rgb=_list("rgb", "1305031102.175304001", "1305031102.175304002"),
        depth=_list("depth", "1305031102.175304003", "1305031102.175304099"),
        groundtruth=f"1305031102.175304001 {POSE}\n",
        accelerometer="1305031102.175304001 0.1 0.2 9.81\n1305031102.175304002 0.1 0.2 9.82\n",
    ),
    "scientific notation": _text(
        rgb="1.305031102175304e+09 rgb/a.png\n1.305031102275304E9 rgb/b.png\n",
        groundtruth="1.305031102175300e+09 1.5e0 -2.5E-01 1e-17 0 0 0 1\n"
        "1.305031102185300e+09 1.500000000000000e+00 1e+3 .5 0 0 0 1\n",
    ),
    "CRLF": _text(rgb=CRLF, depth=CRLF.replace("rgb", "depth"), groundtruth=f"# x\r\n1.0000 {POSE}\r\n"),
    "mixed line ends, comments between rows, no final newline": _text(
        rgb="# one\n1.000000 rgb/1.000000.png\r\n# between\n\n2.000000 rgb/2.000000.png",
        groundtruth=f"1.0000 {POSE}\n# gap\n2.0000 {POSE}  \n\n# end",
    ),
    "tabs, commas and byte order mark": _text(
        rgb=b"\xef\xbb\xbf1.000000\trgb/1.000000.png\n2.000000\trgb/2.000000.png\n",
        groundtruth=f"1.0000,{POSE.replace(' ', ',')}\n2.0000,  {POSE.replace(' ', ', ')}\n",
    ),
    "file names of somebody else's": _text(
        rgb="1.000000 images/frame_0001.png\n2.000000 images/sub/frame_2.png\n",
        depth="1.010000 d/x.png\n",
    ),
    "header lines only": _text(rgb="# color images\n", depth="# depth maps\n", groundtruth="# poses\n"),
    "empty text files": _text(rgb="", depth="", accelerometer=""),
    "one frame": _made(_memory, {"rgb": [START], "depth": [START]}, groundtruth=groundtruth(START)),
    "zero frames": _made(_empty),
    "depth of 0, 65535 and every count": _made(_depth_values, 0, 65535),
    "values that are no number or extreme": _made(_not_numbers),
    "before 1970": _made(_starting_at, -100),
    "at 1970": _made(_starting_at, 0),
    "after 2038": _made(_starting_at, 2**31 - 1 + 10),
    "after 2106": _made(_starting_at, 2**32 + 10),
    "colour with alpha": _made(_colour, "rgba8", as_png=True),
    "colour with alpha, pixels in the order of blue": _made(_colour, "bgra8", as_png=False),
    "grey, 8 bits": _made(_colour, "mono8", as_png=True),
    "grey, 8 bits, pixels": _made(_colour, "mono8", as_png=False),
    "grey, 16 bits": _made(_colour, "mono16", as_png=True),
    "odd sizes that change": _made(_sizes),
}


def refused(content: str, variant: Variant) -> bool:
    """Tell whether a format cannot hold the stamps of a content: ROS times are of 32 bits."""
    if variant.format in {"tum", "rawlog"}:
        return False
    ros1 = variant.format == "rosbag1" or variant.option("profile") == "ros1"
    return content in {"before 1970", "after 2106"} or (content == "after 2038" and not ros1)
