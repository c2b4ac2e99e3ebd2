# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Whatever stands in the text files, there are findings or errors of ours, and nothing else."""

from __future__ import annotations

import os

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
NUMBERS = st.one_of(
    st.sampled_from(
        [
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
    ),
    st.floats(width=32).map(repr),
    st.integers(-(10**20), 10**20).map(str),
)
STAMPS = st.one_of(
    NUMBERS,
    st.integers(0, 2000).map(lambda n: f"13050311{n % 100:02d}.{n * 7919 % 10**6:06d}"),
    st.just("2011-05-10"),
)
LINE = st.tuples(STAMPS, st.lists(NUMBERS, max_size=9), st.sampled_from([" ", "\t", ",", "  "])).map(
    lambda parts: parts[2].join([parts[0], *parts[1]])
)
ROW = st.tuples(
    STAMPS, st.sampled_from(["rgb/1.png", "../x", "/etc/passwd", "a b", "depth/1305031102.000000.png"])
).map(" ".join)
TEXT = st.lists(st.one_of(LINE, ROW, st.just("# comment"), st.text(max_size=20)), max_size=40).map("\n".join)
DATA = st.one_of(st.binary(max_size=300), TEXT.map(lambda text: text.encode("utf-8", "replace")))


@settings(max_examples=EXAMPLES, deadline=None)
@given(st.fixed_dictionaries(dict.fromkeys(STREAMS, DATA)))
def test_text_of_any_kind_gives_findings_or_errors_of_ours(files: dict[str, bytes]) -> None:
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
