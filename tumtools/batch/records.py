# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""From JSON to the dataclasses of a batch: the one place where the types of what was read are checked."""

from __future__ import annotations

import json
import types
import typing
from collections.abc import Callable, Mapping
from dataclasses import MISSING, fields, is_dataclass
from functools import cache
from typing import TYPE_CHECKING, Final, TypeVar, cast

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

_Record = TypeVar("_Record", bound="DataclassInstance")

_LARGEST: Final = 2**63


def load(data: bytes) -> Mapping[str, object]:
    """Read a JSON object.

    Raises:
        ValueError: It is none.

    """
    try:
        document = json.loads(data)
    except RecursionError:
        message = "nested too deeply"
        raise ValueError(message) from None
    if not isinstance(document, dict):
        message = "expected an object"
        raise ValueError(message)  # noqa: TRY004 - what was read is wrong, not the caller
    return document


def build(kind: type[_Record], document: object) -> _Record:
    """Make a record of a table; whatever is not as the record's fields say is refused.

    Args:
        kind: A dataclass whose fields are texts, numbers, flags, tuples, mappings, or such dataclasses.
        document: As read from JSON.

    Raises:
        ValueError: A field is missing, unknown, or of another type; says which, and what was expected.

    """
    try:
        return cast("_Record", _reader(kind)(document))
    except _WrongError as error:
        where = ".".join(reversed(error.names))
        message = f"{where}: {error.message}" if where else error.message
        raise ValueError(message) from None


class _WrongError(Exception):
    """A value is not what its field says; the names lead to it, from the inside."""

    def __init__(self, message: str, *names: str) -> None:
        super().__init__(message)
        self.message = message
        self.names = list(names)


@cache
def _reader(hint: object) -> _Reader:
    """Return what makes a value of a type out of JSON."""
    origin, arguments = typing.get_origin(hint), typing.get_args(hint)
    if isinstance(hint, type) and is_dataclass(hint):
        return _record_reader(hint)
    if isinstance(hint, types.UnionType):
        (inner,) = (argument for argument in arguments if argument is not type(None))
        read = _reader(inner)
        return lambda value: None if value is None else read(value)
    if origin is tuple:
        return _list_reader(_reader(arguments[0]))
    if origin is Mapping:
        return _table_reader(_reader(arguments[1]))
    if origin is typing.Literal:
        return _choice_reader(arguments)
    return _READERS[hint]


def _record_reader(kind: type[DataclassInstance]) -> _Reader:
    # Some of the modules import these for the type checker only.
    hints = typing.get_type_hints(kind, localns={"Mapping": Mapping})
    readers = {name: _reader(hint) for name, hint in hints.items()}
    needed = {
        item.name for item in fields(kind) if item.default is MISSING and item.default_factory is MISSING
    }

    def read(document: object) -> object:
        if not isinstance(document, dict):
            raise _WrongError("expected a table")
        values = {}
        for name, value in document.items():
            if name not in readers:
                raise _WrongError("unknown key", name)
            try:
                values[name] = readers[name](value)
            except _WrongError as error:
                error.names.append(name)
                raise
        if not needed <= values.keys():
            raise _WrongError("is missing", min(needed - values.keys()))
        return kind(**values)

    return read


def _list_reader(read: _Reader) -> _Reader:
    def read_list(values: object) -> object:
        if not isinstance(values, list):
            raise _WrongError("expected a list")
        return tuple(map(read, values))

    return read_list


def _table_reader(read: _Reader) -> _Reader:
    def read_table(values: object) -> object:
        if not isinstance(values, dict):
            raise _WrongError("expected a table")
        return {name: read(value) for name, value in values.items()}

    return read_table


def _choice_reader(choices: tuple[object, ...]) -> _Reader:
    def read(value: object) -> object:
        if value not in choices:
            raise _WrongError(f"expected one of {', '.join(map(str, choices))}")
        return value

    return read


def _read_text(value: object) -> object:
    if not isinstance(value, str):
        raise _WrongError("expected a text")
    return value


def _read_flag(value: object) -> object:
    if not isinstance(value, bool):
        raise _WrongError("expected true or false")
    return value


def _read_whole(value: object) -> object:
    if not isinstance(value, int) or isinstance(value, bool) or abs(value) >= _LARGEST:
        raise _WrongError("expected a whole number")
    return value


def _read_number(value: object) -> object:
    if isinstance(value, float):
        return value
    return float(cast("int", _read_whole(value)))


_Reader = Callable[[object], object]
_READERS: Final[Mapping[object, _Reader]] = {
    str: _read_text,
    bool: _read_flag,
    int: _read_whole,
    float: _read_number,
    object: lambda value: value,
}
