# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""On the published data: no false alarm, and the figures of the physical checks."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest

from tests.validate.faults import FAULTS, Fault
from tumtools.images import png
from tumtools.sources import open_source
from tumtools.validate.depth_scale import DepthScale, measure_depth_scale
from tumtools.validate.engine import validate
from tumtools.validate.finding import Severity
from tumtools.validate.gravity import XYZW, estimate_offset, fit_gravity, fit_readings

pytestmark = pytest.mark.real
RPY = "rgbd_dataset_freiburg1_rpy"


@pytest.fixture(scope="module")
def complete_rpy(real_data: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with the complete ground truth and accelerometer of fr1/rpy."""
    folder = tmp_path_factory.mktemp("rpy") / RPY
    folder.mkdir()
    shutil.copy(real_data / "groundtruth" / f"{RPY}-groundtruth.txt", folder / "groundtruth.txt")
    shutil.copy(real_data / "lists" / "fr1_rpy_accelerometer.txt", folder / "accelerometer.txt")
    return folder


def _worst(path: Path) -> Severity:
    return max((finding.severity for finding in validate(path).findings), default=Severity.INFO)


def test_no_published_ground_truth_and_no_estimate_gives_more_than_information(real_data: Path) -> None:
    files = [*(real_data / "groundtruth").iterdir(), *(real_data / "estimates").iterdir()]
    assert len(files) == 24
    assert {file.name: _worst(file) for file in files} == {file.name: Severity.INFO for file in files}


def test_the_published_images_give_no_more_than_information(real_sequence: Path, complete_rpy: Path) -> None:
    assert _worst(real_sequence) is Severity.INFO
    assert _worst(complete_rpy) is Severity.INFO


@pytest.mark.parametrize("folder", ["header_without_hash", "incomplete"])
def test_malformed_sequences_are_named_without_a_traceback(real_data: Path, folder: str) -> None:
    findings = validate(real_data / "malformed" / folder).findings
    codes = {finding.code for finding in findings}
    assert "TUM001" in codes
    if folder == "header_without_hash":
        assert {str(f.place) for f in findings if f.code == "TUM003"} == {
            "depth.txt:3",
            "groundtruth.txt:3",
            "rgb.txt:3",
        }
    else:
        assert {"TUM301", "TUM302"} <= codes


def _scale(images: list[np.ndarray[tuple[int, ...], np.dtype[np.generic]]]) -> DepthScale:
    scale = measure_depth_scale(
        np.unique(np.concatenate([np.unique(image) for image in images])).astype(np.uint16)
    )
    assert scale is not None
    assert scale.is_quantised
    return scale


def test_the_depth_factor_comes_out_as_specified(real_sequence: Path) -> None:
    files = sorted((real_sequence / "depth").iterdir())[:40]
    images = [png.decode(file.read_bytes()).astype(np.float64) for file in files]
    assert _scale(images[:1]).units_per_metre == pytest.approx(5085, rel=0.05)
    assert _scale(images).units_per_metre == pytest.approx(5060, rel=0.05)
    assert _scale([np.rint(image / 5) for image in images]).units_per_metre == pytest.approx(1009, rel=0.05)
    assert _scale([np.floor(image * 1.035) for image in images]).units_per_metre == pytest.approx(
        5217, rel=0.05
    )


def test_the_gravity_figures_come_out_as_specified(complete_rpy: Path) -> None:
    with open_source(complete_rpy) as sequence:
        poses, accelerations = sequence.groundtruth, sequence.accelerometer
    assert poses is not None
    assert accelerations is not None
    fits = fit_readings(poses, accelerations)
    assert fits[XYZW].rms_degrees == pytest.approx(3.0, rel=0.05)
    np.testing.assert_allclose(fits[XYZW].up, [0, -0.02, 1], atol=0.01)
    assert fits["w x y z"].rms_degrees == pytest.approx(15.0, rel=0.05)
    assert fits["inverse poses"].rms_degrees == pytest.approx(15.0, rel=0.05)
    for shift, expected in ((-0.1, 7.6), (0.02, 2.9), (0.1, 6.1)):
        fit = fit_gravity(poses, accelerations, shift_seconds=shift)
        assert fit is not None
        assert fit.rms_degrees == pytest.approx(expected, rel=0.05)
    offset = estimate_offset(poses, accelerations)
    assert offset is not None
    assert abs(offset[0]) < 0.05


def test_the_cut_that_hardly_rotates_decides_nothing(real_sequence: Path) -> None:
    with open_source(real_sequence) as sequence:
        assert sequence.groundtruth is not None
        assert sequence.accelerometer is not None
        fits = fit_readings(sequence.groundtruth, sequence.accelerometer)
    assert fits["w x y z"].rms_degrees < 1.5 * fits[XYZW].rms_degrees


GRAVITY_FAULTS = [fault for fault in FAULTS if fault.code in {"TUM403", "TUM407"}]


@pytest.mark.parametrize("fault", GRAVITY_FAULTS, ids=lambda fault: fault.name)
def test_gravity_finds_faults_in_the_complete_rows(fault: Fault, complete_rpy: Path, tmp_path: Path) -> None:
    folder = Path(shutil.copytree(complete_rpy, tmp_path / RPY))
    fault.inject(folder)
    findings = validate(folder).findings
    assert fault.code in {finding.code for finding in findings}
    assert {finding.code for finding in findings if finding.severity is Severity.ERROR} <= {fault.code}


# What needs two seconds, sixty images or much rotation is shown on the synthetic sequence.
NOT_IN_THE_CUT = {"TUM403", "TUM404", "TUM407"}
OF_IMAGES = ("TUM2", "TUM3")
FAULTS_IN_THE_CUT = [fault for fault in FAULTS if fault.code not in NOT_IN_THE_CUT]


@pytest.mark.slow
@pytest.mark.parametrize("fault", FAULTS_IN_THE_CUT, ids=lambda fault: fault.name)
def test_faults_in_the_real_sequence_are_found(fault: Fault, real_sequence: Path, tmp_path: Path) -> None:
    folder = Path(shutil.copytree(real_sequence, tmp_path / RPY))
    fault.inject(folder)
    # What is wrong with text or stamps is found without decoding 180 images.
    findings = validate(folder, full=fault.code.startswith(OF_IMAGES)).findings
    assert fault.code in {finding.code for finding in findings}
    errors = {finding.code for finding in findings if finding.severity is Severity.ERROR}
    assert errors <= {fault.code, *fault.errors}
