# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""The images that observations hold, embedded or external, as images of the model.

Nothing is decoded before somebody asks for an image.
"""

from __future__ import annotations

import zlib
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final

import numpy as np

from tumtools.errors import InputError, UnsupportedInputError
from tumtools.formats.rawlog import archive, externals
from tumtools.formats.rawlog.classes import DEPTH_CODES
from tumtools.images.codec import image_of_jpeg, image_of_pixels, image_of_png
from tumtools.images.depth import exact_counts
from tumtools.images.limits import check_size
from tumtools.images.parallel import take_room
from tumtools.images.png import SIGNATURE
from tumtools.model.time import ticks_to_stamp

if TYPE_CHECKING:
    from collections.abc import Iterator

    import numpy.typing as npt

    from tumtools.formats.rawlog.archive import Record
    from tumtools.model.image import Image

_MATRICES: Final = frozenset({"CMatrixF", "CMatrixD"})
_JPEG_MAGIC: Final = b"\xff\xd8"
_INFRARED: Final = 1
_METRES: Final = 1.0
_DEFAULT_UNITS: Final = 0.001
"""MRPT's; taken for units that no sensor has, too."""
EMPTY_IMAGE: Final = "image without pixels"
EMPTY_DEPTH_IMAGE: Final = "depth image without pixels"
_PLAUSIBLE_UNITS: Final = (1e-9, 1e3)
"""Metres per count."""


@dataclass(frozen=True, slots=True, eq=False)
class Picture:
    """One image of one observation.

    Attributes:
        stream: `rgb`, `depth` or `ir`.
        ticks: Time of the observation.
        label: Sensor label of the observation.
        file: Name of the external file; None if the image is embedded.
        image: The `CImage`, for colour and infrared.
        scan: The scan, for embedded depth.
        units_per_metre: For depth: counts per metre, where it is in counts; None if what is there cannot be.
        name: Name of the external file, kept where the image has been embedded since, if it is known.
        beside: For depth in a scan that has its time from another image: the name of that one's file, empty
            if it is embedded.

    """

    stream: str
    ticks: int
    label: str
    file: str | None = None
    image: Record | None = None
    scan: Record | None = None
    units_per_metre: float | None = None
    name: str | None = None
    beside: str | None = None

    @property
    def stamp(self) -> int:
        """Time of the observation in nanoseconds."""
        return ticks_to_stamp(self.ticks)

    @property
    def nbytes(self) -> int:
        """Bytes embedded in the rawlog."""
        if self.image is not None:
            return max(self.image.array(name).nbytes for name in ("data", "zlib", "jpeg"))
        return 0 if self.scan is None else _embedded_range(self.scan).nbytes

    def detached(self) -> Picture:
        """Return the picture without anything else of its observation, and not as a view of the file."""
        if self.image is not None:
            return replace(self, image=_copied(self.image, *self.image.fields))
        if self.scan is None:
            return self
        matrix = self.scan.child("range_matrix")
        scan = _copied(self.scan, "rows", "columns", "range")
        if matrix is not None:
            scan.fields["range_matrix"] = _copied(matrix, *matrix.fields)
        return replace(self, scan=scan)

    def load(self, folder: externals.Folder, exact_units_per_metre: float | None = None) -> Image:
        """Decode the image, or wrap the file that it is.

        Args:
            folder: Of the external files.
            exact_units_per_metre: Float depth that holds exactly such counts becomes counts again.

        Raises:
            InputError: It is missing or damaged.

        """
        if self.stream == "depth":
            return self._load_depth(folder, exact_units_per_metre)
        if self.file is not None:
            data = folder.read(self.file)
            try:
                return replace(_image_of_file(data), origin=folder.locate(self.file))
            except InputError as error:
                path, place, hint = folder.locate(self.file), error.location, error.hint
                raise type(error)(error.message, path=path, location=place, hint=hint) from error
        if self.image is None:
            raise InputError("the observation holds no image", path=folder.rawlog)
        where = f"image at offset {self.image.offset}"
        try:
            return replace(_image_of_record(self.image), origin=f"{folder.rawlog}, {where}")
        except (InputError, ValueError) as error:
            raise InputError(f"damaged image ({error})", path=folder.rawlog, location=where) from error

    def _load_depth(self, folder: externals.Folder, exact_units_per_metre: float | None) -> Image:
        values: npt.NDArray[np.generic]
        if self.file is not None:
            values = externals.read_depth(folder, self.file)
        elif self.scan is not None:
            values = _embedded_range(self.scan)
        else:
            raise InputError("the observation holds no depth", path=folder.rawlog)
        if not values.size:
            place = folder.rawlog if self.file is None else folder.locate(self.file)
            raise InputError(f"the depth image has no pixels ({values.shape[0]} rows)", path=place)
        check_size(values.shape[1], values.shape[0])
        if values.dtype == np.uint16:
            return image_of_pixels(values, "16UC1", self.units_per_metre or 1 / _DEFAULT_UNITS)
        metres = values.astype(np.float32, copy=False)
        if exact_units_per_metre is not None:
            counts = exact_counts(metres, exact_units_per_metre, nan=False)
            if counts is not None:
                return image_of_pixels(counts, "16UC1", exact_units_per_metre)
        return image_of_pixels(np.where(metres == 0, np.float32(np.nan), metres), "32FC1", _METRES)


def _copied(record: Record, *names: str) -> Record:
    """Return a record with some of its fields, their arrays copied."""
    there = {name: record.fields[name] for name in names if name in record}
    fields = {name: value.copy() if isinstance(value, np.ndarray) else value for name, value in there.items()}
    return replace(record, fields=fields)


def pictures_of(record: Record) -> Iterator[Picture]:
    """Yield the images of an observation, colour first; none of other objects."""
    if record.type == "CObservation3DRangeScan":
        yield from _pictures_of_scan(record)
    elif record.type == "CObservationImage" and (image := _usable(record.child("image"))):
        yield _picture_of_image(image, "rgb", record)


def _pictures_of_scan(scan: Record) -> Iterator[Picture]:
    image = _usable(scan.child("intensity"))
    if image is not None:
        yield _picture_of_image(image, "ir" if scan.integer("channel") == _INFRARED else "rgb", scan)
    embedded, external = bool(_embedded_range(scan).size), scan.integer("range_external")
    name = scan.text("range_file")
    if not embedded and not (scan.integer("has_range") and external and name):
        return
    yield Picture(
        "depth",
        scan.integer("time"),
        scan.text("label"),
        file=None if embedded else name,
        scan=scan if embedded else None,
        units_per_metre=units_per_metre(scan.number("range_units", _DEFAULT_UNITS)),
        name=name or None,
        beside=None if image is None else image.text("file"),
    )


def nameless(record: Record) -> Iterator[str]:
    """Name the images of an observation that are said to be in a file whose name is empty."""
    name = {"CObservation3DRangeScan": "intensity", "CObservationImage": "image"}.get(record.type)
    image = record.child(name) if name else None
    if image is not None and image.integer("external") and not image.text("file"):
        yield "image"
    if (
        record.integer("has_range")
        and record.integer("range_external")
        and not record.text("range_file")
        and not _embedded_range(record).size
    ):
        yield "depth image"


def empty(record: Record) -> Iterator[str]:
    """Name the images that an observation should hold and does not."""
    name = {"CObservation3DRangeScan": "intensity", "CObservationImage": "image"}.get(record.type)
    if name is None:
        return
    image = record.child(name)
    should_be = name == "image" or record.integer("has_intensity")
    if should_be and _usable(image) is None and not (image is not None and image.integer("external")):
        yield EMPTY_IMAGE
    if (
        record.integer("has_range")
        and not record.integer("range_external")
        and not _embedded_range(record).size
    ):
        yield EMPTY_DEPTH_IMAGE


def _picture_of_image(image: Record, stream: str, owner: Record) -> Picture:
    time, label = owner.integer("time"), owner.text("label")
    if image.integer("external"):
        return Picture(stream, time, label, file=image.text("file"), name=image.text("file"))
    return Picture(stream, time, label, image=image)


def _usable(image: Record | None) -> Record | None:
    """Return the image if it is one: not empty, and not null."""
    if image is None or image.type != "CImage":
        return None
    there = image.text("file") or any(image.array(name).size for name in ("data", "zlib", "jpeg"))
    return image if there else None


def units_per_metre(range_units: float) -> float | None:
    """Return counts per metre of a `rangeUnits`, the whole number where the float32 means one.

    None if no sensor has it: zero, negative, not a number, or beyond all measure.
    """
    if not _PLAUSIBLE_UNITS[0] <= range_units <= _PLAUSIBLE_UNITS[1]:
        return None
    whole = round(1 / range_units)
    if whole and np.float32(1 / whole) == np.float32(range_units):
        return float(whole)
    return 1 / range_units


def _embedded_range(scan: Record) -> npt.NDArray[np.generic]:
    """Return the embedded depth, shape [rows, columns]: uint16 counts or float32 metres; may be empty."""
    holder = scan if scan.array("range").size else scan.child("range_matrix")
    if holder is None or (holder is not scan and holder.type not in _MATRICES):
        return np.empty((0, 0), np.uint16)
    values = holder.array("range" if holder is scan else "values")
    if values.dtype == np.float64:
        values = values.astype(np.float32)
    return values.reshape(holder.integer("rows"), holder.integer("columns"))


def _image_of_file(data: bytes) -> Image:
    if data.startswith(SIGNATURE):
        return image_of_png(data)
    if data.startswith(_JPEG_MAGIC):
        return image_of_jpeg(data)
    from tumtools.images.pillow import pixels_of_file  # noqa: PLC0415 - brings Pillow

    return image_of_pixels(*pixels_of_file(data))


def _image_of_record(image: Record) -> Image:
    jpeg = image.array("jpeg")
    if jpeg.size:
        found = image_of_jpeg(jpeg.tobytes())
        announced = image.integer("width", found.width), image.integer("height", found.height)
        if announced != (found.width, found.height):
            raise InputError(
                f"a JPEG file of {found.width} x {found.height} pixels in an image of "
                f"{announced[0]} x {announced[1]}"
            )
        return found
    if image.version == 0:
        return _first_version(image)
    if image.integer("colour"):
        shape = abs(image.integer("height")), abs(image.integer("width")), 3
        check_size(*shape[:2])
        return image_of_pixels(image.array("data").reshape(shape), "rgb8" if image.version >= 10 else "bgr8")  # noqa: PLR2004 - since MRPT 3
    return _grey(image)


def _first_version(image: Record) -> Image:
    channels = image.integer("channels")
    if channels not in {1, 3}:
        raise UnsupportedInputError(f"images with {channels} channels are not read")
    shape = (image.integer("height"), image.integer("width"), channels)
    check_size(*shape[:2])
    pixels = image.array("data").reshape(shape)
    if not image.integer("origin_top_left"):
        pixels = pixels[::-1]
    return image_of_pixels(pixels[:, :, 0], "mono8") if channels == 1 else image_of_pixels(pixels, "bgr8")


def _grey(image: Record) -> Image:
    """Decode a grey image; rows may be padded."""
    code = image.integer("pixel_type")
    if not 0 <= code < len(DEPTH_CODES) or DEPTH_CODES[code] not in {"u1", "<u2"}:
        raise UnsupportedInputError(
            f"grey images with pixels of type {code} are not read, only 8 and 16 bits"
        )
    dtype = np.dtype(DEPTH_CODES[code])
    width, height, size = image.integer("width"), image.integer("height"), image.integer("byte_count")
    data = image.array("data")
    check_size(width, height)
    if image.array("zlib").size:
        if not 0 <= size <= archive.MAX_FIELD:
            raise InputError(f"a grey image of {size} bytes")
        take_room(size)
        try:
            inflated = zlib.decompressobj().decompress(image.array("zlib").tobytes(), size + 1)
        except zlib.error as error:
            raise InputError(f"damaged zlib data ({error})") from error
        data = np.frombuffer(inflated, np.uint8)
    if (
        width < 1
        or height < 1
        or data.size != size
        or size % height
        or size // height < width * dtype.itemsize
    ):
        raise InputError(
            f"a grey image of {width} x {height} pixels and {data.size} bytes ({size} announced)"
        )
    rows = data.reshape(height, size // height)[:, : width * dtype.itemsize]
    pixels = np.ascontiguousarray(rows).view(dtype)
    if image.integer("origin"):
        pixels = pixels[::-1]
    return image_of_pixels(pixels, "mono8" if dtype.itemsize == 1 else "mono16")
