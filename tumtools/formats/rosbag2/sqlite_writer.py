# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Writes a sqlite3 file of rosbag2, version 4 of its schema (rosbag2_storage_sqlite3)."""

from __future__ import annotations

import sqlite3
import struct
from contextlib import closing
from typing import TYPE_CHECKING, Final

from tumtools.errors import OutputError
from tumtools.formats.ros.messages import TYPE_HASHES, definition
from tumtools.formats.ros.qos import qos_profile

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator, Sequence
    from pathlib import Path

    from tumtools.formats.options import Progress
    from tumtools.formats.ros.recording import OutChannel, OutMessage

_SCHEMA: Final = """
CREATE TABLE schema(schema_version INTEGER PRIMARY KEY, ros_distro TEXT NOT NULL);
CREATE TABLE metadata(id INTEGER PRIMARY KEY, metadata_version INTEGER NOT NULL, metadata TEXT NOT NULL);
CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL,
  serialization_format TEXT NOT NULL, offered_qos_profiles TEXT NOT NULL,
  type_description_hash TEXT NOT NULL);
CREATE TABLE message_definitions(id INTEGER PRIMARY KEY, topic_type TEXT NOT NULL, encoding TEXT NOT NULL,
  encoded_message_definition TEXT NOT NULL, type_description_hash TEXT NOT NULL);
CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, timestamp INTEGER NOT NULL,
  data BLOB NOT NULL);
CREATE INDEX timestamp_idx ON messages (timestamp ASC);
"""
_SCHEMA_VERSION: Final = 4
_LIBRARY_VERSION_AT: Final = 96
_LIBRARY_VERSION: Final = 3_037_000
"""Written in place of the version of the SQLite library, which is there for information only."""


def write_sqlite(
    path: Path,
    channels: Sequence[OutChannel],
    messages: Iterable[OutMessage],
    *,
    describe: Callable[[], tuple[int, str]],
    ros_distro: str,
    progress: Progress,
) -> None:
    """Write the file.

    Args:
        path: The file to make.
        channels: Topics.
        messages: In order of their stamps.
        describe: Gives version and text of metadata.yaml, of which the file keeps a copy; called when all
            messages have been taken.
        ros_distro: Release of ROS 2 that the definitions come from.
        progress: Told of each image.

    Raises:
        OutputError: The disk is full, or something else of the sort.

    """
    try:
        with closing(sqlite3.connect(path, isolation_level=None)) as database:
            # The file is staged: one that is not finished is thrown away, so nothing is journalled.
            for pragma in ("journal_mode = OFF", "synchronous = OFF", "page_size = 4096"):
                database.execute(f"PRAGMA {pragma}")
            database.execute("BEGIN")
            for statement in _SCHEMA.split(";")[:-1]:
                database.execute(statement)
            database.execute("INSERT INTO schema VALUES (?, ?)", (_SCHEMA_VERSION, ros_distro))
            _write_topics(database, channels)
            database.executemany("INSERT INTO messages VALUES (?, ?, ?, ?)", _rows(messages, progress))
            database.execute("INSERT INTO metadata VALUES (1, ?, ?)", describe())
            database.execute("COMMIT")
        with path.open("r+b") as file:
            file.seek(_LIBRARY_VERSION_AT)
            file.write(struct.pack(">I", _LIBRARY_VERSION))
    except sqlite3.Error as error:
        raise OutputError(f"the database cannot be written: {error}", path=path) from error


def _write_topics(database: sqlite3.Connection, channels: Sequence[OutChannel]) -> None:
    for number, channel in enumerate(channels, 1):
        profile, kind = qos_profile(latched=channel.latched), channel.type
        row = (number, channel.topic, kind, "cdr", profile, TYPE_HASHES[kind])
        database.execute("INSERT INTO topics VALUES (?, ?, ?, ?, ?, ?)", row)
    for number, kind in enumerate(sorted({channel.type for channel in channels}), 1):
        described = (number, kind, "ros2msg", definition(kind, "cdr"), TYPE_HASHES[kind])
        database.execute("INSERT INTO message_definitions VALUES (?, ?, ?, ?, ?)", described)


def _rows(messages: Iterable[OutMessage], progress: Progress) -> Iterator[tuple[int, int, int, bytes]]:
    for number, message in enumerate(messages, 1):
        data = b"".join(message.parts)
        yield number, message.channel + 1, message.stamp, data
        if message.is_image:
            progress(1, len(data))
