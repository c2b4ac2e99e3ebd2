# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""TUM101 to TUM106: stamps as they stand in each stream."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Final

import numpy as np

from tumtools.model.time import format_stamp, parse_stamp
from tumtools.validate.finding import Place, Severity
from tumtools.validate.rule import Found, Limit, rule
from tumtools.validate.subject import ProblemKind

if TYPE_CHECKING:
    from collections.abc import Iterator

    import numpy.typing as npt

    from tumtools.validate.rule import Limits
    from tumtools.validate.subject import Subject

    Stamps = npt.NDArray[np.int64]

MIN_ROWS: Final = 10
"""Fewer rows say nothing about a rate."""
_FLOAT32_STEP: Final = 64 * 10**9
"""Distance of neighbouring float32 at seconds since 1970, in nanoseconds (128 s from 2^30 s on)."""
_FLOAT64_STEP: Final = 240
"""The same of float64, rounded up."""
_MICROSECOND: Final = 1000
_EARLIEST: Final = 946_684_800
_LATEST: Final = 4_102_444_800
"""Seconds since 1970 of the years 2000 and 2100."""
_SCALES: Final = ((10**3, "milliseconds"), (10**6, "microseconds"), (10**9, "nanoseconds"))
_SHOWN_DECIMALS: Final = 6


def _text_of(stamp: int) -> str:
    return format_stamp(stamp, 9).rstrip("0").rstrip(".")


def is_recording(subject: Subject, stream: str) -> bool:
    """Whether a stream comes at the rate of a sensor; estimates come as their program likes."""
    return not (subject.is_estimate and stream == "groundtruth")


def median_period(stamps: Stamps) -> float:
    """Median step of the distinct stamps, nanoseconds; 0 for too few of them."""
    distinct = np.unique(stamps)
    return float(np.median(np.diff(distinct))) if len(distinct) >= MIN_ROWS else 0.0


def went_through_float32(stamps: Stamps) -> bool:
    """Whether all stamps are numbers of seconds that a float32 holds."""
    return len(stamps) >= MIN_ROWS and not (stamps % _FLOAT32_STEP).any() and bool(stamps.all())


@rule(
    "TUM101",
    "stamp-not-increasing",
    Severity.ERROR,
    title="A stamp goes backwards.",
    why="Readers that search by bisection, and all that integrate over time, go wrong.",
    how="Each stamp is compared with the one of the row before.",
    mend="Sort the rows (`validate --fix`); if a clock was set during the recording, record again.",
    fixable=True,
)
def stamp_not_increasing(subject: Subject, limits: Limits) -> Iterator[Found]:
    """Compare neighbours."""
    del limits
    for stream, stamps in subject.all_stamps.items():
        for row in (np.flatnonzero(stamps[1:] < stamps[:-1]) + 1).tolist():
            back = (int(stamps[row - 1]) - int(stamps[row])) / 1e9
            yield Found(
                f"the stamp {_text_of(int(stamps[row]))} is {back:.6f} s before that of the row before",
                subject.place(stream, row),
            )


@rule(
    "TUM102",
    "stamp-repeated",
    Severity.WARNING,
    title="The same stamp stands in more than one row.",
    why="Readers that keep rows in a dictionary drop all but the last of them without a word.",
    how=(
        "Equal stamps are counted. The published ground truth of the second camera has up to ten: 300 Hz "
        "printed with four decimals."
    ),
    mend="Print more decimals; remove rows that are repeated as a whole.",
)
def stamp_repeated(subject: Subject, limits: Limits) -> Iterator[Found]:
    """Count equal stamps."""
    del limits
    for stream, stamps in subject.all_stamps.items():
        order = np.argsort(stamps, kind="stable")
        again = np.sort(order[1:][np.diff(stamps[order]) == 0])
        if len(again):
            first = int(again[0])
            rows = "1 row repeats" if len(again) == 1 else f"{len(again)} rows repeat"
            yield Found(
                f"{rows} the stamp of another; the first is {_text_of(int(stamps[first]))}",
                subject.place(stream, first),
                measured=str(len(again)),
                expected="0",
            )


@rule(
    "TUM103",
    "stamp-gap",
    Severity.WARNING,
    title="A gap in a stream: frames or rows were dropped.",
    why="Interpolating over a gap gives wrong poses; trackers lose the camera there.",
    how="Steps between sorted stamps are compared with their median.",
    mend="Nothing to mend in a recording; leave the time out of an evaluation.",
    limits={
        "periods": Limit(5, "median periods", "longest step that is no gap"),
        "seconds": Limit(0.05, "s", "no shorter step is a gap, whatever the rate"),
    },
)
def stamp_gap(subject: Subject, limits: Limits) -> Iterator[Found]:
    """Look for long steps."""
    for stream, stamps in subject.all_stamps.items():
        period = median_period(stamps)
        if not period or not is_recording(subject, stream) or went_through_float32(stamps):
            continue
        order = np.argsort(stamps, kind="stable")
        steps = np.diff(stamps[order])
        shortest = max(limits["periods"] * period, limits["seconds"] * 1e9)
        for index in np.flatnonzero(steps > shortest).tolist():
            dropped = round(int(steps[index]) / period) - 1
            yield Found(
                f"a gap of {int(steps[index]) / 1e9:.3f} s before this row: about {dropped} rows are missing",
                subject.place(stream, int(order[index + 1])),
                measured=f"{int(steps[index]) / 1e9:.6f} s",
                expected=f"{period / 1e9:.6f} s",
            )


@rule(
    "TUM104",
    "stamp-name-mismatch",
    Severity.ERROR,
    title="The file name of an image and its stamp in the list differ.",
    why="Half of all readers take the stamp from the name, the other half from the list.",
    how=(
        "The name without folder and suffix is read as a stamp and compared with the list's, to "
        "the nanosecond."
    ),
    mend="Rename the file or correct the row.",
)
def stamp_name_mismatch(subject: Subject, limits: Limits) -> Iterator[Found]:
    """Compare names and stamps."""
    del limits
    for stream, names in subject.names.items():
        stamps = subject.stamps[stream]
        if went_through_float32(stamps) or not subject.texts[stream].is_sound:
            continue
        implausible = _implausible(stamps).tolist()
        for row, (name, stamp) in enumerate(zip(names, stamps.tolist(), strict=True)):
            named = _stamp_of_name(name)
            if named == stamp or implausible[row]:  # the latter is TUM105
                continue
            place = subject.place(stream, row)
            if named is None:
                message = f"the name {name} holds no stamp; the list says {_text_of(stamp)}"
                yield Found(message, place, severity=Severity.WARNING)
            else:
                yield Found(f"the list says {_text_of(stamp)}, the file is named {name}", place)


def _stamp_of_name(name: str) -> int | None:
    """Read the stamp in a file name; images with the same stamp may end with -1, -2 and so on."""
    stem = re.sub(r"\.[A-Za-z]+$", "", name.rpartition("/")[2])
    match = re.fullmatch(r"(\d+\.\d+)(-\d+)?", stem)
    try:
        return None if match is None else parse_stamp(match[1])
    except ValueError:
        return None


@rule(
    "TUM105",
    "stamp-implausible",
    Severity.ERROR,
    title="Stamps are not seconds since 1970.",
    why="Streams with different clocks cannot be brought together; a factor of 1000 stops every association.",
    how="Stamps must lie in the years 2000 to 2100. For others it is tried what they may be.",
    mend="Convert them to seconds since 1970.",
)
def stamp_implausible(subject: Subject, limits: Limits) -> Iterator[Found]:
    """Compare with the range of plausible dates."""
    del limits
    for stream, text in subject.texts.items():
        problems = text.problems(ProblemKind.STAMP)
        if problems:
            token = problems[0].text.split(",")[0].split()[0]
            share = "" if len(problems) == 1 else f" ({len(problems)} rows)"
            message = f"{token} is no number of seconds since 1970{share}: {_guess_text(token)}"
            yield Found(message, Place(text.name, problems[0].line, stream))
    for stream, stamps in subject.all_stamps.items():
        wrong = np.flatnonzero(_implausible(stamps))
        if len(wrong):
            row = int(wrong[0])
            share = "" if len(wrong) == 1 else f" ({len(wrong)} of {len(stamps)} rows)"
            guess = _guess_small(stamps[wrong])
            yield Found(
                f"{_text_of(int(stamps[row]))} is not in the years 2000 to 2100{share}: {guess}",
                subject.place(stream, row),
            )


def _implausible(stamps: Stamps) -> npt.NDArray[np.bool_]:
    wrong: npt.NDArray[np.bool_] = (stamps < _EARLIEST * 10**9) | (stamps > _LATEST * 10**9)
    return wrong


def _guess_text(token: str) -> str:
    try:
        value = float(token)
    except ValueError:
        return "it looks like a date"
    for scale, unit in _SCALES:
        if _EARLIEST <= value / scale <= _LATEST:
            return f"it looks like {unit}"
    return "it is before the year 1678" if value < 0 else "it is beyond the year 2262"


def _guess_small(stamps: Stamps) -> str:
    steps = np.diff(stamps)
    if len(stamps) >= MIN_ROWS and (steps == 10**9).all():
        return "it looks like frame numbers"
    if (stamps >= 0).all() and (stamps < 10**5 * 10**9).all():
        return "it looks like seconds since the start of the recording"
    return "no usual unit fits"


@rule(
    "TUM106",
    "stamp-precision",
    Severity.WARNING,
    title="Stamps have too few decimals, or went through a float on their way.",
    why="float32 has steps of 128 s at today's stamps, float64 of 0.24 microseconds; names no longer match.",
    how=(
        "The last decimal must be below a tenth of the stream's period. Stamps that are all "
        "multiples of 64 s "
        "went through float32; stamps that all lie within 0.24 microseconds of a whole "
        "microsecond, but not on "
        "it, went through float64."
    ),
    mend="Print the original stamps as text or integers, with six decimals or more.",
    limits={"share_of_period": Limit(0.1, "periods", "coarsest last decimal")},
)
def stamp_precision(subject: Subject, limits: Limits) -> Iterator[Found]:
    """Look at the digits."""
    for stream, stamps in subject.all_stamps.items():
        if not is_recording(subject, stream) or len(stamps) < MIN_ROWS:
            continue
        place = subject.stream_place(stream)
        if went_through_float32(stamps):
            yield Found("all stamps are multiples of 64 s: they went through float32", place)
            continue
        off = np.abs((stamps + _MICROSECOND // 2) % _MICROSECOND - _MICROSECOND // 2)
        if (off < _FLOAT64_STEP).all() and (off > 0).mean() > 0.5:  # noqa: PLR2004 - most of them
            yield Found("stamps lie just beside whole microseconds: they went through float64", place)
            continue
        digits = next(n for n in range(10) if not (stamps % 10 ** (9 - n)).any())
        period = median_period(stamps)
        if period and 10 ** (9 - digits) > limits["share_of_period"] * period:
            yield Found(
                f"{digits} decimals are too few for a period of {period / 1e6:.1f} ms",
                place,
                measured=f"{10.0**-digits:g} s",
                expected=f"at most {limits['share_of_period'] * period / 1e9:.2g} s",
            )


RULES = (
    stamp_not_increasing,
    stamp_repeated,
    stamp_gap,
    stamp_name_mismatch,
    stamp_implausible,
    stamp_precision,
)
