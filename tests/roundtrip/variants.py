# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Every way in which a format can be written, taken from the registry: a new option is covered by itself."""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import permutations
from typing import TYPE_CHECKING, Final

from tumtools.formats.options import WriteOptions
from tumtools.formats.registry import FORMATS

if TYPE_CHECKING:
    from collections.abc import Mapping

VALUES: Final[dict[str, tuple[object, ...]]] = {
    "archive": (True,),
    "camera": ("fr3",),
    "frame_ids": ({"rgb": "head_camera", "groundtruth": "mocap"},),
    "topics": ({"rgb": "/kinect/color", "accelerometer": "/kinect/imu"},),
}
"""Values to try of options that take any; an option of the registry that is neither here nor has values
there is an error."""

REQUIRES: Final[dict[tuple[str, str], dict[str, object]]] = {("rosbag2", "compression"): {"storage": "mcap"}}
"""Other options without which the values of one are refused, but for its default."""

COMBINATIONS: Final[tuple[tuple[str, dict[str, object]], ...]] = (
    ("mcap", {"profile": "ros1", "layout": "published", "color_encoding": "bgr8", "compression": "lz4"}),
    ("mcap", {"profile": "ros1", "archive": True, "groundtruth": "tf", "compression": "none"}),
    ("mcap", {"color_encoding": "rgb8", "depth_encoding": "png", "groundtruth": "pose"}),
    ("mcap", {"color_encoding": "rgb8", "depth_encoding": "16UC1", "layout": "published"}),
    ("rosbag1", {"layout": "modern", "color_encoding": "png", "depth_encoding": "16UC1"}),
    ("rosbag1", {"archive": True, "compression": "lz4", "groundtruth": "pose"}),
    ("rosbag1", {"color_encoding": "bgr8", "depth_encoding": "png", "compression": "bz2"}),
    ("rosbag2", {"storage": "mcap", "archive": True, "ros_distro": "jazzy"}),
    ("rosbag2", {"storage": "mcap", "layout": "published", "color_encoding": "bgr8", "ros_distro": "foxy"}),
    ("rosbag2", {"color_encoding": "rgb8", "depth_encoding": "16UC1", "groundtruth": "tf"}),
    ("rosbag2", {"archive": True, "ros_distro": "galactic", "layout": "published"}),
    ("rawlog", {"dialect": "legacy", "compression": "none"}),
    ("rawlog", {"dialect": "converter", "compression": "none"}),
)


@dataclass(frozen=True)
class Variant:
    """A format with options.

    Attributes:
        format: Name of the format.
        options: Of `WriteOptions`; empty for the defaults.
        suffix: Of the target.

    """

    format: str
    options: Mapping[str, object] = field(default_factory=dict, hash=False)
    suffix: str = ""

    def __str__(self) -> str:
        shown = [_shown(name, value) for name, value in self.options.items()]
        return " ".join([self.format + (self.suffix if self.format == "tum" else ""), *shown])

    def option(self, name: str) -> object:
        """Return what an option amounts to: its value, or the default of the format."""
        if name in self.options:
            return self.options[name]
        values = FORMATS[self.format].options.get(name, ())
        return values[0] if values else None

    @property
    def write_options(self) -> WriteOptions:
        """The options as the writer gets them; one thread, as there are only a few small frames."""
        return WriteOptions(jobs=1, **self.options)  # type: ignore[arg-type]  # names and values are the registry's


def _shown(name: str, value: object) -> str:
    flag = {"frame_ids": "--frame-id", "topics": "--topic"}.get(name, "--" + name.replace("_", "-"))
    if isinstance(value, dict):
        return " ".join(f"{flag} {key}={one}" for key, one in value.items())
    return flag if value is True else f"{flag} {value}"


def defaults() -> list[Variant]:
    """Return each format with its default options."""
    return [Variant(name, {}, entry.suffix) for name, entry in FORMATS.items()]


def single_options() -> list[Variant]:
    """Return each format with each value of each option that is not the default, and other suffixes."""
    found = [Variant("tum", {}, FORMATS["tum"].suffixes[0])]
    for name, entry in FORMATS.items():
        for option, values in entry.options.items():
            for value in values[1:] or VALUES[option]:
                options = {option: value, **REQUIRES.get((name, option), {})}
                found.append(Variant(name, options, entry.suffix))
    return found


def combinations() -> list[Variant]:
    """Return the combinations of options."""
    return [Variant(name, options, FORMATS[name].suffix) for name, options in COMBINATIONS]


def all_variants() -> list[Variant]:
    """Return all of them."""
    return defaults() + single_options() + combinations()


Chain = tuple[Variant, ...]
"""A source, and what it is converted to, one after another."""


def pairs() -> list[Chain]:
    """Return A -> B -> A for every variant B, from every format A and from the variant itself."""
    chains = [(a, b, a) for b in all_variants() for a in defaults()]
    # A source that is written with options, to the format that the benchmark has.
    tum = defaults()[0]
    return chains + [(a, tum, a) for a in single_options() + combinations()]


def triples() -> list[Chain]:
    """Return A -> B -> C -> A for all formats that differ, with default options."""
    return [(a, b, c, a) for a, b, c in permutations(defaults(), 3)]


def chain_name(chain: Chain) -> str:
    """Return the name of a cell."""
    return " -> ".join(map(str, chain))


def awkward_variants() -> list[Variant]:
    """Return the ways of writing that awkward contents go through: each kind of container and message."""
    more = (
        Variant("tum", {}, ".tgz"),
        Variant("mcap", {"profile": "ros1", "archive": True}, ".mcap"),
        Variant("mcap", {"color_encoding": "bgr8", "depth_encoding": "png"}, ".mcap"),
        Variant("rawlog", {"dialect": "legacy"}),
        Variant("rosbag1", {"color_encoding": "png", "groundtruth": "pose", "compression": "lz4"}, ".bag"),
        Variant("rosbag2", {"storage": "mcap", "color_encoding": "rgb8"}),
    )
    return [*defaults(), *more]
