# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Progress of downloads: a line for each, with rate and time left, while stderr is a terminal."""

from __future__ import annotations

import sys
from contextlib import contextmanager
from threading import Lock
from typing import TYPE_CHECKING, Never

from tumtools.cli import output

if TYPE_CHECKING:
    from collections.abc import Iterator

    from tqdm import tqdm

    from tumtools.fetch.options import Event, Report


@contextmanager
def fetch_progress() -> Iterator[Report]:
    """Give what `fetch_all` reports to; notes are printed with -v, or where there is no bar."""
    if output.verbosity < 0 or not sys.stderr.isatty():
        yield _print_note
        return
    bars = _Bars()
    try:
        yield bars
    finally:
        bars.close()


def _print_note(event: Event) -> None:
    if event.stage in ("note", "waiting"):
        output.message(f"{event.name}: {event.message}")


class _Bars:
    """One line for each sequence."""

    def __init__(self) -> None:
        self._bars: dict[str, tqdm[Never]] = {}
        self._lock = Lock()  # events come from several threads

    def __call__(self, event: Event) -> None:
        from tqdm import tqdm

        with self._lock:
            if event.stage in ("note", "waiting"):
                tqdm.write(f"{event.name}: {event.message}", file=sys.stderr)
            elif event.stage == "downloading":
                bar = self._bars.get(event.name)
                if bar is None:
                    # `initial` keeps what was there before out of the rate.
                    bar = self._bars[event.name] = tqdm(
                        desc=event.name,
                        total=event.total,
                        initial=event.done,
                        unit="B",
                        unit_scale=True,
                        dynamic_ncols=True,
                        leave=False,
                    )
                bar.total = event.total
                bar.update(event.done - bar.n)
            elif event.name in self._bars:
                self._bars.pop(event.name).close()

    def close(self) -> None:
        for bar in self._bars.values():
            bar.close()
