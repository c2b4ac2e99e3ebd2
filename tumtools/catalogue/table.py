# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Read tables of JSON or TOML into dataclasses, strictly: an unknown key or a wrong type is named."""

from __future__ import annotations

import difflib
from dataclasses import MISSING, fields
from typing import TYPE_CHECKING, Final, TypeVar, cast

from tumtools.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping
    from dataclasses import Field

_T = TypeVar("_T")


class _WrongTypeError(Exception):
    """Carries what was expected up to where the key is known."""


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _text(value: object) -> object:
    if not isinstance(value, str) or not value:
        raise _WrongTypeError("a text")
    return value


def _flag(value: object) -> object:
    if not isinstance(value, bool):
        raise _WrongTypeError("true or false")
    return value


def _count(value: object) -> object:
    if not isinstance(value, int) or isinstance(value, bool) or value < 0:
        raise _WrongTypeError("a whole number, 0 or more")
    return value


def _number(value: object) -> object:
    if not _is_number(value):
        raise _WrongTypeError("a number")
    return float(cast("float", value))


def _list_of(item: Callable[[object], object]) -> Callable[[object], object]:
    def parse(value: object) -> object:
        if not isinstance(value, list | tuple):
            raise _WrongTypeError("a list")
        return tuple(item(element) for element in value)

    return parse


def _table_of(item: Callable[[object], object]) -> Callable[[object], object]:
    def parse(value: object) -> object:
        if not isinstance(value, dict):
            raise _WrongTypeError("a table")
        return {str(key): item(element) for key, element in value.items()}

    return parse


_BY_ANNOTATION: Final[dict[str, Callable[[object], object]]] = {
    "str": _text,
    "bool": _flag,
    "int": _count,
    "float": _number,
    "tuple[str, ...]": _list_of(_text),
    "tuple[float, ...]": _list_of(_number),
    "Mapping[str, str]": _table_of(_text),
    "Mapping[str, int]": _table_of(_count),
    "Mapping[str, float]": _table_of(_number),
}
"""What a field of a dataclass accepts, by its annotation without `| None`."""

Nested = dict[str, type[object]]
"""Annotation -> dataclass, for fields that hold a table (`X`) or named tables (`Mapping[str, X]`)."""


def build(cls: type[_T], value: object, path: str, location: str, nested: Nested | None = None) -> _T:
    """Build a dataclass from a table.

    Args:
        cls: A dataclass whose module has postponed annotations.
        value: The table, as read from JSON or TOML.
        path: The file, for messages.
        location: Where in it, for messages.
        nested: Dataclasses that fields of `cls` are made of.

    Raises:
        InputError: An unknown or missing key, or a value of the wrong type.

    """
    if not isinstance(value, dict):
        raise InputError("expected a table", path=path, location=location)
    known: dict[str, Field[object]] = {field.name: field for field in fields(cls)}  # type: ignore[arg-type]  # mypy cannot say "any dataclass" of a type variable
    for key in value:
        if key not in known:
            near = difflib.get_close_matches(str(key), known, 1)
            raise InputError(
                f"unknown key {key!r}",
                path=path,
                location=location,
                hint=f"did you mean {near[0]!r}?" if near else f"known keys: {', '.join(known)}",
            )
    arguments = {
        name: _field(field, value[name], path, f"{location}.{name}", nested or {})
        for name, field in known.items()
        if value.get(name) is not None
    }
    for name, field in known.items():
        if name not in arguments and field.default is MISSING and field.default_factory is MISSING:
            raise InputError(f"the key {name!r} is missing", path=path, location=location)
    return cls(**arguments)


def _field(field: Field[object], value: object, path: str, location: str, nested: Nested) -> object:
    annotation = str(field.type).removesuffix(" | None")
    if annotation in nested:
        return build(nested[annotation], value, path, location)
    item = nested.get(annotation.removeprefix("Mapping[str, ").removesuffix("]"))
    try:
        if item is None:
            return _BY_ANNOTATION[annotation](value)
        tables = cast("Mapping[str, object]", _table_of(lambda element: element)(value))
    except _WrongTypeError as error:
        raise InputError(f"expected {error}, got {value!r}", path=path, location=location) from None
    return {key: build(item, element, path, f"{location}.{key}") for key, element in tables.items()}
