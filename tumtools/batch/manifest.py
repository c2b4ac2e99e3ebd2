# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""The manifest: what is to be converted into what, and where to; the schema is in docs/reference/batch.md."""

from __future__ import annotations

import json
import os
import tomllib
from dataclasses import asdict, dataclass, field, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, NoReturn, cast

from tumtools.batch import schema
from tumtools.batch.places import WEB_SCHEMES, check_place, clean_place, is_remote
from tumtools.batch.toml_lines import Key, key_lines, line_of
from tumtools.errors import InputError, MissingInputError, UsageError
from tumtools.formats import registry
from tumtools.formats.calibration import read_calibration
from tumtools.formats.options import WriteOptions
from tumtools.model.camera import CAMERAS, CameraInfo

if TYPE_CHECKING:
    from collections.abc import Mapping

DEFAULT_TEMPLATE: Final = "{name}/{name}.{ext}"


@dataclass(frozen=True, slots=True)
class SourceSpec:
    """One `[[source]]`: exactly one of a path, names, or a filter of the catalogue.

    Attributes:
        path: A path, a pattern of paths, or a URL (of a store: a pattern too); absolute unless a URL.
        names: Names of the catalogue.
        camera: Filter: `fr1`, `fr2`, `fr3`.
        category: Filter: part of a category.
        kind: Filter: `sequence`, `validation`, `calibration`.
        exclude: Names or patterns of names to leave out.
        label: What `{name}` is, instead of the source's own name.
        fetch: Whether catalogue names that are not in the cache are downloaded when their turn comes.
        topics: Stream -> topic, for recordings where it cannot be told.
        salvage: Convert what is readable of a damaged recording.
        line: Where it is in the manifest.

    """

    path: str | None = None
    names: tuple[str, ...] = ()
    camera: str | None = None
    category: str | None = None
    kind: str | None = None
    exclude: tuple[str, ...] = ()
    label: str | None = None
    fetch: bool = False
    topics: Mapping[str, str] = field(default_factory=dict)
    salvage: bool = False
    line: int = 1


@dataclass(frozen=True, slots=True)
class Target:
    """One `[[target]]`: a format and the options of `convert`.

    Attributes:
        to: Name of the format.
        label: What `{target}` is; the name of the format unless told.
        ext: What `{ext}` is: suffix of the file without its dot; for folders the name of the format.
        write: Options of the format, those that are set, as plain values of JSON; `cameras` holds what was
            read from the file that `camera` names.
        start: First stamp kept, text as for `convert --start`.
        end: Last stamp kept.
        every: Keep each n-th image.
        streams: Keep these only.
        strict: A task that would lose anything fails.
        verify: Read the result back and compare.

    """

    to: str
    label: str
    ext: str
    write: Mapping[str, object] = field(default_factory=dict)
    start: str | None = None
    end: str | None = None
    every: int = 1
    streams: tuple[str, ...] | None = None
    strict: bool = False
    verify: bool = True

    def write_options(self, jobs: int = 1) -> WriteOptions:
        """Return the options of the format, with so many threads."""
        values = dict(self.write)
        cameras = cast("Mapping[str, Mapping[str, object]]", values.pop("cameras", {}))
        return WriteOptions(
            **values,  # type: ignore[arg-type]  # the manifest has checked the types
            cameras={stream: _camera(numbers) for stream, numbers in cameras.items()},
            jobs=jobs,
        )


def _camera(numbers: Mapping[str, object]) -> CameraInfo:
    """Build intrinsics from JSON, which has no tuples."""
    values = {key: tuple(value) if isinstance(value, list) else value for key, value in numbers.items()}
    return CameraInfo(**values)  # type: ignore[arg-type]  # written by `_read_camera`


@dataclass(frozen=True, slots=True)
class Policy:
    """What holds for all tasks.

    Attributes:
        validate: Level of validation before a conversion.
        on_findings: What to do when it finds something: convert all the same and note it, skip, or fail.
        fail_on: Least severity that counts as a finding.
        digest: Whether the content digest of each output is computed and noted.
        jobs: Threads within a task.

    """

    validate: str = "quick"
    on_findings: str = "warn"
    fail_on: str = "error"
    digest: bool = True
    jobs: int = 1


@dataclass(frozen=True, slots=True)
class Manifest:
    """A manifest that has been checked.

    Attributes:
        path: The file.
        destination: Absolute folder, or URL of a store.
        template: Name of an output below it.
        estimate: How sizes are estimated when planning.
        policy: What holds for all tasks.
        sources: In the order of the file.
        targets: In the order of the file.

    """

    path: Path
    destination: str
    template: str
    estimate: str
    policy: Policy
    sources: tuple[SourceSpec, ...]
    targets: tuple[Target, ...]


def read_manifest(path: Path) -> Manifest:
    """Read and check a manifest.

    Raises:
        MissingInputError: There is no such file.
        InputError: It is not TOML, or not a manifest; with the line.

    """
    try:
        text = path.read_bytes().decode("utf-8-sig").replace("\r\n", "\n")  # some editors begin with a mark
    except FileNotFoundError:
        raise MissingInputError("there is no such manifest", path=path) from None
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror or error}", path=path) from error
    except UnicodeDecodeError as error:
        raise InputError("not UTF-8, as TOML is", path=path, location=f"byte {error.start}") from error
    try:
        document = tomllib.loads(text)
    except (tomllib.TOMLDecodeError, RecursionError) as error:
        raise InputError(f"not TOML: {error}", path=path) from error
    return _Reader(path, text).manifest(document)


class _Reader:
    """Checks a document and builds the manifest; knows the lines for its errors."""

    def __init__(self, path: Path, text: str) -> None:
        self._path = path
        self._text = text
        self._lines: dict[Key, int] | None = None

    def manifest(self, document: Mapping[str, Any]) -> Manifest:
        self._check(schema.ROOT, document, ())
        for key in ("destination", "source", "target"):
            if key not in document:
                self._fail((), f"no {key}", f"a manifest has at least {_MINIMUM}")
        template = document.get("template", DEFAULT_TEMPLATE)
        problem = schema.template_problem(template)
        if problem:
            self._fail(("template",), problem, f"fields: {', '.join(schema.TEMPLATE_FIELDS)}")
        return Manifest(
            path=self._path,
            destination=self._destination(document["destination"]),
            template=template,
            estimate=document.get("estimate", "auto"),
            policy=Policy(
                **{item.name: document[item.name] for item in fields(Policy) if item.name in document}
            ),
            sources=tuple(self._source(table, index) for index, table in enumerate(document["source"])),
            targets=self._targets(document["target"]),
        )

    def _destination(self, text: str) -> str:
        place = self._place(text, ("destination",))
        if place.partition("://")[0] in WEB_SCHEMES:
            self._fail(
                ("destination",), "the web cannot be written to", "name a folder, or s3://, gs://, az://"
            )
        return place

    def _source(self, table: Mapping[str, Any], index: int) -> SourceSpec:
        where: Key = ("source", index)
        self._check(schema.SOURCE, table, where)
        filters = {key: table[key] for key in ("camera", "category", "kind") if key in table}
        given = [key for key in ("path", "name") if key in table] + (
            ["camera, category or kind"] if filters else []
        )
        if len(given) != 1:
            found = " and ".join(given) or "none of them"
            self._fail(where, f"expected a path, a name or a filter (camera, category, kind), got {found}")
        if "path" in table and "fetch" in table:
            self._fail((*where, "fetch"), "fetch has no effect on a path; it is for names of the catalogue")
        name = table.get("name", ())
        return SourceSpec(
            path=self._place(table["path"], (*where, "path"), pattern=True) if "path" in table else None,
            names=(name,) if isinstance(name, str) else tuple(name),
            exclude=tuple(table.get("exclude", ())),
            line=self._line(where),
            **filters,
            **{key: table[key] for key in ("label", "fetch", "topics", "salvage") if key in table},
        )

    def _targets(self, tables: list[Mapping[str, Any]]) -> tuple[Target, ...]:
        targets: dict[str, Target] = {}
        for index, table in enumerate(tables):
            where: Key = ("target", index)
            self._check(schema.TARGET, table, where)
            if "to" not in table:
                self._fail(where, "no format to convert to", 'for example: to = "mcap"')
            target = self._target(table, where)
            if target.label in targets:
                self._fail(where, f"a second target {target.label!r}", "give one of them a label of its own")
            targets[target.label] = target
        return tuple(targets.values())

    def _target(self, table: Mapping[str, Any], where: Key) -> Target:
        entry = registry.get(table["to"])
        write = {key: table[key] for key in schema.WRITE_KEYS if key in table}
        is_file = write.get("camera") not in {None, *CAMERAS}
        try:
            registry.check_options(
                entry, WriteOptions(**{**write, **({"camera": CAMERAS[0]} if is_file else {})})
            )
        except UsageError as error:
            key = next((key for key in write if f"--{key.replace('_', '-')}" in error.message), "to")
            self._fail((*where, key), error.message.replace("--", ""), error.hint)
        if is_file:
            write["cameras"] = self._read_camera(write.pop("camera"), (*where, "camera"))
        if "start" in table and "end" in table and schema.ends_before_it_starts(table["start"], table["end"]):
            self._fail((*where, "end"), f"the end {table['end']} is before the start {table['start']}")
        suffixes = tuple(suffix.lstrip(".") for suffix in (entry.suffix, *entry.suffixes) if suffix)
        ext = table.get("ext", entry.suffix.lstrip(".") or entry.name)
        if "ext" in table and ext not in suffixes:
            self._fail(
                (*where, "ext"), f"{entry.name} has no suffix {ext!r}", f"one of {', '.join(suffixes)}"
            )
        return Target(
            to=entry.name,
            label=table.get("label", entry.name),
            ext=ext,
            write=write,
            streams=tuple(table["streams"]) if "streams" in table else None,
            **{key: table[key] for key in ("start", "end", "every", "strict", "verify") if key in table},
        )

    def _read_camera(self, text: str, where: Key) -> dict[str, object]:
        """Read the file of a calibration, so that the plan holds it and changes with it."""
        try:
            numbers = json.loads(json.dumps(asdict(read_calibration(Path(self._local(text))))))
        except InputError as error:
            known = ", ".join(CAMERAS)
            self._fail(
                where, f"camera: {text}: {error.message}", f"one of {known}, or the file of a calibration"
            )
        # Depth is registered to colour and shares its intrinsics.
        return {"rgb": numbers, "depth": numbers}

    def _local(self, text: str) -> str:
        """Make a path absolute, from the folder of the manifest."""
        return os.path.normpath(self._path.absolute().parent / Path(text).expanduser())

    def _place(self, text: str, where: Key, *, pattern: bool = False) -> str:
        """Make a path absolute, from the folder of the manifest; check a URL."""
        problem = check_place(text, pattern=pattern)
        if problem:
            self._fail(where, problem)
        return clean_place(text) if is_remote(text) else self._local(text)

    def _check(self, table: Mapping[str, schema.Rule], values: object, where: Key) -> None:
        if not isinstance(values, dict):
            self._fail(where, f"expected a table, got {schema.words(values)}")
        for key, value in values.items():
            if key not in table:
                self._fail((*where, key), f"unknown key {key!r}", schema.suggest(key, table))
            fits, expected = table[key]
            if not fits(value):
                self._fail((*where, key), f"{key}: expected {expected}, got {schema.words(value)}")

    def _line(self, key: Key) -> int:
        if self._lines is None:
            self._lines = key_lines(self._text)
        return line_of(self._lines, key)

    def _fail(self, key: Key, message: str, hint: str | None = None) -> NoReturn:
        raise InputError(message, path=self._path, location=f"line {self._line(key)}", hint=hint)


_MINIMUM: Final = 'destination = "...", one [[source]] and one [[target]]'
