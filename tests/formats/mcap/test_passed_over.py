# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""What a salvage leaves out is told with a reason."""

from __future__ import annotations

from tumtools.errors import InputError
from tumtools.formats.mcap.passed_over import PassedOver
from tumtools.formats.mcap.statistics import Statistics
from tumtools.model.sequence import Loss

TOPICS = {1: "/a"}


def test_messages_that_are_counted_and_not_there_have_a_reason_even_without_damage() -> None:
    passed_over = PassedOver()
    passed_over.promise(Statistics(0, 5, 1, 0, {1: 5}), 1, 0)
    why = "the summary of the file counts more than are there"
    assert list(passed_over.losses({1: 3}, TOPICS, 0, 0)) == [
        Loss("/a", "messages left out as damaged", 2, why),
        Loss("attachments", "left out as damaged", 1, why),
    ]


def test_messages_that_are_not_counted_by_channel_are_missing_of_the_recording() -> None:
    passed_over = PassedOver()
    passed_over.promise(Statistics(0, 5, 0, 0, None), 0, 0)
    passed_over.add(InputError("a wrong CRC", path="x", location="offset 7"), 100)
    (loss,) = passed_over.losses({1: 3, 2: 1}, TOPICS, 0, 0)
    assert (loss.stream, loss.what, loss.count) == ("recording", "messages left out as damaged", 1)


def test_the_first_damage_is_the_reason() -> None:
    passed_over = PassedOver()
    passed_over.promise(Statistics(0, 5, 0, 0, {1: 5}), 0, 0)
    for place in (7, 9):
        passed_over.add(InputError("a wrong CRC", path="x", location=f"offset {place}"), 100)
    (loss,) = passed_over.losses({1: 3}, TOPICS, 0, 0)
    assert loss.why == "offset 7: a wrong CRC"
