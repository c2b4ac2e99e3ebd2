# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Images in all the forms that MRPT has had."""

from __future__ import annotations

import io
import zlib
from typing import TYPE_CHECKING

import numpy as np
import pytest
from PIL import Image as PillowImage

from tests.formats.rawlog.made import TICKS, camera, opened, pose, save, scan, with_depth
from tumtools.convert import convert
from tumtools.errors import InputError, UnsupportedInputError
from tumtools.formats.rawlog.archive import Record
from tumtools.formats.rawlog.externals import Folder
from tumtools.formats.rawlog.pictures import pictures_of, units_per_metre
from tumtools.images.codec import canonical, pixels_of

if TYPE_CHECKING:
    from pathlib import Path

    import numpy.typing as npt

    from tumtools.model.image import Image

GREY = np.arange(15, dtype=np.uint8).reshape(3, 5)
RGB = np.arange(45, dtype=np.uint8).reshape(3, 5, 3)
COUNTS = np.arange(48, dtype="<u2").reshape(6, 8)
BGR = np.ascontiguousarray(RGB[:, :, ::-1])


def _file(pixels: npt.NDArray[np.generic], kind: str, mode: str | None = None, **options: object) -> bytes:
    out = io.BytesIO()
    image = (
        PillowImage.fromarray(pixels)
        if mode is None
        else PillowImage.frombytes(mode, (pixels.shape[1], pixels.shape[0]), pixels.tobytes())
    )
    image.save(out, kind, **options)
    return out.getvalue()


def _load(image: Record, folder: Path, **scan_fields: object) -> Image:
    (picture,) = pictures_of(scan(has_intensity=1, intensity=image, **scan_fields))
    return picture.load(Folder(folder / "a.rawlog"))


def _flat(data: bytes | npt.NDArray[np.uint8]) -> npt.NDArray[np.uint8]:
    return np.frombuffer(bytes(data) if isinstance(data, bytes) else data.tobytes(), np.uint8)


def _grey(version: int, stride: int = 8, **fields: object) -> Record:
    """A grey image; rows are padded to a multiple of four bytes, as they were until MRPT 1.5."""
    padded = np.zeros((3, stride), np.uint8)
    padded[:, :5] = GREY
    size = {"width": 5, "height": 3, "origin": 0, "byte_count": padded.size}
    everything = {"external": 0, "colour": 0, **size, "pixel_type": 0, "zipped": 0, "data": _flat(padded)}
    return Record("CImage", version, everything | fields)


@pytest.mark.parametrize("version", [2, 4, 5, 6, 7, 8, 9, 10])
def test_grey_images_of_every_version(version: int, tmp_path: Path) -> None:
    image = _load(_grey(version), tmp_path)
    assert image.encoding == "mono8"
    np.testing.assert_array_equal(pixels_of(image), GREY)


def test_grey_images_that_are_deflated_or_upside_down(tmp_path: Path) -> None:
    record = _grey(8)
    packed = _flat(zlib.compress(record.array("data").tobytes()))
    del record.fields["data"]
    record.fields.update(zipped=1, zlib=packed, origin=1)
    np.testing.assert_array_equal(pixels_of(_load(record, tmp_path)), GREY[::-1])


def test_grey_images_of_16_bits(tmp_path: Path) -> None:
    wide = GREY.astype("<u2") * 1000
    record = _grey(9, pixel_type=2, byte_count=30, data=_flat(wide.tobytes()))
    image = _load(record, tmp_path)
    assert image.encoding == "mono16"
    np.testing.assert_array_equal(pixels_of(image), wide)


@pytest.mark.parametrize(
    ("version", "fields", "stored"),
    [
        (0, {"width": 5, "height": 3, "channels": 3, "origin_top_left": 1}, BGR),
        (8, {"colour": 1, "width": -5, "height": -3}, BGR),
        (9, {"colour": 1, "width": -5, "height": -3}, BGR),
        (10, {"colour": 1, "width": 5, "height": 3}, RGB),
    ],
)
def test_raw_colour_images(
    version: int, fields: dict[str, object], stored: npt.NDArray[np.uint8], tmp_path: Path
) -> None:
    image = _load(Record("CImage", version, {"external": 0, **fields, "data": _flat(stored)}), tmp_path)
    np.testing.assert_array_equal(canonical(pixels_of(image), image.encoding)[0], RGB)


def test_jpeg_is_passed_on_as_it_is(tmp_path: Path) -> None:
    jpeg = _file(RGB, "JPEG")
    image = _load(Record("CImage", 1, {"jpeg": _flat(jpeg)}), tmp_path)
    assert (image.compression, image.compressed, image.width, image.height) == ("jpeg", jpeg, 5, 3)


def test_a_damaged_jpeg_names_its_place_when_it_is_decoded(tmp_path: Path) -> None:
    jpeg = _file(np.random.default_rng(0).integers(0, 256, (64, 64, 3), np.uint8), "JPEG")
    cut = _load(Record("CImage", 1, {"jpeg": _flat(jpeg[:-1000])}), tmp_path)
    with pytest.raises(InputError, match=r"a\.rawlog, image at offset 0"):
        pixels_of(cut)


@pytest.mark.parametrize(
    ("kind", "compression"), [("PNG", "png"), ("JPEG", "jpeg"), ("BMP", None), ("PPM", None)]
)
@pytest.mark.parametrize("version", [6, 9, 10, 100])
def test_external_images_of_any_kind(
    kind: str, compression: str | None, version: int, tmp_path: Path
) -> None:
    (tmp_path / "a_Images").mkdir()
    (tmp_path / "a_Images" / "x.img").write_bytes(_file(RGB, kind))
    image = _load(Record("CImage", version, {"external": 1, "file": "x.img"}), tmp_path)
    assert image.compression == compression
    if kind != "JPEG":
        np.testing.assert_array_equal(pixels_of(image), RGB)


WIDE = np.arange(300, 315, dtype="<u2").reshape(3, 5) * 7
RGBA = np.arange(60, dtype=np.uint8).reshape(3, 5, 4)


def _external(data: bytes, folder: Path) -> Image:
    (folder / "a_Images").mkdir()
    (folder / "a_Images" / "x.img").write_bytes(data)
    return _load(Record("CImage", 9, {"external": 1, "file": "x.img"}), folder)


@pytest.mark.parametrize(
    "data",
    [
        _file(WIDE, "TIFF"),
        _file(WIDE.astype("<i4"), "TIFF"),
        _file(WIDE, "PPM"),
        _file(WIDE, "JPEG2000"),
        b"P5 5 3 4000\n" + WIDE.astype(">u2").tobytes(),
        b"P2 5 3 4000\n" + b" ".join(b"%d" % value for value in WIDE.ravel()),
    ],
    ids=["TIFF", "TIFF of 32 bits", "PGM", "JPEG 2000", "PGM up to 4000", "plain PGM"],
)
def test_external_grey_of_16_bits_keeps_its_values(data: bytes, tmp_path: Path) -> None:
    image = _external(data, tmp_path)
    assert image.encoding == "mono16"
    np.testing.assert_array_equal(pixels_of(image), WIDE)


@pytest.mark.parametrize("kind", ["WEBP", "TIFF", "TGA"])
def test_external_images_keep_their_alpha(kind: str, tmp_path: Path) -> None:
    image = _external(
        _file(RGBA, kind, **({"lossless": True, "exact": True} if kind == "WEBP" else {})), tmp_path
    )
    assert image.encoding == "rgba8"
    np.testing.assert_array_equal(pixels_of(image), RGBA)


def test_external_grey_and_palettes_with_transparency_keep_it(tmp_path: Path) -> None:
    palette = PillowImage.fromarray(GREY % 4, "P")
    palette.putpalette([10, 11, 12, 20, 21, 22, 30, 31, 32, 40, 41, 42])
    out = io.BytesIO()
    palette.save(out, "GIF", transparency=2)
    image = _external(out.getvalue(), tmp_path)
    assert image.encoding == "rgba8"
    np.testing.assert_array_equal(pixels_of(image)[:, :, 0], GREY % 4 * 10 + 10)
    np.testing.assert_array_equal(pixels_of(image)[:, :, 3], np.where(GREY % 4 == 2, 0, 255))


@pytest.mark.parametrize(
    ("data", "told"),
    [
        (_file(WIDE.astype("<f4"), "TIFF"), "TIFF images of mode F"),
        (_file(WIDE.astype("<i4") - 301 * 7, "TIFF"), "TIFF images of mode I with values from -7"),
        (_file(WIDE.astype("<i4") * 1000, "TIFF"), "TIFF images of mode I with values from 2100000"),
        (b"P6 5 1 4000\n" + WIDE.astype(">u2").tobytes(), "PPM images of mode RGB with samples up to 4000"),
        (_file(RGBA, "TIFF", mode="CMYK"), "TIFF images of mode CMYK"),
        (_file(RGBA, "JPEG", mode="CMYK"), "JPEG images of mode CMYK"),
        (_file(RGB, "TIFF", mode="YCbCr"), "TIFF images of mode YCbCr"),
        (
            _file(RGB, "TIFF", save_all=True, append_images=[PillowImage.fromarray(RGB)]),
            "a TIFF file of 2 images",
        ),
    ],
    ids=["float", "negative", "too large", "colour of 16 bits", "CMYK", "JPEG in CMYK", "YCbCr", "two pages"],
)
def test_external_images_with_samples_that_no_encoding_holds_are_refused(
    data: bytes, told: str, tmp_path: Path
) -> None:
    with pytest.raises(UnsupportedInputError, match=told) as caught:
        _external(data, tmp_path)
    assert str(caught.value.path).endswith("a_Images/x.img")


def test_infrared_is_a_stream_of_its_own() -> None:
    image = Record("CImage", 9, {"external": 1, "file": "x.png"})
    streams = [next(pictures_of(scan(has_intensity=1, intensity=image, channel=n))).stream for n in (0, 1)]
    assert streams == ["rgb", "ir"]


def test_embedded_counts_and_embedded_metres(tmp_path: Path) -> None:
    folder = Folder(tmp_path / "a.rawlog")
    counts = np.arange(6, dtype="<u2").reshape(2, 3)
    (new,) = pictures_of(scan(range_units=float(np.float32(1 / 5000)), **with_depth(counts)))
    image = new.load(folder)
    assert (image.encoding, image.depth_units_per_metre) == ("16UC1", 5000)
    np.testing.assert_array_equal(pixels_of(image), counts)

    metres = (counts / 5000).astype("<f4")
    matrix = Record("CMatrix", 0, {"rows": 2, "columns": 3, "values": metres.reshape(-1)})
    (old,) = pictures_of(Record("CObservation3DRangeScan", 6, scan(has_range=1, range_matrix=matrix).fields))
    image = old.load(folder)
    assert (image.encoding, image.depth_units_per_metre) == ("32FC1", 1)
    # 0 is no reading, which is NaN in float depth.
    np.testing.assert_array_equal(pixels_of(image), np.where(metres == 0, np.nan, metres))
    again = old.load(folder, exact_units_per_metre=5000)
    assert again.encoding == "16UC1"
    np.testing.assert_array_equal(pixels_of(again), counts)
    assert old.load(folder, exact_units_per_metre=700).encoding == "32FC1"


@pytest.mark.parametrize("units", [1, 100, 1000, 5000, 10_000, 1234.5])
def test_the_whole_number_of_counts_is_found_in_the_float32(units: float) -> None:
    assert units_per_metre(float(np.float32(1 / units))) == pytest.approx(units, rel=1e-7)
    if units == int(units):
        assert units_per_metre(float(np.float32(1 / units))) == units


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("damaged", [0.0, -1.0, float("nan"), float("inf"), 1e-45, 1e38])
def test_senseless_units_are_taken_for_millimetres_and_told(damaged: float, tmp_path: Path) -> None:
    assert units_per_metre(damaged) is None
    path = save(tmp_path / "a.rawlog", scan(range_units=damaged, **with_depth(COUNTS)))
    with opened(path) as sequence:
        assert "1 depth images have a unit that no sensor has" in sequence.info.warnings[0]
        image = next(sequence.images()).load()
        assert image.depth_units_per_metre == 1000
        assert convert(sequence, tmp_path / "out", "tum").verified


def test_an_image_in_a_file_without_a_name_is_listed_as_lost(tmp_path: Path) -> None:
    image = Record("CImage", 9, {"external": 1, "file": ""})
    path = save(
        tmp_path / "a.rawlog",
        scan(
            has_intensity=1,
            intensity=image,
            has_range=1,
            range_external=1,
            rows=0,
            columns=0,
            range=np.empty(0, "<u2"),
        ),
    )
    with opened(path) as sequence:
        assert [(loss.stream, loss.what, loss.count) for loss in sequence.info.not_carried] == [
            ("CAM", "depth image", 1),
            ("CAM", "image", 1),
        ]


def test_images_that_are_empty_are_listed_as_not_carried_over(tmp_path: Path) -> None:
    none = {"colour": 1, "width": 0, "height": 0, "external": 0, "data": np.empty(0, np.uint8)}
    nothing = Record("mrpt::img::CImage", 9, none)
    fields = {"sensor_pose": pose(), "camera": camera(), "image": nothing, "time": TICKS, "label": "CAM"}
    path = save(
        tmp_path / "a.rawlog",
        Record("mrpt::obs::CObservationImage", 4, fields),
        scan(TICKS, "SCAN", has_intensity=1, intensity=nothing, **with_depth(COUNTS)),
        scan(TICKS, "SCAN", **with_depth(np.empty((0, 0), "<u2"))),
        scan(TICKS, "SCAN"),
    )
    with opened(path) as sequence:
        assert [(loss.stream, loss.what, loss.count) for loss in sequence.info.not_carried] == [
            ("CAM", "image without pixels", 1),
            ("SCAN", "depth image without pixels", 1),
            ("SCAN", "image without pixels", 1),
        ]


def test_a_jpeg_of_another_size_than_its_image_says_is_refused(tmp_path: Path) -> None:
    fields: dict[str, object] = {
        "external": 0,
        "colour": 1,
        "width": 5,
        "height": 3,
        "jpeg": _flat(_file(RGB, "JPEG")),
    }
    assert _load(Record("CImage", 8, fields), tmp_path).width == 5
    with pytest.raises(InputError, match="a JPEG file of 5 x 3 pixels in an image of 6 x 3"):
        _load(Record("CImage", 8, {**fields, "width": 6}), tmp_path)


def test_a_depth_file_without_pixels_names_itself(tmp_path: Path) -> None:
    (tmp_path / "a_Images").mkdir()
    (tmp_path / "a_Images" / "d.bin").write_bytes(bytes(8))
    fields = {"has_range": 1, "range_external": 1, "range_file": "d.bin"}
    empty = {"rows": 0, "columns": 0, "range": np.empty(0, "<u2")}
    with (
        opened(save(tmp_path / "a.rawlog", scan(**fields, **empty))) as sequence,
        pytest.raises(InputError, match=r"a_Images/d\.bin: the depth image has no pixels"),
    ):
        next(sequence.images()).load()


@pytest.mark.parametrize(
    "fields",
    [
        {"byte_count": 25},
        {"width": 9},
        {"height": 5},
        {"width": -5},
        {"pixel_type": 7},
        {"pixel_type": 5},
        {"zlib": np.frombuffer(b"no zlib", np.uint8), "zipped": 1},
    ],
)
def test_images_that_contradict_themselves_are_refused(fields: dict[str, object], tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"a\.rawlog, image at offset 0: damaged image"):
        _load(_grey(9, **fields), tmp_path)


def test_external_images_that_are_none_are_refused(tmp_path: Path) -> None:
    (tmp_path / "a_Images").mkdir()
    for data in (b"", b"text", b"\x89PNG\r\n\x1a\n", b"\xff\xd8\xff"):
        (tmp_path / "a_Images" / "x.png").write_bytes(data)
        with pytest.raises(InputError, match=r"x\.png") as caught:
            _load(Record("CImage", 9, {"external": 1, "file": "x.png"}), tmp_path)
        assert "BytesIO" not in str(caught.value)
