# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""A sqlite3 file of rosbag2 (rosbag2_storage_sqlite3, all versions of its schema) as a `Recording`."""

from __future__ import annotations

import sqlite3
from contextlib import closing, contextmanager
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final

import numpy as np

from tumtools.errors import InputError
from tumtools.formats.ros.qos import is_latched
from tumtools.formats.ros.recording import Channel, RawMessage, Recording
from tumtools.formats.rosbag2.bag_info import parse_bag_info
from tumtools.model.sequence import LEFT_OUT, RECORDING, Loss

if TYPE_CHECKING:
    from collections.abc import Collection, Iterator, Mapping
    from pathlib import Path

    import numpy.typing as npt

_MAGIC: Final = b"SQLite format 3\0"
_MAX_MESSAGE_BYTES: Final = 256 * 2**20
_ROWS_AT_ONCE: Final = 10_000
_HINT: Final = "--salvage reads what comes before the damage"
_ROW: Final = np.dtype([("id", "<i8"), ("topic", "<i8"), ("time", "<i8")])


class SqliteRecording(Recording):
    """A sqlite3 file. Lists its messages at once, and reads them as they are asked for.

    Args:
        path: The file.
        salvage: Read all of it at once, and leave out what is damaged, with a warning.

    Raises:
        InputError: The file is no recording, or damaged.

    """

    format = "rosbag2"

    def __init__(self, path: Path, *, salvage: bool = False) -> None:
        self.path = str(path)
        self._file = path
        self._salvage = salvage
        _check_file(path)
        with self._database() as database:
            _check_tables(path, database)
            topics = _topics(database)
            self._rows, damage = _rows(database, path, salvage=salvage)
            self.metadata, error = _metadata(database, path, salvage=salvage)
        if damage:
            self.warnings = (f"{path}: {damage}; only the {len(self._rows)} messages before this are read",)
            self.left_out = (Loss(RECORDING, f"messages behind the damage {LEFT_OUT}", 1, damage),)
        if error:
            self.warnings += (f"{path}: its copy of metadata.yaml cannot be read ({error}); it is left out",)
            self.left_out += (Loss("copy of metadata.yaml", LEFT_OUT, 1, error),)
        ids, counts = np.unique(self._rows["topic"], return_counts=True)
        count_of = dict(zip(ids.tolist(), counts.tolist(), strict=True))
        unknown = [number for number in count_of if number not in topics]
        if unknown:
            message = (
                f"{count_of[unknown[0]]} messages of topic {unknown[0]}, which the table topics does not have"
            )
            if not salvage:
                raise InputError(message, path=path, hint=_HINT)
            self.warnings = (*self.warnings, f"{message}; they are left out")
            count = sum(count_of[number] for number in unknown)
            self.left_out += (Loss(RECORDING, f"messages {LEFT_OUT}", count, "their topics are not known"),)
        self.channels = tuple(
            replace(topic.channel, count=count_of.get(number, 0))
            for number, topic in topics.items()
            if topic.serialization == "cdr"
        )
        self.not_carried = tuple(
            Loss(
                topic.channel.topic, "messages in another serialization", count_of.get(number, 0),
                f"{topic.serialization!r}, only cdr is read",
            )
            for number, topic in topics.items()
            if topic.serialization != "cdr"
        )  # fmt: skip

    def messages(
        self, channels: Collection[Channel], start: int | None = None, end: int | None = None
    ) -> Iterator[RawMessage]:
        """Yield the messages of the channels in order of (log time, row).

        Raises:
            InputError: The file is damaged.

        """
        channel_of = {channel.id: channel for channel in channels}
        rows = self._rows
        wanted = np.isin(rows["topic"], np.array(list(channel_of), np.int64))
        if start is not None:
            wanted &= rows["time"] >= start
        if end is not None:
            wanted &= rows["time"] <= end
        rows = rows[wanted]
        rows = rows[np.lexsort((rows["id"], rows["time"]))]
        with self._database() as database:
            cursor = database.cursor()
            for number, topic, time in rows.tolist():
                found = cursor.execute("SELECT data FROM messages WHERE id = ?", (number,)).fetchone()
                if found is None or not isinstance(found[0], bytes):
                    raise self._damage(f"the message with id {number} is not there or no blob")
                yield RawMessage(channel_of[topic], time, memoryview(found[0]))

    def log_times(self, channel: Channel) -> npt.NDArray[np.int64]:
        """Return the log times of a channel, from the list of messages."""
        return np.sort(self._rows["time"][self._rows["topic"] == channel.id], kind="stable")

    def close(self) -> None:
        """Do nothing: the file is open only while messages are read."""

    def _damage(self, message: str) -> InputError:
        return InputError(message, path=self.path, hint=_HINT)

    @contextmanager
    def _database(self) -> Iterator[sqlite3.Connection]:
        """Open the database; its errors become ours."""
        try:
            with closing(_connect(self._file, salvage=self._salvage)) as database:
                yield database
        except (sqlite3.Error, OverflowError, UnicodeDecodeError) as error:
            raise self._damage(f"the database is damaged: {error}") from error


def _check_file(path: Path) -> None:
    try:
        with path.open("rb") as file:
            head = file.read(len(_MAGIC))
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror}", path=path) from error
    if not head:
        raise InputError("the file is empty (0 bytes), expected a sqlite3 database", path=path)
    if head != _MAGIC:
        raise InputError(f"no sqlite3 database: it begins with {head!r}", path=path, location="offset 0")


def _connect(path: Path, *, salvage: bool) -> sqlite3.Connection:
    # A log file beside the database belongs to it; without one nothing needs to be locked or written.
    immutable = "" if path.with_name(f"{path.name}-wal").exists() else "&immutable=1"
    uri = f"{path.absolute().as_uri()}?mode=ro{immutable}"
    # Messages may be taken from another thread than the one that asked for them, but never from two.
    database = sqlite3.connect(uri, uri=True, check_same_thread=False, isolation_level=None)
    database.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, _MAX_MESSAGE_BYTES)
    database.execute("PRAGMA trusted_schema = OFF")
    if salvage:
        # Nothing is written: this makes SQLite go on with a file that is shorter than it should be.
        database.execute("PRAGMA writable_schema = ON")
    database.execute("PRAGMA cell_size_check = ON")
    return database


def _check_tables(path: Path, database: sqlite3.Connection) -> None:
    tables = {name for (name,) in database.execute("SELECT name FROM sqlite_master WHERE type = 'table'")}
    for table in ("topics", "messages"):
        if table not in tables:
            raise InputError(f"no table {table!r}, so it is no recording of ROS 2", path=path)


def _columns(database: sqlite3.Connection, table: str) -> set[str]:
    return {row[1] for row in database.execute(f"PRAGMA table_info({table})")}


@dataclass(frozen=True, slots=True)
class _Topic:
    """A row of the table `topics`."""

    channel: Channel
    serialization: str


def _topics(database: sqlite3.Connection) -> dict[int, _Topic]:
    definitions = _definitions(database)
    qos = "offered_qos_profiles" if "offered_qos_profiles" in _columns(database, "topics") else "''"
    query = f"SELECT id, name, type, serialization_format, {qos} FROM topics ORDER BY id"  # noqa: S608 - constants
    return {
        int(number): _Topic(
            Channel(
                int(number), str(name), str(kind), "cdr", definitions.get(str(kind), ""),
                latched=is_latched(str(profiles)), qos=(str(profiles or ""),),
            ),
            str(serialization),
        )
        for number, name, kind, serialization, profiles in database.execute(query)
        if isinstance(number, int)
    }  # fmt: skip


def _definitions(database: sqlite3.Connection) -> dict[str, str]:
    """Return the embedded definitions; recordings from before Iron have none."""
    if not {"topic_type", "encoding", "encoded_message_definition"} <= _columns(
        database, "message_definitions"
    ):
        return {}
    query = "SELECT topic_type, encoding, encoded_message_definition FROM message_definitions"
    rows = database.execute(query)
    return {str(kind): str(text) for kind, encoding, text in rows if encoding == "ros2msg"}


def _metadata(
    database: sqlite3.Connection, path: Path, *, salvage: bool
) -> tuple[Mapping[str, str] | None, str]:
    """Return the strings in the copy of metadata.yaml that the file may have, and what is damaged of it."""
    try:
        if "metadata" not in _columns(database, "metadata"):
            return None, ""
        row = database.execute("SELECT metadata FROM metadata ORDER BY id DESC LIMIT 1").fetchone()
    except sqlite3.Error as error:
        if not salvage:
            raise
        return None, str(error)
    if row is None or not isinstance(row[0], str) or not row[0]:
        return None, ""
    try:
        return parse_bag_info(row[0], path).custom_data or None, ""
    except InputError:
        return None, ""  # it is a copy; metadata.yaml counts


def _rows(database: sqlite3.Connection, path: Path, *, salvage: bool) -> tuple[npt.NDArray[np.void], str]:
    """Return one `_ROW` a message, and what is damaged behind them."""
    data = ", data" if salvage else ""
    cursor = database.execute(f"SELECT id, topic_id, timestamp{data} FROM messages ORDER BY id")  # noqa: S608
    blocks: list[npt.NDArray[np.void]] = [np.empty(0, _ROW)]
    try:
        while rows := cursor.fetchmany(1 if salvage else _ROWS_AT_ONCE):
            blocks.append(_table(rows, path))
    except (sqlite3.Error, InputError) as error:
        if not salvage:
            raise
        return np.concatenate(blocks), str(error)
    return np.concatenate(blocks), ""


def _table(rows: list[tuple[object, ...]], path: Path) -> npt.NDArray[np.void]:
    if not all(isinstance(value, int) for row in rows for value in row[:3]):
        raise InputError("a message whose id, topic or time is no number", path=path, hint=_HINT)
    return np.array([row[:3] for row in rows], _ROW)
