# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""What a salvage leaves out of a MCAP file: by message where the summary counts them, else in bytes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from tumtools.model.sequence import LEFT_OUT, RECORDING, Loss

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from tumtools.errors import InputError
    from tumtools.formats.mcap.statistics import Statistics

_UNKNOWN_END: Final = "the file was cut off; how it went on is not known"


@dataclass(slots=True)
class PassedOver:
    """What was passed over.

    Attributes:
        nbytes: Bytes of records that could not be read.
        is_cut: Whether the file does not end as it should.

    """

    nbytes: int = 0
    is_cut: bool = False
    _why: str = ""
    _statistics: Statistics | None = None
    _attachments: int = 0
    _records: int = 0

    def add(self, error: InputError, nbytes: int) -> None:
        """Note that so many bytes are left out because of an error."""
        self._why = self._why or f"{error.location}: {error.message}"
        self.nbytes += nbytes

    def promise(self, statistics: Statistics | None, attachments: int, records: int) -> None:
        """Note what there should be, by a summary whose checksum is right.

        Args:
            statistics: With the number of messages; None if they are not counted.
            attachments: How many there are.
            records: How many metadata records there are.

        """
        self._statistics, self._attachments, self._records = statistics, attachments, records

    def losses(
        self, found: Mapping[int, int], topics: Mapping[int, str], attachments: int, records: int
    ) -> Iterator[Loss]:
        """Yield what is not there.

        Args:
            found: Messages of each channel that could be read.
            topics: Of the channels, as far as they are known.
            attachments: How many could be found.
            records: How many metadata records could be found.

        """
        why = self._why or "the summary of the file counts more than are there"
        if self._statistics is None and self.nbytes:
            yield Loss(RECORDING, f"bytes {LEFT_OUT}", self.nbytes, why)
        for number, missing in self._statistics.missing(found) if self._statistics else ():
            yield Loss(topics.get(number, RECORDING), f"messages {LEFT_OUT}", missing, why)
        if self.is_cut:
            yield Loss(RECORDING, "end missing", 1, _UNKNOWN_END)
        if self._attachments > attachments:
            yield Loss("attachments", LEFT_OUT, self._attachments - attachments, why)
        if self._records > records:
            yield Loss("metadata records", LEFT_OUT, self._records - records, why)
