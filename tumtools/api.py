# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""The public Python API in one place.

It is a module of its own and not the package itself, since `tumtools --help` would pay for these imports,
and since functions such as `convert` have the names of the modules that they live in::

    from pathlib import Path
    from tumtools import api

    with api.open("rgbd_dataset_freiburg1_rpy") as sequence:
        report = api.convert(sequence, Path("rpy.mcap"), "mcap")
        print(report.losses)
"""

from __future__ import annotations

from tumtools.batch.control import batch_status, plan_batch, retry_batch, run_batch
from tumtools.batch.engines.engine import EngineSettings
from tumtools.batch.ledger import Entry as BatchEntry
from tumtools.batch.losses import TargetLoss
from tumtools.batch.losses import sum_up as sum_batch_losses
from tumtools.batch.plan import Plan as BatchPlan
from tumtools.batch.plan import Task as BatchTask
from tumtools.batch.plan_file import read_plan as read_batch_plan
from tumtools.batch.plan_file import write_plan as write_batch_plan
from tumtools.batch.run import RunOptions as BatchOptions
from tumtools.batch.status import Standing as BatchStanding
from tumtools.batch.task import Outcome as BatchOutcome
from tumtools.convert import ConvertOptions, Report, convert
from tumtools.diff import Comparison, Difference, Tolerances, diff
from tumtools.digest import Digest, digest
from tumtools.errors import (
    FetchError,
    InputError,
    IntegrityError,
    InternalError,
    LossRefusedError,
    OutputError,
    TumtoolsError,
    UsageError,
)
from tumtools.evaluate.allpairs import evaluate_rpe_all_pairs
from tumtools.evaluate.associate import associate
from tumtools.evaluate.ate import evaluate_ate
from tumtools.evaluate.rpe import evaluate_rpe
from tumtools.evaluate.summary import summarise
from tumtools.fetch.job import fetch
from tumtools.formats.options import ReadOptions, WriteOptions
from tumtools.images.codec import pixels_of, png_of
from tumtools.model.camera import CameraInfo
from tumtools.model.image import Image
from tumtools.model.sequence import Frame, Loss, Sequence, SequenceInfo
from tumtools.model.signals import Accelerometer, Trajectory
from tumtools.sources import open_source as open  # noqa: A004 - `api.open` reads as what it does
from tumtools.synthetic import synthesize
from tumtools.transform import Selection, select
from tumtools.validate.engine import validate

__all__ = [
    "Accelerometer",
    "BatchEntry",
    "BatchOptions",
    "BatchOutcome",
    "BatchPlan",
    "BatchStanding",
    "BatchTask",
    "CameraInfo",
    "Comparison",
    "ConvertOptions",
    "Difference",
    "Digest",
    "EngineSettings",
    "FetchError",
    "Frame",
    "Image",
    "InputError",
    "IntegrityError",
    "InternalError",
    "Loss",
    "LossRefusedError",
    "OutputError",
    "ReadOptions",
    "Report",
    "Selection",
    "Sequence",
    "SequenceInfo",
    "TargetLoss",
    "Tolerances",
    "Trajectory",
    "TumtoolsError",
    "UsageError",
    "WriteOptions",
    "associate",
    "batch_status",
    "convert",
    "diff",
    "digest",
    "evaluate_ate",
    "evaluate_rpe",
    "evaluate_rpe_all_pairs",
    "fetch",
    "open",
    "pixels_of",
    "plan_batch",
    "png_of",
    "read_batch_plan",
    "retry_batch",
    "run_batch",
    "select",
    "sum_batch_losses",
    "summarise",
    "synthesize",
    "validate",
    "write_batch_plan",
]
