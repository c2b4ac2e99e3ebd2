# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Whatever stands in the text files, there are findings or errors of ours, and nothing else."""

from __future__ import annotations

import os
from random import Random

from hypothesis import given, settings
from hypothesis import strategies as st

from tumtools.errors import TumtoolsError
from tumtools.formats.tum.text import parse
from tumtools.model.sequence import IMAGE_STREAMS, SequenceInfo
from tumtools.model.signals import Accelerometer, Trajectory
from tumtools.validate.engine import check
from tumtools.validate.settings import Settings
from tumtools.validate.subject import Subject, TextFile

EXAMPLES = int(os.environ.get("TUMTOOLS_FUZZ_EXAMPLES", "300"))
STREAMS = ("rgb", "depth", "groundtruth", "accelerometer")
WORDS = [
    "0",
    "-1",
    "1e300",
    "nan",
    "inf",
    "-inf",
    "1e-300",
    "0.5",
    "",
    "abc",
    "1305031102175304000",
    "9" * 50,
]
NAMES = ["rgb/1.png", "../x", "/etc/passwd", "a b", "depth/1305031102.000000.png"]
SEPARATORS = [" ", "\t", ",", "  "]
MOST_ROWS, MOST_COLUMNS, MOST_BYTES = 40, 9, 300


def stamp_of(number: int) -> str:
    """Return a stamp like those of fr1; some come again."""
    return f"13050311{number % 100:02d}.{number * 7919 % 10**6:06d}"


NUMBERS = st.one_of(
    st.sampled_from(WORDS), st.floats(width=32).map(repr), st.integers(-(10**20), 10**20).map(str)
)
STAMPS = st.one_of(NUMBERS, st.integers(0, 2000).map(stamp_of), st.just("2011-05-10"))
LINE = st.tuples(STAMPS, st.lists(NUMBERS, max_size=MOST_COLUMNS), st.sampled_from(SEPARATORS)).map(
    lambda parts: parts[2].join([parts[0], *parts[1]])
)
ROW = st.tuples(STAMPS, st.sampled_from(NAMES)).map(" ".join)
TEXT = st.lists(st.one_of(LINE, ROW, st.just("# comment"), st.text(max_size=20)), max_size=MOST_ROWS).map(
    "\n".join
)
DATA = st.one_of(st.binary(max_size=MOST_BYTES), TEXT.map(lambda text: text.encode("utf-8", "replace")))


@settings(max_examples=max(EXAMPLES // 10, 100), deadline=None)
@given(st.fixed_dictionaries(dict.fromkeys(STREAMS, DATA)))
def test_text_of_any_kind_gives_findings_or_errors_of_ours(files: dict[str, bytes]) -> None:
    assert_in_words(files)


def test_so_do_many_more_texts() -> None:
    """Of the same kinds; hypothesis takes ten times as long to draw them, but makes what fails smaller."""
    for seed in range(EXAMPLES):
        random = Random(seed)
        files = {stream: _data(random) for stream in STREAMS}
        try:
            assert_in_words(files)
        except Exception as error:
            error.add_note(f"seed {seed}: {files}")
            raise


def _data(random: Random) -> bytes:
    if random.random() < 0.3:
        return random.randbytes(random.randint(0, MOST_BYTES))
    rows = random.randint(0, MOST_ROWS)
    # Mostly rows of one kind: a text of all kinds is soon refused.
    kinds = random.choices([_line, _named, _comment, _letters], k=random.randint(1, 3))
    return "\n".join(random.choice(kinds)(random) for _ in range(rows)).encode("utf-8", "replace")


def _number(random: Random) -> str:
    match random.randrange(3):
        case 0:
            return random.choice(WORDS)
        case 1:
            return repr(
                random.choice([random.gauss(0, 1), random.gauss(0, 1e30), float(random.randint(-9, 9))])
            )
        case _:
            return str(random.randint(-(10 ** random.randint(0, 20)), 10 ** random.randint(0, 20)))


def _stamp(random: Random) -> str:
    number = random.random()
    if number < 0.7:
        return stamp_of(random.randint(0, 2000))
    return _number(random) if number < 0.9 else "2011-05-10"


def _line(random: Random) -> str:
    numbers = [_number(random) for _ in range(random.choice([3, 7, random.randint(0, MOST_COLUMNS)]))]
    return random.choice(SEPARATORS).join([_stamp(random), *numbers])


def _named(random: Random) -> str:
    return f"{_stamp(random)} {random.choice(NAMES)}"


def _comment(random: Random) -> str:
    del random
    return "# comment"


def _letters(random: Random) -> str:
    letters = (random.randrange(random.choice([128, 0x300, 0x110000])) for _ in range(random.randint(0, 20)))
    return "".join(map(chr, letters))


def assert_in_words(files: dict[str, bytes]) -> None:
    """Check the files of a sequence: nothing may be raised but errors of ours."""
    subject = Subject("x", "x", True, "tum", SequenceInfo("x", "tum"), sizes={"rgb/1.png": 1})
    texts, names, stamps = {}, {}, {}
    for stream, data in files.items():
        damage = None
        try:
            table = parse(data, stream, f"{stream}.txt", tolerant=True)
        except TumtoolsError as error:
            damage, table = error, parse(b"", stream, "")
        texts[stream] = TextFile(f"{stream}.txt", table, damage)
        if stream in IMAGE_STREAMS:
            names[stream], stamps[stream] = table.names, table.stamps
        elif stream == "groundtruth":
            subject.groundtruth = Trajectory(table.stamps, table.values[:, :3], table.values[:, 3:])
        else:
            subject.accelerometer = Accelerometer(table.stamps, table.values)
    subject.texts, subject.names, subject.stamps = texts, names, stamps
    result = check(subject, Settings(select=("ALL",)), full=False)
    assert all(finding.message for finding in result.findings)
