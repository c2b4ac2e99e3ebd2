# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""The kinds of fields that classes are described with, and the one codec that reads and writes them."""

from __future__ import annotations

import struct
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Final

import numpy as np

from tumtools.errors import UnsupportedInputError
from tumtools.formats.rawlog import archive
from tumtools.formats.rawlog.archive import Record

if TYPE_CHECKING:
    from collections.abc import Mapping

    from tumtools.formats.rawlog.archive import Array, Fields, Header, Input, Value

Condition = Callable[["Fields"], bool]
"""Whether a field is there, told from the fields before it."""
Count = int | str | Callable[["Fields"], int]
"""How many items: a number, the name of the field that says it, or computed from the fields before."""

MAX_DEPTH: Final = 16
"""Objects within objects; real files have 4."""
_MOST_REMEMBERED: Final = 1024
"""Bytes of an object that is kept to be compared with the next one."""
MAX_ITEMS: Final = 2**20
"""Objects in one collection, or entries in one map."""


@dataclass(frozen=True, slots=True)
class Number:
    """A number, as `struct` calls it."""

    code: str


@dataclass(frozen=True, slots=True)
class Text:
    """A string: 32-bit length and bytes."""


@dataclass(frozen=True, slots=True)
class Block:
    """Numbers one after another, as many as fields before say.

    Attributes:
        dtype: As numpy calls it; or what computes it from the fields before.
        count: How many.

    """

    dtype: str | Callable[[Fields], str]
    count: Count


@dataclass(frozen=True, slots=True)
class Vector:
    """A 32-bit count and numbers."""

    dtype: str


@dataclass(frozen=True, slots=True)
class Child:
    """An object with name, version and end mark."""


@dataclass(frozen=True, slots=True)
class Children:
    """A 32-bit count and objects."""


@dataclass(frozen=True, slots=True)
class Groups:
    """An 8-bit count and groups of fields."""

    fields: tuple[Field, ...]


@dataclass(frozen=True, slots=True)
class Names:
    """A `std::map<uint32_t, std::string>`."""


Kind = Number | Text | Block | Vector | Child | Children | Groups | Names


@dataclass(frozen=True, slots=True)
class Field:
    """A field of a class.

    Attributes:
        name: Ours; the same for the same thing in all versions and classes.
        kind: What is there.
        since: First version that has it.
        until: Last version that has it.
        when: Further condition.

    """

    name: str
    kind: Kind
    since: int = 0
    until: int = 255
    when: Condition | None = None


@dataclass(frozen=True, slots=True)
class Class:
    """A class: the versions that are known, and the fields of all of them in the order of the stream."""

    versions: tuple[int, ...]
    fields: tuple[Field, ...]


@dataclass(frozen=True, slots=True)
class _Numbers:
    """Numbers that always follow each other: one step for all of them."""

    names: tuple[str, ...]
    layout: struct.Struct


_Step = _Numbers | Field


def _steps(fields: tuple[Field, ...], version: int) -> tuple[_Step, ...]:
    """Choose the fields of a version and join neighbouring numbers."""
    steps: list[_Step] = []
    run: list[tuple[str, str]] = []

    def end_run() -> None:
        if run:
            codes = "".join(code for _, code in run)
            steps.append(_Numbers(tuple(name for name, _ in run), struct.Struct("<" + codes)))
            run.clear()

    for item in fields:
        if not item.since <= version <= item.until:
            continue
        if isinstance(item.kind, Number) and item.when is None:
            run.append((item.name, item.kind.code))
        else:
            end_run()
            steps.append(item)
    end_run()
    return tuple(steps)


class Codec:
    """Reads and writes the objects of a table of classes.

    Args:
        classes: By name without namespace.

    """

    def __init__(self, classes: Mapping[str, Class]) -> None:
        self.classes = classes
        self._plan = cache(lambda name, version: _steps(classes[name].fields, version))
        self._group_plan = cache(lambda fields: _steps(fields, 0))

    def check(self, header: Header, source: Input) -> None:
        """Refuse a class or version that the table does not have.

        Raises:
            UnsupportedInputError: With the object, its offset and the versions that are known.

        """
        known = self.classes.get(archive.class_of(header.name))
        if known is not None and header.version in known.versions:
            return
        what = f"{header.name} version {header.version}"
        detail = f" (known: {_ranges(known.versions)})" if known else ""
        where = f"{source.context}, offset {header.offset}" if source.context else f"offset {header.offset}"
        raise UnsupportedInputError(
            f"{what} is not a class that tumtools reads{detail}; "
            "what follows it cannot be found, because objects do not tell their length",
            path=source.path,
            location=where,
            hint="remove it with MRPT's rawlog-edit --remove-label, or read what is before it with --salvage",
        )

    def read(self, source: Input, depth: int = 0) -> Record:
        """Read an object.

        Raises:
            InputError: It is damaged.
            UnsupportedInputError: Its class or version is unknown.

        """
        header = archive.read_header(source)
        return self.read_body(source, header, depth)

    def read_body(self, source: Input, header: Header, depth: int = 0) -> Record:
        """Read an object whose header has been read."""
        record = Record(header.name, header.version, {}, header.offset, header.old_framing)
        if header.has_body:
            if depth > MAX_DEPTH:
                source.fail(f"objects are nested more than {MAX_DEPTH} deep")
            self.check(header, source)
            self._read_steps(source, record.fields, self._plan(record.type, record.version), depth)
        archive.read_end(source, header)
        return record

    def _read_steps(self, source: Input, fields: Fields, steps: tuple[_Step, ...], depth: int) -> None:
        for step in steps:
            if isinstance(step, _Numbers):
                fields.update(zip(step.names, source.unpack(step.layout), strict=True))
            elif step.when is None or step.when(fields):
                if isinstance(step.kind, Child):
                    fields[step.name] = self._read_child(source, step.name, depth)
                else:
                    fields[step.name] = self._read_value(source, step.kind, fields, depth)

    def _read_child(self, source: Input, name: str, depth: int) -> Record:
        """Read an object of an object; poses and cameras are mostly those of the observation before."""
        offset = source.offset
        data, latest = source.latest.get(name, (b"", None))
        if latest is not None and source.skip(data):
            return Record(latest.name, latest.version, latest.fields, offset, latest.old_framing)
        record = self.read(source, depth + 1)
        if source.offset - offset <= _MOST_REMEMBERED and (data := source.since(offset)):
            source.latest[name] = data, record
        return record

    def _read_value(self, source: Input, kind: Kind, fields: Fields, depth: int) -> Value:
        match kind:
            case Number():
                return source.unpack(struct.Struct("<" + kind.code))[0]
            case Text():
                return source.text()
            case Block():
                count = _count(kind, fields)
                if count < 0:
                    source.fail(f"a field of {count} numbers")
                return source.array(_dtype(kind, fields), count)
            case Vector():
                return source.array(np.dtype(kind.dtype), source.u32())
            case Child():
                return self.read(source, depth + 1)
            case Children():
                return [self.read(source, depth + 1) for _ in range(_items(source, source.u32()))]
            case Groups():
                return [self._read_group(source, kind, depth) for _ in range(source.u8())]
            case Names():
                return _read_names(source)

    def _read_group(self, source: Input, kind: Groups, depth: int) -> Fields:
        group: Fields = {}
        self._read_steps(source, group, self._group_plan(kind.fields), depth)
        return group

    def encode(self, record: Record) -> bytes:
        """Return an object as it is written.

        Raises:
            ValueError: A field is missing, or its value does not fit the table.

        """
        parts: list[bytes] = []
        self._write(record, parts)
        return b"".join(parts)

    def _write(self, record: Record, parts: list[bytes]) -> None:
        parts.append(archive.header_bytes(record))
        if record.name not in {archive.NULL, archive.EMPTY}:
            self._write_steps(record.fields, self._plan(record.type, record.version), parts)
        parts.append(archive.end_bytes(record))

    def _write_steps(self, fields: Fields, steps: tuple[_Step, ...], parts: list[bytes]) -> None:
        for step in steps:
            if isinstance(step, _Numbers):
                parts.append(step.layout.pack(*(fields[name] for name in step.names)))
            elif step.when is None or step.when(fields):
                self._write_value(fields[step.name], step, fields, parts)

    def _write_value(self, value: Value, item: Field, fields: Fields, parts: list[bytes]) -> None:
        match item.kind, value:
            case Child(), Record():
                self._write(value, parts)
            case Child(), bytes():
                parts.append(value)
            case Children(), list():
                parts.append(struct.pack("<I", len(value)))
                for child in value:
                    if isinstance(child, Record):
                        self._write(child, parts)
            case Groups(inner), list():
                parts.append(struct.pack("<B", len(value)))
                for group in value:
                    if isinstance(group, dict):
                        self._write_steps(group, self._group_plan(inner), parts)
            case _:
                parts.append(_flat_bytes(value, item, fields))


def _flat_bytes(value: Value, item: Field, fields: Fields) -> bytes:
    """Return a field that holds no other fields."""
    match item.kind, value:
        case Number(code), int() | float():
            return struct.pack("<" + code, value)
        case Text(), str():
            return archive.text_bytes(value)
        case Block() as kind, np.ndarray():
            return _array_bytes(value, _dtype(kind, fields), _count(kind, fields), item.name)
        case Vector(dtype), np.ndarray():
            return struct.pack("<I", value.size) + _array_bytes(value, np.dtype(dtype), value.size, item.name)
        case Names(), dict():
            return _names_bytes(value)
    msg = f"{item.name}: a {type(value).__name__} is no {type(item.kind).__name__}"
    raise ValueError(msg)


def _count(kind: Block, fields: Fields) -> int:
    if isinstance(kind.count, int):
        return kind.count
    value = fields[kind.count] if isinstance(kind.count, str) else kind.count(fields)
    return value if isinstance(value, int) else -1


def _dtype(kind: Block, fields: Fields) -> np.dtype[np.generic]:
    return np.dtype(kind.dtype if isinstance(kind.dtype, str) else kind.dtype(fields))


def _array_bytes(value: Array, dtype: np.dtype[np.generic], count: int, name: str) -> bytes:
    if value.size != count or value.dtype != dtype:
        msg = f"{name}: {count} of {dtype} expected, not {value.size} of {value.dtype}"
        raise ValueError(msg)
    return value.tobytes()


def _items(source: Input, count: int) -> int:
    if count > MAX_ITEMS or count > source.bytes_left():
        source.fail(f"a collection of {count} items; more than {MAX_ITEMS}, or than bytes are left")
    return count


_MAP_TYPES: Final = ("std::map", "uint32_t", "std::string")


def _read_names(source: Input) -> dict[int, str]:
    found = tuple(source.text() for _ in _MAP_TYPES)
    if found != _MAP_TYPES:
        source.fail(f"a {_MAP_TYPES} expected, found {found}")
    return {source.u32(): source.text() for _ in range(_items(source, source.u32()))}


def _names_bytes(names: Mapping[int, str] | Fields) -> bytes:
    head = b"".join(archive.text_bytes(text) for text in _MAP_TYPES) + struct.pack("<I", len(names))
    return head + b"".join(
        struct.pack("<I", key) + archive.text_bytes(str(text)) for key, text in names.items()
    )


def _ranges(versions: tuple[int, ...]) -> str:
    if versions == tuple(range(versions[0], versions[-1] + 1)) and len(versions) > 1:
        return f"{versions[0]} to {versions[-1]}"
    return ", ".join(map(str, versions))
