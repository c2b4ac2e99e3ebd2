# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Convert along a chain of formats, and hold every result against its source.

Each step must lose exactly what is expected (`tests/roundtrip/expectations.py`), say so, and leave all else
the same: digests, values, pixels, text. A chain that loses nothing must end where it began.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from tests.roundtrip.expectations import Expected, expected, key_of
from tumtools.convert import ConvertOptions, convert
from tumtools.diff import diff
from tumtools.digest import Digest, digest
from tumtools.model.image import ENCODINGS
from tumtools.sources import open_source

if TYPE_CHECKING:
    from pathlib import Path

    from tests.roundtrip.variants import Chain, Variant
    from tumtools.model.sequence import Loss, Sequence

BYTES_PER_ROW: Final = {"accelerometer": 32, "groundtruth": 64}


@dataclass(frozen=True)
class Outcome:
    """What came of a cell.

    Attributes:
        steps: Losses of each step, empty if there were none.
        asked: (stream, what) of differences that the options ask for.
        images: Pairs of images compared.
        pixels: Pixels compared.
        nbytes: Bytes of pixels and rows compared.

    """

    steps: tuple[tuple[Loss, ...], ...]
    images: int
    pixels: int
    nbytes: int
    asked: frozenset[tuple[str, str]] = frozenset()

    def __add__(self, other: Outcome) -> Outcome:
        """Return the outcome of two steps, one after the other."""
        return Outcome(
            self.steps + other.steps,
            self.images + other.images,
            self.pixels + other.pixels,
            self.nbytes + other.nbytes,
            self.asked | other.asked,
        )


def run(chain: Chain, first: Path, folder: Path) -> Outcome:
    """Convert along a chain and check every step.

    Args:
        chain: The first variant is that of the source.
        first: The source.
        folder: Where to write; each step into a folder of its own, under the name of the source.

    Raises:
        AssertionError: Something was lost without being reported, or reported without being expected.

    """
    outcome = Outcome((), 0, 0, 0)
    source = first
    for number, variant in enumerate(chain[1:], 1):
        target = folder / str(number) / f"sequence{variant.suffix}"
        with open_source(source) as before:
            outcome += write_and_check(before, target, variant)
        source = target
    if chain[0] == chain[-1] and not any(outcome.steps) and not outcome.asked:
        with open_source(first) as before, open_source(source) as after:
            assert digest(before, jobs=1) == digest(after, jobs=1)
            assert diff(before, after, jobs=1).differences == ()
    return outcome


def write_and_check(before: Sequence, target: Path, variant: Variant) -> Outcome:
    """Convert once and check the result.

    Raises:
        AssertionError: Something was lost without being reported, or reported without being expected.

    """
    wanted = expected(variant, before)
    dry = ConvertOptions(dry_run=True)
    foretold = convert(before, target, variant.format, variant.write_options, dry).losses
    report = convert(before, target, variant.format, variant.write_options)
    assert report.verified
    assert foretold == report.losses, "a dry run tells something else"
    found = [key_of(loss) for loss in report.losses if loss not in before.info.not_carried]
    assert sorted(map(str, found)) == sorted(map(str, wanted.losses.elements()))
    with open_source(target) as after:
        assert after.info.not_carried == (), "it wrote what it does not read"
        images, pixels, nbytes = check_same(before, after, wanted)
    return Outcome((report.losses,), images, pixels, nbytes, wanted.asked)


def check_same(before: Sequence, after: Sequence, wanted: Expected) -> tuple[int, int, int]:
    """Check that two sequences differ in what is expected and in nothing else."""
    # Without a header line that says otherwise, a sequence in this layout is called as its folder.
    names = {before.info.name, "sequence"} if after.info.format == "tum" else {before.info.name}
    assert after.info.name in names or wanted.losses
    one, other = digest(before, jobs=1), digest(after, jobs=1)
    changed = {
        name for name in one.streams | other.streams if one.streams.get(name) != other.streams.get(name)
    }
    assert changed == wanted.changed
    result = diff(before, after, jobs=1)
    lossy = {stream for stream, *_ in wanted.losses}
    unexpected = [
        found
        for found in result.differences
        if found.stream not in lossy and (found.stream, found.what) not in wanted.asked
    ]
    assert unexpected == [], unexpected
    assert wanted.asked <= {(found.stream, found.what) for found in result.differences}
    return result.images, result.pixels, _bytes(before, one)


def _bytes(sequence: Sequence, found: Digest) -> int:
    """Return how many bytes went into a digest."""
    total = sum(stream.count * BYTES_PER_ROW.get(name, 8) for name, stream in found.streams.items())
    for name, info in sequence.info.images.items():
        per_pixel = 4 if name == "depth" else ENCODINGS[info.encoding or "rgb8"].bytes_per_pixel
        total += info.count * info.width * info.height * per_pixel
    return total
