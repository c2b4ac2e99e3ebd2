# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Message definitions: the text that recordings embed, parsed to fields.

The embedded definition, not the name of the type or its md5 sum, says how a message is serialised.

Source: ROS wiki `msg` (syntax, md5 sums), ROS 2 interface definitions, MCAP registry `ros1msg`, `ros2msg`.
"""

from __future__ import annotations

import hashlib
import re
from dataclasses import dataclass
from typing import Final

import numpy as np

from tumtools.errors import InputError

PRIMITIVES: Final[dict[str, np.dtype[np.generic]]] = {
    name: np.dtype(kind)
    for name, kind in {
        "bool": "u1",
        "byte": "u1",
        "char": "u1",
        "int8": "i1",
        "uint8": "u1",
        "int16": "i2",
        "uint16": "u2",
        "int32": "i4",
        "uint32": "u4",
        "int64": "i8",
        "uint64": "u8",
        "float32": "f4",
        "float64": "f8",
    }.items()
}
TIME_TYPES: Final = {"time": ("uint32 sec", "uint32 nanosec"), "duration": ("int32 sec", "int32 nanosec")}
"""Primitives of ROS 1 that are messages in ROS 2."""

_SEPARATOR = re.compile(r"^={20,}\s*$", re.MULTILINE)
_FIELD = re.compile(r"([A-Za-z][\w/]*)(?:<=\d+)?(\[(?:<=)?\d*\])?\s+([A-Za-z]\w*)\s*(=)?")
_MAX_FIXED: Final = 1 << 20
_MAX_DEPTH: Final = 32
_MAX_VALUES: Final = 1 << 20
"""Values in one message, arrays of unknown length not counted; real messages have hundreds."""
_FILLER: Final = "structure_needs_at_least_one_member"
"""The byte that ROS 2 puts into messages without fields."""


@dataclass(frozen=True, slots=True)
class Field:
    """A field of a message.

    Attributes:
        name: Its name.
        type: A primitive, `string`, `time`, `duration`, or a message as `package/msg/Type`.
        count: None for a single value, 0 for a sequence of any length, n for an array of n.

    """

    name: str
    type: str
    count: int | None = None


Definitions = dict[str, tuple[Field, ...]]
"""Fields by message type."""


def full_name(name: str, package: str = "") -> str:
    """Return the spelling of ROS 2, `package/msg/Type`.

    Args:
        name: `package/Type`, `package/msg/Type`, or `Type` of the package.
        package: Package in which the name is used.

    """
    if name == "Header":
        return "std_msgs/msg/Header"
    parts = name.split("/")
    if len(parts) == 1:
        return f"{package}/msg/{name}"
    return f"{parts[0]}/msg/{parts[-1]}"


def parse_definitions(text: str, root: str, *, ros2: bool = False) -> Definitions:
    """Parse an embedded definition with its dependencies.

    Args:
        text: As `gendeps --cat` prints it.
        root: Type that the text begins with, `package/msg/Type`.
        ros2: Messages without fields have one byte, as ROS 2 serialises them.

    Raises:
        InputError: A line is no field, the definition of a type is missing, a message contains itself, or
            is larger than any message is.

    """
    definitions: Definitions = {}
    for number, block in enumerate(_SEPARATOR.split(text.replace("\r\n", "\n"))):
        name, body = root, block
        if number:
            first, _, body = block.lstrip("\n").partition("\n")
            name = full_name(first.removeprefix("MSG:").strip())
        definitions[name] = tuple(_parse_fields(body, name)) or ((Field(_FILLER, "uint8"),) if ros2 else ())
    for fields in list(definitions.values()):
        for field in fields:
            if field.type in TIME_TYPES:
                definitions[field.type] = tuple(_parse_fields("\n".join(TIME_TYPES[field.type]), ""))
    for name, fields in definitions.items():
        for field in fields:
            if field.type not in PRIMITIVES and field.type != "string" and field.type not in definitions:
                raise InputError(f"the definition of {name} uses {field.type}, which is not defined with it")
    _measure(definitions, root, (), {})
    return definitions


def _parse_fields(body: str, name: str) -> list[Field]:
    package = name.partition("/")[0]
    fields = []
    for line in body.splitlines():
        text = line.partition("#")[0].strip()
        if not text:
            continue
        match = _FIELD.match(text)
        if match is None:
            raise InputError(f"in the definition of {name}: {text!r} is no field")
        if match[4]:
            continue  # a constant
        kind = match[1]
        if kind not in PRIMITIVES and kind != "string" and kind not in TIME_TYPES:
            kind = full_name(kind, package)
        count = None
        if match[2]:
            digits = match[2].strip("[]")
            count = 0 if not digits or digits.startswith("<=") else int(digits)
            if count > _MAX_FIXED:
                raise InputError(f"in the definition of {name}: an array of {count} elements")
        fields.append(Field(match[3], kind, count))
    return fields


@dataclass(frozen=True, slots=True)
class _Size:
    """What a message has at least, each array of unknown length taken for empty."""

    values: int
    nbytes: int


def _measure(definitions: Definitions, name: str, within: tuple[str, ...], known: dict[str, _Size]) -> _Size:
    """Refuse definitions that could keep a reader busy without end: their text may be anybody's."""
    if name in known:
        return known[name]
    if name in within:
        raise InputError(f"the definition of {name} contains itself")
    if len(within) >= _MAX_DEPTH:
        raise InputError(f"the definition of {within[0]} is nested more than {_MAX_DEPTH} deep")
    values, nbytes = 1, 0
    for field in definitions[name]:
        if field.type in definitions:
            one = _measure(definitions, field.type, (*within, name), known)
        else:
            one = _Size(1, PRIMITIVES[field.type].itemsize if field.type in PRIMITIVES else 4)
        if field.count is not None and not one.nbytes:
            raise InputError(f"the definition of {name} has an array of messages without fields")
        if field.count == 0:
            one = _Size(1, 4)
        times = field.count or 1
        values += one.values * (1 if field.type in PRIMITIVES else times)
        nbytes += one.nbytes * times
    if values > _MAX_VALUES:
        raise InputError(f"the definition of {name} has more than {_MAX_VALUES} values")
    known[name] = _Size(values, nbytes)
    return known[name]


def md5_sum(name: str, definitions: dict[str, str]) -> str:
    """Return the md5 sum of a ROS 1 message.

    Args:
        name: `package/msg/Type`.
        definitions: Texts of all messages, without dependencies, by name.

    """
    lines = []
    for line in definitions[name].splitlines():
        kind, field = line.split()
        base = kind.partition("[")[0]
        if base not in PRIMITIVES and base != "string" and base not in TIME_TYPES:
            kind = md5_sum(full_name(base, name.partition("/")[0]), definitions)
        lines.append(f"{kind} {field}")
    return hashlib.md5("\n".join(lines).encode(), usedforsecurity=False).hexdigest()


def gather(name: str, definitions: dict[str, str]) -> str:
    """Return the text of a message followed by those of all messages that it uses, as recordings embed it."""
    order = [name]
    for current in order:
        for line in definitions[current].splitlines():
            base = line.split()[0].partition("[")[0]
            if base in PRIMITIVES or base == "string" or base in TIME_TYPES:
                continue
            used = full_name(base, current.partition("/")[0])
            if used not in order:
                order.append(used)
    blocks = [definitions[name]]
    for used in order[1:]:
        package, _, kind = used.split("/")
        blocks.append(f"MSG: {package}/{kind}\n{definitions[used]}")
    return ("\n" + "=" * 80 + "\n").join(block.rstrip("\n") for block in blocks) + "\n"
