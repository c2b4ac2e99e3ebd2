# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""`tumtools evaluate`."""

from __future__ import annotations

import click

from tumtools.cli.evaluate_ate import command as ate
from tumtools.cli.evaluate_rpe import command as rpe


@click.group(name="evaluate")
def command() -> None:
    """Measure an estimated trajectory against the ground truth."""


command.add_command(ate)
command.add_command(rpe)
