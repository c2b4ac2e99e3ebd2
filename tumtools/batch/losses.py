# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""What the tasks of a batch lost, added up for each target."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from tumtools.batch.ledger import DONE
from tumtools.model.sequence import Loss, sum_losses

if TYPE_CHECKING:
    from collections.abc import Iterable

    from tumtools.batch.ledger import Entry
    from tumtools.batch.plan import Task


@dataclass(frozen=True, slots=True)
class TargetLoss:
    """One kind of loss of all tasks of a target.

    Attributes:
        target: Label of the target.
        loss: The loss; counts are added, the error is the largest.
        outputs: Names of the outputs that lack it, in the order of the tasks.

    """

    target: str
    loss: Loss
    outputs: tuple[str, ...]


def sum_up(tasks: Iterable[tuple[Task, Entry | None]]) -> list[TargetLoss]:
    """Add up what done tasks lost; losses that differ in count and error only are of one kind."""
    found: defaultdict[tuple[str, Loss], list[tuple[str, Loss]]] = defaultdict(list)
    for task, entry in tasks:
        if entry is None or entry.state != DONE:
            continue
        for loss in entry.losses:
            kind = replace(loss, count=0, largest_error=None)
            found[task.target.label, kind].append((task.output, loss))
    return [
        TargetLoss(label, sum_losses(loss for _, loss in each)[0], tuple(name for name, _ in each))
        for (label, _), each in found.items()
    ]
