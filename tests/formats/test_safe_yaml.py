# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""YAML says the same whether libyaml reads it or not, and can harm nobody."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest
import yaml

from tumtools.formats import safe_yaml
from tumtools.formats.ros.qos import qos_profile

if TYPE_CHECKING:
    from collections.abc import Callable

DOCUMENT = f"""\
version: 5
duration: {{nanoseconds: 1_000}}
names: [a, "b: c", 'd''e', ä]
offered_qos_profiles: {qos_profile(latched=True, words=False)!r}
nothing: ~
number: 1.5e+3
"""


@pytest.mark.parametrize(
    "text", [DOCUMENT, DOCUMENT.replace("\n", "\r\n"), "", "[]", "%YAML 1.1\n---\na: 1\n"]
)
def test_both_readers_say_the_same(text: str) -> None:
    assert safe_yaml.load(text) == safe_yaml.load(text.encode()) == yaml.safe_load(text)
    assert safe_yaml.load_texts(text) == yaml.load(text, yaml.BaseLoader)  # noqa: S506 - makes texts


@pytest.mark.skipif(not yaml.__with_libyaml__, reason="PyYAML was built without libyaml")
def test_libyaml_is_used_where_it_is_there() -> None:
    assert issubclass(safe_yaml._PLAIN, yaml.CSafeLoader)
    assert issubclass(safe_yaml._TEXTS, yaml.CBaseLoader)


@pytest.mark.parametrize("opening", ["[", "{a: ", "- ", "? "])
@pytest.mark.parametrize("load", [safe_yaml.load, safe_yaml.load_texts])
def test_what_is_nested_too_deep_is_refused(load: Callable[[str], object], opening: str) -> None:
    with pytest.raises((yaml.YAMLError, RecursionError)):
        load(opening * 100_000)


def test_no_object_is_made() -> None:
    with pytest.raises(yaml.YAMLError):
        safe_yaml.load("!!python/object/apply:os.getcwd []")
    assert safe_yaml.load_texts("!!python/object/apply:os.getcwd []") == []
