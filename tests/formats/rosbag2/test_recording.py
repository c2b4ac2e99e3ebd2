# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""rosbag2 folders of all kinds: two storages, split, compressed by file and by message, incomplete."""

from __future__ import annotations

import random
import shutil
import sqlite3
from collections import Counter
from contextlib import closing, suppress
from typing import TYPE_CHECKING

import pytest
import yaml
import zstandard
from mcap.writer import Writer as McapWriter
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

from tests.formats.mcap.foreign import Foreign
from tests.memory import Memory, groundtruth
from tumtools.convert import convert
from tumtools.errors import InputError, MissingInputError
from tumtools.formats.mcap.recording import McapRecording
from tumtools.formats.options import WriteOptions
from tumtools.formats.rosbag2.recording import Rosbag2Recording
from tumtools.sources import open_source

if TYPE_CHECKING:
    from pathlib import Path

STORE = get_typestore(Stores.ROS2_HUMBLE)
KIND = "std_msgs/msg/String"
START = 1_700_000_000_000_000_000
Messages = list[tuple[str, int, str]]


def some_messages(first: int = 0, count: int = 30) -> Messages:
    numbers = range(first, first + count)
    return [(f"/topic{i % 2}", START + i * 10_000_000, f"{i} " + "x" * (i * 37 % 900)) for i in numbers]


def write(path: Path, messages: Messages, storage: str = "sqlite3", mode: str = "none") -> Path:
    """Write a folder with somebody else's library."""
    writer = Writer(path, version=8, storage_plugin=StoragePlugin[storage.upper()])
    if mode != "none":
        writer.set_compression(CompressionMode[mode.upper()], CompressionFormat.ZSTD)
    with writer:
        connections = {
            topic: writer.add_connection(topic, KIND, typestore=STORE)
            for topic in sorted({m[0] for m in messages})
        }
        for topic, time, text in messages:
            writer.write(connections[topic], time, STORE.serialize_cdr(STORE.types[KIND](text), KIND))
    return path


def read(path: Path, *, salvage: bool = False) -> Messages:
    recording = Rosbag2Recording(path, salvage=salvage)
    try:
        return [
            (m.channel.topic, m.log_time, STORE.deserialize_cdr(bytes(m.data), KIND).data)
            for m in recording.messages(recording.channels)
        ]
    finally:
        recording.close()


def edit(folder: Path, **changes: object) -> None:
    """Change entries of metadata.yaml."""
    file = folder / "metadata.yaml"
    document = yaml.safe_load(file.read_text())
    document["rosbag2_bagfile_information"].update(changes)
    file.write_text(yaml.safe_dump(document))


def join(target: Path, *folders: Path) -> Path:
    """Make one split recording of several."""
    target.mkdir()
    names = []
    for number, folder in enumerate(folders):
        (file,) = (path for path in folder.iterdir() if path.name != "metadata.yaml")
        name = f"part_{number}{''.join(file.suffixes)}"
        shutil.copy(file, target / name)
        names.append(name)
    shutil.copy(folders[0] / "metadata.yaml", target)
    edit(target, relative_file_paths=names)
    return target


@pytest.mark.parametrize("storage", ["sqlite3", "mcap"])
@pytest.mark.parametrize("mode", ["none", "file", "message"])
def test_storages_and_compressions(tmp_path: Path, storage: str, mode: str) -> None:
    if (storage, mode) == ("mcap", "file"):
        folder = write(tmp_path / "bag", some_messages(), storage)
        packed = zstandard.compress((folder / "bag.mcap").read_bytes())
        (folder / "bag.mcap.zstd").write_bytes(packed)
        (folder / "bag.mcap").unlink()
        names = ["bag.mcap.zstd"]
        edit(folder, compression_mode="FILE", compression_format="zstd", relative_file_paths=names)
    else:
        folder = write(tmp_path / "bag", some_messages(), storage, mode)
    assert read(folder) == some_messages()


def test_a_compressed_file_that_was_cut_is_named_itself(tmp_path: Path) -> None:
    folder = write(tmp_path / "bag", some_messages(), "sqlite3", "file")
    (file,) = folder.glob("*.zstd")
    whole = zstandard.ZstdDecompressor().decompress(file.read_bytes(), max_output_size=2**24)
    packed = zstandard.ZstdCompressor().compress(whole + bytes(range(256)) * 2**12)
    file.write_bytes(packed[: len(packed) // 2])
    with pytest.raises(InputError, match="the file was cut") as caught:
        read(folder)
    assert caught.value.path == str(file)
    file.write_bytes(zstandard.compress(b"no database at all" * 100))
    with pytest.raises(InputError) as caught:
        read(folder)
    assert caught.value.path == str(file)


def test_channels_have_type_definition_and_count(tmp_path: Path) -> None:
    recording = Rosbag2Recording(write(tmp_path / "bag", some_messages()))
    assert [(c.topic, c.type, c.encoding, c.count) for c in recording.channels] == [
        ("/topic0", KIND, "cdr", 15),
        ("/topic1", KIND, "cdr", 15),
    ]
    assert "string data" in recording.channels[0].definition
    assert recording.warnings == ()


@pytest.mark.parametrize("storage", ["sqlite3", "mcap"])
def test_split_recording_is_one(tmp_path: Path, storage: str) -> None:
    parts = [write(tmp_path / str(i), some_messages(i * 30), storage) for i in range(3)]
    bag = join(tmp_path / "bag", *parts)
    assert read(bag) == some_messages(0, 90)
    assert [channel.count for channel in Rosbag2Recording(bag).channels] == [45, 45]


def test_parts_that_overlap_in_time_are_merged(tmp_path: Path) -> None:
    messages = some_messages(0, 90)
    parts = [write(tmp_path / str(i), messages[i::3]) for i in range(3)]
    assert read(join(tmp_path / "bag", *parts)) == messages


def in_batches(folder: Path) -> Messages:
    """Read what a folder has, many messages at a time."""
    with closing(Rosbag2Recording(folder)) as recording:
        found = [
            (batch.channel.topic, int(time), batch.data[start : start + length].tobytes())
            for batch in recording.batches(recording.channels)
            for time, start, length in zip(batch.log_times, batch.starts, batch.lengths, strict=True)
        ]
    return [(topic, time, STORE.deserialize_cdr(data, KIND).data) for topic, time, data in found]


@pytest.mark.parametrize("storage", ["sqlite3", "mcap"])
@pytest.mark.parametrize("mode", ["none", "message", "parts"])
def test_messages_come_in_batches_in_the_order_of_their_topics(
    tmp_path: Path, storage: str, mode: str
) -> None:
    messages = some_messages(0, 90)
    if mode == "parts":
        folder = join(
            tmp_path / "bag", *(write(tmp_path / str(i), messages[i::3], storage) for i in range(3))
        )
    else:
        folder = write(tmp_path / "bag", messages, storage, mode)
    found = in_batches(folder)
    for topic in ("/topic0", "/topic1"):
        assert [one for one in found if one[0] == topic] == [one for one in messages if one[0] == topic]


def test_channels_that_are_merged_come_in_batches_in_the_order_of_their_topic(tmp_path: Path) -> None:
    messages = some_messages(0, 40)
    folder = write(tmp_path / "bag", messages, "mcap")
    part = McapRecording(folder / "bag.mcap")
    copies = [(message.log_time, bytes(message.data)) for message in part.messages(part.channels)]
    with (folder / "bag.mcap").open("wb") as file:
        library = McapWriter(file)
        library.start(profile="ros2", library="x")
        schema = library.register_schema(KIND, "ros2msg", part.channels[0].definition.encode())
        channels = [library.register_channel("/topic", "cdr", schema, {"number": str(n)}) for n in range(2)]
        for number, (time, data) in enumerate(copies):
            library.add_message(channels[number % 2], time, data, time)
        library.finish()
    edit(folder, topics_with_message_count=[])
    assert in_batches(folder) == [("/topic", time, text) for _, time, text in messages]


def test_a_time_range_includes_both_ends(tmp_path: Path) -> None:
    messages = some_messages()
    recording = Rosbag2Recording(write(tmp_path / "bag", messages))
    found = recording.messages(recording.channels[:1], messages[4][1], messages[8][1])
    assert [message.log_time for message in found] == [messages[i][1] for i in (4, 6, 8)]


def test_one_sqlite_file_is_read_without_its_folder(tmp_path: Path) -> None:
    folder = write(tmp_path / "bag", some_messages())
    recording = Rosbag2Recording(folder / "bag.db3")
    assert recording.warnings == ("read without the metadata.yaml of its folder",)
    assert read(folder / "bag.db3") == some_messages()


@pytest.mark.parametrize("storage", ["sqlite3", "mcap"])
def test_one_file_of_ours_says_what_its_folder_says(tmp_path: Path, storage: str) -> None:
    source = Memory({"rgb": [START], "depth": [START]}, groundtruth=groundtruth())
    convert(source, tmp_path / "bag", "rosbag2", WriteOptions(storage=storage))
    (file,) = (path for path in (tmp_path / "bag").iterdir() if path.name != "metadata.yaml")
    with open_source(tmp_path / "bag") as whole, open_source(file) as part:
        assert part.info.name == whole.info.name == source.info.name
        assert part.info.digest == whole.info.digest is not None
        assert part.info.not_carried == whole.info.not_carried == ()


def test_what_others_note_beside_our_metadata_is_told_and_does_no_harm(tmp_path: Path) -> None:
    convert(Memory({"rgb": [START]}), tmp_path / "bag", "rosbag2")
    custom = dict(Rosbag2Recording(tmp_path / "bag").metadata or {})
    edit(tmp_path / "bag", custom_data={**custom, "operator": "Ada", "weather": "rain"})
    with open_source(tmp_path / "bag") as sequence:
        assert sequence.image_stamps("rgb").tolist() == [START]
        losses = [(loss.stream, loss.what, loss.count) for loss in sequence.info.not_carried]
    assert losses == [(f"custom_data {key}", "entry not carried over", 1) for key in ("operator", "weather")]
    edit(tmp_path / "bag", custom_data={**custom, "name": "another"})
    with pytest.raises(InputError, match="CRC"):
        open_source(tmp_path / "bag")


@pytest.mark.parametrize("keys", [["operator"], ["name", "version"]])
def test_what_others_note_in_a_recording_of_theirs_is_told(tmp_path: Path, keys: list[str]) -> None:
    folder = write(tmp_path / "bag", some_messages())
    edit(folder, custom_data=dict.fromkeys(keys, "x"))
    with open_source(folder) as sequence:
        told = [loss.stream for loss in sequence.info.not_carried]
    assert told == [*(f"custom_data {key}" for key in keys), "/topic0", "/topic1"]


def test_metadata_records_are_told_but_for_the_copy_of_metadata_yaml(tmp_path: Path) -> None:
    folder = write(tmp_path / "bag", some_messages(), "mcap")
    with Foreign(folder / "bag.mcap") as file:
        for name in ("rosbag2", "operator"):
            file.library.add_metadata(name, {"serialized_metadata": ""})
    with open_source(folder) as sequence:
        assert [loss.stream for loss in sequence.info.not_carried] == ["metadata operator"]


def test_folder_name_before_the_file_name_is_forgiven(tmp_path: Path) -> None:
    """The first versions of rosbag2 wrote it so."""
    folder = write(tmp_path / "bag", some_messages())
    edit(folder, relative_file_paths=["bag/bag.db3"])
    assert read(folder) == some_messages()


def test_files_outside_of_the_folder_are_not_read(tmp_path: Path) -> None:
    write(tmp_path / "secret", some_messages())
    folder = write(tmp_path / "bag", some_messages())
    for name in ("../secret/secret.db3", str(tmp_path / "secret" / "secret.db3")):
        edit(folder, relative_file_paths=[name])
        with pytest.raises(MissingInputError, match="missing"):
            Rosbag2Recording(folder)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"relative_file_paths": ["other.db3"]}, "'other.db3' that metadata.yaml lists is missing"),
        ({"relative_file_paths": []}, "lists no files"),
        ({"relative_file_paths": 7}, "no list of file names"),
        ({"storage_identifier": "postgres"}, "storage 'postgres', read are sqlite3, mcap"),
        ({"compression_mode": "FILE", "compression_format": "lz4"}, "'lz4', only zstd is read"),
        ({"compression_mode": "STREAM"}, "compression mode 'stream'"),
    ],
)
def test_descriptions_that_do_not_fit_are_refused(
    tmp_path: Path, changes: dict[str, object], message: str
) -> None:
    folder = write(tmp_path / "bag", some_messages())
    edit(folder, **changes)
    with pytest.raises(InputError, match=message):
        Rosbag2Recording(folder)


@pytest.mark.parametrize(
    "text", ["", "a: [", "\x00", "rosbag2_bagfile_information: 3", "[" * 5000, "- " * 5000]
)
def test_damaged_metadata_is_an_error_of_ours(tmp_path: Path, text: str) -> None:
    folder = write(tmp_path / "bag", some_messages())
    (folder / "metadata.yaml").write_text(text)
    with pytest.raises(InputError, match=r"metadata\.yaml"):
        Rosbag2Recording(folder)


def test_serialization_that_is_not_cdr_is_named(tmp_path: Path) -> None:
    folder = write(tmp_path / "bag", some_messages())
    with closing(sqlite3.connect(folder / "bag.db3")) as database:
        database.execute("UPDATE topics SET serialization_format = 'protobuf' WHERE id = 1")
        database.commit()
    recording = Rosbag2Recording(folder)
    assert len(recording.channels) == 1
    assert [(loss.count, loss.why) for loss in recording.not_carried] == [
        (15, "'protobuf', only cdr is read")
    ]


def test_recordings_from_before_iron_have_no_definitions(tmp_path: Path) -> None:
    folder = write(tmp_path / "bag", some_messages())
    with closing(sqlite3.connect(folder / "bag.db3")) as database:
        for table in ("message_definitions", "metadata", "schema"):
            database.execute(f"DROP TABLE {table}")
        database.commit()
    assert read(folder) == some_messages()
    assert Rosbag2Recording(folder).channels[0].definition == ""


def test_a_database_of_something_else_is_refused(tmp_path: Path) -> None:
    with closing(sqlite3.connect(tmp_path / "a.db3")) as database:
        database.execute("CREATE TABLE topics(id)")
        database.execute("CREATE VIEW messages AS SELECT 1")
    with pytest.raises(InputError, match="no table 'messages'"):
        Rosbag2Recording(tmp_path / "a.db3")
    (tmp_path / "b.db3").write_bytes(b"")
    with pytest.raises(InputError, match=r"empty \(0 bytes\)"):
        Rosbag2Recording(tmp_path / "b.db3")


def test_a_message_that_claims_to_be_huge_takes_no_memory(tmp_path: Path) -> None:
    folder = write(tmp_path / "bag", some_messages(), mode="message")
    bomb = zstandard.ZstdCompressor(write_content_size=True).compress(bytes(300 * 2**20))
    with closing(sqlite3.connect(folder / "bag.db3")) as database:
        database.execute("UPDATE messages SET data = ? WHERE id = 3", (bomb,))
        database.commit()
    with pytest.raises(InputError, match="a message of 314572800 bytes"):
        read(folder)


def test_what_comes_before_a_cut_is_salvaged(tmp_path: Path) -> None:
    folder = write(tmp_path / "bag", some_messages(0, 400))
    data = (folder / "bag.db3").read_bytes()
    (folder / "bag.db3").write_bytes(data[: len(data) // 2])
    with pytest.raises(InputError, match="damaged") as error:
        read(folder)
    assert "--salvage" in str(error.value)
    found = read(folder, salvage=True)
    assert 50 < len(found) < 400
    assert found == some_messages(0, 400)[: len(found)]
    assert any("only the" in text for text in Rosbag2Recording(folder, salvage=True).warnings)
    lost = Counter(topic for topic, _, _ in some_messages(0, 400)[len(found) :])
    assert left_out(folder) == {
        (topic, "messages left out as damaged"): count for topic, count in lost.items()
    }
    # The file by itself does not say how many there should be.
    assert left_out(folder / "bag.db3")["recording", "messages behind the damage left out as damaged"] == 1


def left_out(path: Path) -> dict[tuple[str, str], int]:
    """Return what a salvage tells that it leaves out."""
    with closing(Rosbag2Recording(path, salvage=True)) as recording:
        assert all(loss.why for loss in recording.left_out)
        return {(loss.stream, loss.what): loss.count for loss in recording.left_out}


@pytest.mark.parametrize("is_there", [True, False], ids=["damaged", "missing"])
@pytest.mark.parametrize("number", [0, 1])
@pytest.mark.parametrize("storage", ["sqlite3", "mcap"])
def test_a_salvage_passes_over_a_file_that_cannot_be_read_and_tells_its_messages(
    tmp_path: Path, storage: str, number: int, is_there: bool
) -> None:
    parts = [write(tmp_path / str(n), some_messages(30 * n), storage) for n in range(3)]
    folder = join(tmp_path / "all", *parts)
    topics = yaml.safe_load((folder / "metadata.yaml").read_text())["rosbag2_bagfile_information"]
    listed = topics["topics_with_message_count"]
    edit(folder, topics_with_message_count=[topic | {"message_count": 45} for topic in listed])
    assert left_out(folder) == {}
    lost = next(folder.glob(f"part_{number}*"))
    lost.write_bytes(b"nothing of the sort")
    if not is_there:
        lost.unlink()
    with pytest.raises(InputError):
        read(folder)
    others = [message for n in range(3) if n != number for message in some_messages(30 * n)]
    assert read(folder, salvage=True) == others
    assert left_out(folder) == {(f"/topic{n}", "messages left out as damaged"): 15 for n in range(2)}
    edit(folder, topics_with_message_count=[])
    assert left_out(folder) == {("recording", "files left out as damaged"): 1}


@pytest.mark.parametrize("storage", ["sqlite3", "mcap"])
@pytest.mark.parametrize("mode", ["none", "file", "message"])
def test_a_salvage_of_a_sound_recording_leaves_nothing_out(tmp_path: Path, storage: str, mode: str) -> None:
    if (storage, mode) != ("mcap", "file"):
        assert left_out(write(tmp_path / "bag", some_messages(), storage, mode)) == {}


def test_messages_of_a_topic_that_is_not_listed_are_told(tmp_path: Path) -> None:
    folder = write(tmp_path / "bag", some_messages())
    with closing(sqlite3.connect(folder / "bag.db3")) as database:
        database.execute("DELETE FROM topics WHERE name = '/topic1'")
        database.commit()
    assert left_out(folder) == {("/topic1", "messages left out as damaged"): 15}
    assert left_out(folder / "bag.db3") == {("recording", "messages left out as damaged"): 15}


@pytest.mark.parametrize("mode", ["none", "file", "message"])
def test_neither_cuts_nor_flipped_bits_give_anything_but_errors_of_ours(tmp_path: Path, mode: str) -> None:
    folder = write(tmp_path / "bag", some_messages(0, 12), mode=mode)
    (file,) = (path for path in folder.iterdir() if path.name != "metadata.yaml")
    data = file.read_bytes()
    generator = random.Random(3)
    for number in range(200):
        place = generator.randrange(len(data))
        damaged = bytearray(data if number % 2 else data[:place])
        if number % 2:
            damaged[place] ^= 1 << generator.randrange(8)
        file.write_bytes(damaged)
        for salvage in (False, True):
            with suppress(InputError), closing(Rosbag2Recording(folder, salvage=salvage)) as recording:
                for _ in recording.messages(recording.channels):
                    pass
