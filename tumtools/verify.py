# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Read back what was written and hold it against what the writer was given.

Everything is compared but what the writer has said it altered; of a stream with such a loss, all the rest.
The result is read with the reader of its format. An image that is the same PNG file, or has the same pixels
in the same encoding, is the same image, and nothing more is decoded or converted.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeVar

import numpy as np

from tumtools.errors import InternalError
from tumtools.fingerprint import Fingerprint, Recorded, fingerprint, full_fingerprint, is_same
from tumtools.formats.cameras import chosen_calibration, known_camera
from tumtools.formats.options import WriteOptions
from tumtools.formats.ros.layouts import is_default_frame
from tumtools.formats.tum.text import render
from tumtools.images.parallel import batch_of, ordered_map
from tumtools.model.sequence import IMAGE_STREAMS, Frame, Sequence
from tumtools.model.time import NANOSECONDS_PER_SECOND, format_stamp

if TYPE_CHECKING:
    from collections.abc import Callable

    import numpy.typing as npt

    from tumtools.formats.options import Progress
    from tumtools.model.sequence import Loss, Part
    from tumtools.model.signals import Accelerometer, Trajectory

Key = TypeVar("Key")


@dataclass(frozen=True, slots=True)
class _Altered:
    """What the writer has said it altered."""

    losses: tuple[Loss, ...]

    def has(self, part: Part, stream: str | None = None) -> bool:
        """Tell whether a part is altered, of a stream or of any."""
        return any(part in loss.alters for loss in self.losses if stream in {None, loss.stream})

    def count(self, part: Part, stream: str) -> int:
        return sum(loss.count for loss in self.losses if part in loss.alters and loss.stream == stream)

    def rows(self, stream: str, written: int) -> int:
        """Return how many rows are left of those that were written."""
        return written - self.count("rows dropped", stream) + self.count("rows repeated", stream)

    def moves(self, stream: str) -> bool:
        """Tell whether a row of the result may not have its number or its stamp any more."""
        return any(self.has(part, stream) for part in ("rows dropped", "rows repeated", "stamps"))

    def stamp_limit(self, stream: str) -> int:
        """Return by how many nanoseconds a stamp may be off."""
        found = [one for one in self.losses if "stamps" in one.alters and one.stream == stream]
        return max((round((one.largest_error or 0) * NANOSECONDS_PER_SECOND) for one in found), default=0)


def verify(
    written: Recorded,
    result: Sequence,
    losses: tuple[Loss, ...] = (),
    options: WriteOptions | None = None,
    *,
    keeps_name: bool = True,
    jobs: int = 2,
    progress: Progress,
) -> None:
    """Check that a result holds everything that was written.

    Args:
        written: What the writer was given, after it has run.
        result: What the reader of the target's format makes of the target.
        losses: What the writer has reported; what they do not alter is compared.
        options: Those of the writer, which may ask for other calibrations and frame ids.
        keeps_name: Whether the target tells the name of the sequence, whatever it is called itself.
        jobs: Threads.
        progress: Told of each image.

    Raises:
        InternalError: It does not: a bug of the writer or the reader.
        InputError: The result is not readable.

    """
    altered = _Altered(losses)
    for stream in IMAGE_STREAMS:
        _verify_image_rows(stream, written, result, altered)
    _verify_signal("accelerometer", written.accelerometer, result.accelerometer, altered)
    _verify_signal("groundtruth", written.groundtruth, result.groundtruth, altered)
    _verify_texts(written, result, altered)
    _verify_header(written, result, altered, options or WriteOptions(), keeps_name=keeps_name)
    _verify_images(written, result, altered, jobs, progress)
    if written.noted_digest() is not None and result.info.digest != written.noted_digest():
        raise _bug("the digest that it keeps is not that of what was written")


# --- images -------------------------------------------------------------------------------------------


def _verify_image_rows(stream: str, written: Sequence, result: Sequence, altered: _Altered) -> None:
    expected, found = written.image_stamps(stream), result.image_stamps(stream)
    rows = altered.rows(stream, len(expected))
    _check_presence(stream, stream in written.info.images, stream in result.info.images, rows)
    _check_count(stream, rows, len(found))
    if not altered.moves(stream):
        _check_equal(stream, "stamps", expected, found)


def _verify_images(
    written: Recorded, result: Sequence, altered: _Altered, jobs: int, progress: Progress
) -> None:
    moved = {stream for stream in written.info.images if altered.moves(stream)}
    decoded = {stream for (stream, _), seen in written.fingerprints.items() if seen.png is None}
    found: dict[str, list[tuple[int, Fingerprint]]] = {stream: [] for stream in moved}

    def check(frame: Frame) -> tuple[Frame, int, Fingerprint | None]:
        image = frame.load()
        if frame.stream in moved:
            return frame, image.nbytes, (full_fingerprint if frame.stream in decoded else fingerprint)(image)
        expected = written.fingerprints.get((frame.stream, frame.row))
        if not altered.has("pixels", frame.stream) and (expected is None or not is_same(image, expected)):
            raise _bug(
                f"the {frame.stream} image at {format_stamp(frame.stamp, 9)} differs from what was written"
            )
        return frame, image.nbytes, None

    for frame, nbytes, seen in ordered_map(
        check, result.images([*written.info.images]), jobs, batch=batch_of(written)
    ):
        if seen is not None:
            found[frame.stream].append((frame.stamp, seen))
        progress(1, nbytes)
    for stream in sorted(moved):
        rows = enumerate(written.image_stamps(stream).tolist())
        given = [(stamp, written.fingerprints.get((stream, row), Fingerprint())) for row, stamp in rows]
        same = _anything if altered.has("pixels", stream) else Fingerprint.same
        _check_in_order(stream, given, found[stream], same, altered)


def _anything(one: object, other: object) -> bool:
    del one, other
    return True


# --- signals ------------------------------------------------------------------------------------------


def _verify_signal(
    name: str,
    written: Accelerometer | Trajectory | None,
    found: Accelerometer | Trajectory | None,
    altered: _Altered,
) -> None:
    rows = altered.rows(name, 0 if written is None else len(written))
    _check_presence(name, written is not None, found is not None, rows)
    _check_count(name, rows, 0 if found is None else len(found))
    if written is None or found is None:
        return
    if altered.moves(name):
        one, other = (
            list(zip(s.stamps.tolist(), map(bytes, s.values), strict=True)) for s in (written, found)
        )
        _check_in_order(name, one, other, bytes.__eq__, altered)
        return
    _check_equal(name, "stamps", written.stamps, found.stamps)
    _check_equal(name, "values", written.values, found.values)


# --- rows ---------------------------------------------------------------------------------------------


def _check_presence(stream: str, written: bool, found: bool, rows: int) -> None:
    """Refuse a stream that is missing, unless all its rows are said to be dropped, or that is new."""
    if found and not written:
        raise _bug(f"{stream} is there without having been written")
    if written and not found and rows:
        raise _bug(f"{stream} is missing")


def _check_count(stream: str, expected: int, found: int) -> None:
    if expected != found:
        raise _bug(f"{stream} has {found} rows, {expected} were written")


def _check_equal(
    stream: str, what: str, expected: npt.NDArray[np.generic], found: npt.NDArray[np.generic]
) -> None:
    differing = expected != found
    if expected.dtype.kind == "f":  # -0.0 is not 0.0, and any NaN is another one
        differing |= np.signbit(expected) != np.signbit(found)
        differing &= ~(np.isnan(expected) & np.isnan(found))
    if differing.any():
        rows = np.flatnonzero(differing.reshape(len(expected), -1).any(axis=1))
        raise _bug(f"{what} of {stream} differ in {len(rows)} rows, first in row {rows[0]}")


def _check_in_order(
    stream: str,
    written: list[tuple[int, Key]],
    found: list[tuple[int, Key]],
    same: Callable[[Key, Key], bool],
    altered: _Altered,
) -> None:
    """Check that each row is one that was written, in order of time, its stamp off by no more than was said.

    Args:
        stream: For the message.
        written: Stamp and content of each row.
        found: The same of the result.
        same: Whether two contents are the same.
        altered: Whether rows may come again, and how far stamps may be off.

    """
    limit, repeats = altered.stamp_limit(stream), altered.has("rows repeated", stream)
    given = sorted(written, key=lambda row: row[0])
    place = 0
    for stamp, content in sorted(found, key=lambda row: row[0]):
        while place < len(given) and not (
            abs(given[place][0] - stamp) <= limit and same(given[place][1], content)
        ):
            place += 1
        if place == len(given):
            raise _bug(f"what {stream} has at {format_stamp(stamp, 9)} was not written there")
        place += not repeats


# --- text and header ----------------------------------------------------------------------------------


def _verify_texts(written: Sequence, result: Sequence, altered: _Altered) -> None:
    for stream, layout in written.info.text.items():
        after = result.info.text.get(stream)
        if altered.has("text", stream) or altered.moves(stream) or after == layout:
            continue  # said to be altered, or the rows are the same already
        stamps, values = _columns(written, stream)
        if after is None or render(layout, stream, stamps, values) != render(after, stream, stamps, values):
            raise _bug(f"the text of {stream} would not come back as it was")


def _columns(sequence: Sequence, stream: str) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.float64]]:
    if stream in IMAGE_STREAMS:
        stamps = sequence.image_stamps(stream)
        return stamps, np.empty((len(stamps), 0))
    signal = sequence.groundtruth if stream == "groundtruth" else sequence.accelerometer
    return (np.empty(0, np.int64), np.empty((0, 0))) if signal is None else (signal.stamps, signal.values)


def _verify_header(
    written: Sequence, result: Sequence, altered: _Altered, options: WriteOptions, *, keeps_name: bool
) -> None:
    """Compare what is beside the data: name, licence, camera, calibrations, frame ids."""
    given, found = written.info, result.info
    if keeps_name and not altered.has("name"):
        _check_same("name", _as_utf8(given.name), found.name)
    if given.licence is not None and not altered.has("licence"):
        _check_same("licence", (given.licence, given.citation), (found.licence, found.citation))
    camera = known_camera(written, options)
    if camera is not None and not altered.has("camera"):
        _check_same("camera", camera, found.camera)
    for stream, image in found.images.items():
        # What is written for a camera that nobody knows is an assumption, which nothing hangs on.
        own = stream in options.cameras.keys() | written.cameras.keys()
        known = own or camera is not None
        if known and image.width and not altered.has("camera") and not altered.has("calibration", stream):
            size = image.width, image.height
            expected = chosen_calibration(written, options, stream, *size)
            _check_same(
                f"calibration of {stream}",
                expected,
                chosen_calibration(result, WriteOptions(), stream, *size),
            )
    asked = {**given.frame_ids, **options.frame_ids}
    for stream in sorted(asked.keys() | found.frame_ids.keys()):
        name = asked.get(stream)
        if _has_rows(written, stream) and not altered.has("frame id", stream):
            expected_name = None if name is None or is_default_frame(name) else name
            _check_same(f"frame id of {stream}", expected_name, found.frame_ids.get(stream))


def _has_rows(sequence: Sequence, stream: str) -> bool:
    """Tell whether there are messages that say what their frame is."""
    signal = {"groundtruth": sequence.groundtruth, "accelerometer": sequence.accelerometer}.get(stream)
    return len(sequence.image_stamps(stream) if signal is None else signal) > 0


def _check_same(what: str, expected: object, found: object) -> None:
    if expected != found:
        raise _bug(f"the {what} is {found!r}, {expected!r} was written")


def _as_utf8(text: str) -> str:
    """Return a name as containers hold it; that of a file may be no UTF-8."""
    return text.encode("utf-8", "backslashreplace").decode()


def _bug(message: str) -> InternalError:
    return InternalError(
        f"verification failed: {message}", hint="nothing was left under the target's name; please report this"
    )
