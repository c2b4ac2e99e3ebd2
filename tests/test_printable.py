# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""What other people's files hold is shown and not obeyed."""

from __future__ import annotations

import json

import pytest

from tumtools.printable import json_text, printable


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("plain, \u00e4\u00f6\u00fc \u4e2d", "plain, \u00e4\u00f6\u00fc \u4e2d"),
        ("\x1b[31mRED\x07", "\\x1b[31mRED\\x07"),
        ("a\nb\tc\r", "a\\nb\\tc\\r"),
        ("\x9b2J\x7f", "\\x9b2J\\x7f"),
        ("\u202egpj", "\\u202egpj"),
        ("no UTF-8: \udcff", "no UTF-8: \\udcff"),
    ],
)
def test_what_is_not_printed_is_escaped_once(text: str, shown: str) -> None:
    assert printable(text) == shown
    assert printable(shown) == shown


@pytest.mark.parametrize("letter", ["\x9b", "\u202e", "\x7f", "\u2028", "\udcff", "\U000e0041"])
def test_json_shows_what_is_not_printed_and_means_the_same(letter: str) -> None:
    text = json_text({"name": f"a{letter}\u00e4"})
    assert letter not in text
    assert "\u00e4" in text
    assert json.loads(text) == {"name": f"a{letter}\u00e4"}
