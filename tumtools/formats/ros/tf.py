# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Trees of coordinate transforms (tf): from the messages of /tf and /tf_static to one trajectory.

Frames are named without a leading slash: tf of ROS 1 takes both for the same, tf2 refuses the slash.
"""

from __future__ import annotations

from collections import defaultdict
from functools import cached_property
from typing import TYPE_CHECKING, Final

import numpy as np

from tumtools.errors import UsageError
from tumtools.formats.ros.besides import Lateness, late_losses, lateness
from tumtools.formats.ros.signals import transforms_in
from tumtools.model.sequence import Loss
from tumtools.model.signals import Trajectory

if TYPE_CHECKING:
    from collections.abc import Iterator

    import numpy.typing as npt

    from tumtools.formats.ros.codec import Columns

Edge = tuple[str, str]
"""Parent and child frame."""

_SHOWN: Final = 3
"""Transforms that a message names."""
_NEARLY_PARALLEL: Final = 0.9995
"""Cosine above which the sine in the slerp is too small to divide by."""


class TransformTree:
    """All transforms of a recording."""

    def __init__(self) -> None:
        self._parts: defaultdict[Edge, list[Trajectory]] = defaultdict(list)
        self._late: defaultdict[Edge, Lateness] = defaultdict(Lateness)

    def add(self, part: Columns, log_times: npt.NDArray[np.int64]) -> None:
        """Add the transforms of decoded messages; what is not finite is left out."""
        for parent, child, found in transforms_in(part):
            self._late[parent.lstrip("/"), child.lstrip("/")] += lateness(log_times, found.stamps)
            usable = np.flatnonzero(np.isfinite(found.values).all(axis=1) & found.quaternions.any(axis=1))
            if len(usable):
                self._parts[parent.lstrip("/"), child.lstrip("/")].append(found.take(usable))

    @cached_property
    def edges(self) -> dict[Edge, Trajectory]:
        """Parent and child -> the child's poses in the parent, by stamp; complete when this is asked for."""
        return {edge: _by_stamp(found) for edge, found in self._parts.items()}

    @property
    def frames(self) -> list[str]:
        """All frames, sorted."""
        return sorted({frame for edge in self.edges for frame in edge})

    def moving(self) -> list[Edge]:
        """Return the edges whose transform changes."""
        return [edge for edge, one in self.edges.items() if not _is_constant(one)]

    def late(self, path: list[Edge]) -> Lateness:
        """Return how the moving transforms of a path were logged at other times than their stamps say.

        Stamps of what stands still say nothing.
        """
        return sum((self._late[edge] for edge in self.moving() if edge in path), Lateness())

    def path(self, child: str, root: str | None = None) -> list[Edge]:
        """Return the edges from a root down to a frame.

        Args:
            child: The frame.
            root: Where to begin; the topmost ancestor unless told.

        Returns:
            The edges; empty if there is no way.

        """
        path: list[Edge] = []
        seen = {child}
        while child != root:
            parents = [edge for edge in self.edges if edge[1] == child and edge[0] not in seen]
            if not parents:
                break
            # A frame with two parents is wrong, but is met where recordings were merged.
            edge = max(parents, key=lambda edge: (len(self.edges[edge]), edge))
            path.insert(0, edge)
            child = edge[0]
            seen.add(child)
        return path if root is None or (path and path[0][0] == root) else []

    def compose(self, path: list[Edge]) -> tuple[Trajectory, int]:
        """Multiply the transforms of a path.

        The stamps are those of the edge that moves with the most samples. Edges that do not change hold
        always; others are interpolated, and where they are not known there is no pose.

        Returns:
            Poses of the last frame in the first, and the number of samples that are left out.

        """
        moving = [edge for edge in path if not _is_constant(self.edges[edge])]
        leader = max(moving or path, key=lambda edge: len(self.edges[edge]))
        stamps = self.edges[leader].stamps
        known = np.ones(len(stamps), bool)
        for edge in moving:
            one = self.edges[edge].stamps
            known &= (stamps >= one[0]) & (stamps <= one[-1])
        stamps = stamps[known]
        poses = [self._at(edge, stamps, exact=edge == leader) for edge in path]
        result = poses[0]
        for pose in poses[1:]:
            result = _multiply(result, pose)
        return Trajectory(stamps, *result), int(np.count_nonzero(~known))

    def _at(self, edge: Edge, stamps: npt.NDArray[np.int64], *, exact: bool) -> _Pose:
        one = self.edges[edge]
        if exact:
            rows = np.searchsorted(one.stamps, stamps)
            return one.positions[rows], one.quaternions[rows]
        if _is_constant(one):
            shape = len(stamps)
            return np.tile(one.positions[0], (shape, 1)), np.tile(one.quaternions[0], (shape, 1))
        return _interpolate(one, stamps)


_Pose = tuple["npt.NDArray[np.float64]", "npt.NDArray[np.float64]"]
"""Positions [n, 3] and quaternions [n, 4] as x y z w."""


def _by_stamp(parts: list[Trajectory]) -> Trajectory:
    """Join and sort; a transform that is sent again with the same stamp counts once."""
    stamps = np.concatenate([part.stamps for part in parts])
    stamps, first = np.unique(stamps, return_index=True)
    positions = np.concatenate([part.positions for part in parts])[first]
    return Trajectory(stamps, positions, np.concatenate([part.quaternions for part in parts])[first])


def _is_constant(one: Trajectory) -> bool:
    return bool((one.values == one.values[:1]).all())


def _normalised(quaternions: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    result: npt.NDArray[np.float64] = quaternions / np.linalg.norm(quaternions, axis=1, keepdims=True)
    return result


def _multiply(first: _Pose, second: _Pose) -> _Pose:
    """Compose poses: apply the second, then the first."""
    (p1, q1), (p2, q2) = (first[0], _normalised(first[1])), (second[0], _normalised(second[1]))
    v1, w1, v2, w2 = q1[:, :3], q1[:, 3:], q2[:, :3], q2[:, 3:]
    vector = w1 * v2 + w2 * v1 + np.cross(v1, v2)
    scalar = w1 * w2 - np.sum(v1 * v2, axis=1, keepdims=True)
    twice = 2.0 * np.cross(v1, p2)
    return p1 + p2 + w1 * twice + np.cross(v1, twice), np.concatenate([vector, scalar], axis=1)


def _interpolate(one: Trajectory, stamps: npt.NDArray[np.int64]) -> _Pose:
    """Interpolate positions linearly and rotations on the shorter arc; stamps are within range."""
    after = np.clip(np.searchsorted(one.stamps, stamps), 1, len(one) - 1)
    before = after - 1
    span = one.stamps[after] - one.stamps[before]
    share = ((stamps - one.stamps[before]) / span)[:, None]
    positions = (1 - share) * one.positions[before] + share * one.positions[after]
    q1, q2 = _normalised(one.quaternions[before]), _normalised(one.quaternions[after])
    cosine = np.sum(q1 * q2, axis=1, keepdims=True)
    q2 = np.where(cosine < 0, -q2, q2)
    cosine = np.minimum(np.abs(cosine), 1.0)
    angle = np.arccos(cosine)
    with np.errstate(invalid="ignore", divide="ignore"):
        arc = (np.sin((1 - share) * angle) * q1 + np.sin(share * angle) * q2) / np.sin(angle)
    line = (1 - share) * q1 + share * q2
    return positions, _normalised(np.where(cosine > _NEARLY_PARALLEL, line, arc))


def find_path(tree: TransformTree, camera: str | None, frames: str = "") -> list[Edge]:
    """Find the edges from the world to the camera.

    Args:
        tree: All transforms.
        camera: Frame of the images, if there are any.
        frames: `world.camera` as the user asked for; empty to look for it.

    Returns:
        The edges, at least one of which moves; empty if there is no such path.

    Raises:
        UsageError: The frames asked for are not connected.

    """
    if frames:
        ends = [(frames[:at], frames[at + 1 :]) for at, letter in enumerate(frames) if letter == "."]
        for root, child in ends:
            path = tree.path(child.lstrip("/"), root.lstrip("/"))
            if path:
                return path
        raise UsageError(
            f"no transforms lead from one frame of {frames!r} to the other",
            hint=f"write world.camera; frames: {', '.join(tree.frames)}",
        )
    moving = tree.moving()
    if camera is None and len(moving) == 1:
        camera = moving[0][1]
    path = tree.path(camera.lstrip("/")) if camera else []
    return path if any(edge in moving for edge in path) else []


def way_of(path: list[Edge]) -> str:
    """Return a path for messages."""
    return " -> ".join([path[0][0], *(child for _, child in path)])


def losses_of_path(tree: TransformTree, path: list[Edge], left_out: int) -> Iterator[Loss]:
    """Yield what is lost of the transforms when a path is taken for the ground truth.

    Args:
        tree: All transforms.
        path: The edges that were composed.
        left_out: Samples that `TransformTree.compose` left out.

    """
    yield from late_losses("groundtruth", tree.late(path))
    if left_out:
        why = f"not all of {way_of(path)} is known at their time"
        yield Loss("groundtruth", "poses not carried over", left_out, why)
    beside = {edge: len(one) for edge, one in tree.edges.items() if edge not in path}
    if beside:
        places = ", ".join(f"{parent} -> {child}" for parent, child in sorted(beside)[:_SHOWN])
        more = f" and {len(beside) - _SHOWN} more" if len(beside) > _SHOWN else ""
        why = f"a sequence has one trajectory, {way_of(path)}; these are {places}{more}"
        yield Loss("groundtruth", "transforms not carried over", sum(beside.values()), why)
