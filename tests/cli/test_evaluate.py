# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""The commands that measure, as a user runs them."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

import numpy as np
import pytest

from tests.evaluate.conftest import drifted, walk
from tumtools.cli.main import run
from tumtools.evaluate.tables import aligned_trajectory
from tumtools.model.signals import Trajectory

if TYPE_CHECKING:
    from pathlib import Path


@pytest.fixture
def pair(tmp_path: Path) -> list[str]:
    """A ground truth and an estimate of 300 poses, as files."""
    for name, trajectory in (("true.txt", walk(300)), ("estimate.txt", drifted(walk(300)))):
        (tmp_path / name).write_text(aligned_trajectory(trajectory))
    return [str(tmp_path / "true.txt"), str(tmp_path / "estimate.txt")]


def table(text: str) -> dict[str, list[str]]:
    return {line.split()[0]: line.split()[1:] for line in text.splitlines() if line}


def test_absolute_error(pair: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["evaluate", "ate", *pair]) == 0
    printed = capsys.readouterr()
    assert printed.out.startswith("300 pairs of 300 estimated, 300 true poses")
    assert table(printed.out)["rmse"][1] == "m"
    assert printed.err == ""
    assert run(["evaluate", "ate", *pair, "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["pairs"] == 300
    assert f"{document['translation_m']['rmse']:.6f}" == table(printed.out)["rmse"][0]


def test_relative_error(pair: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["evaluate", "rpe", *pair, "--delta", "0.5"]) == 0
    printed = capsys.readouterr().out
    assert printed.startswith("249 pairs 0.5 s apart of 300 estimated, 300 true poses")
    rows = table(printed)
    assert [rows["rmse"][1], rows["rmse"][3]] == ["m", "deg"]
    assert run(["evaluate", "rpe", *pair, "--delta", "50", "--unit", "f", "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert (document["pairs"], document["delta"], document["unit"]) == (249, 50.0, "f")
    assert f"{document['rotation_deg']['median']:.6f}" == rows["median"][2]


def test_all_pairs(pair: list[str], capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    saved = tmp_path / "distances.txt"
    assert run(["evaluate", "rpe", *pair, "--all-pairs", "--save", str(saved), "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["pairs"] == 300 * 299 // 2
    assert document["translation_m"] == pytest.approx(np.mean(document["translational_rmse_m"]))
    assert np.loadtxt(saved).shape == (299, 3)


def test_random_pairs_are_the_same_again(pair: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    printed = []
    for seed in ("1", "1", "2"):
        assert run(["evaluate", "rpe", *pair, "--random", "--max-pairs", "500", "--seed", seed]) == 0
        printed.append(capsys.readouterr().out)
    assert printed[0] == printed[1] != printed[2]


def test_saved_files(pair: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    names = {"--save": 4, "--save-trajectory": 8, "--save-associations": 8}
    arguments = [part for name in names for part in (name, str(tmp_path / name))]
    assert run(["evaluate", "ate", *pair, *arguments]) == 0
    for name, columns in names.items():
        assert np.loadtxt(tmp_path / name).shape == (300, columns)
    assert run(["evaluate", "ate", *pair, "--save", str(tmp_path / "--save")]) == 2
    assert "the target exists" in capsys.readouterr().err
    assert run(["evaluate", "ate", *pair, "--save", str(tmp_path / "--save"), "--force"]) == 0
    (tmp_path / "folder" / "data").mkdir(parents=True)
    assert run(["evaluate", "ate", *pair, "--save", str(tmp_path / "folder"), "--force"]) == 2
    assert (tmp_path / "folder" / "data").is_dir()


def test_positions_without_rotations_do_for_the_absolute_error(
    pair: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    saved = str(tmp_path / "saved.txt")
    assert run(["evaluate", "ate", *pair, "--save", saved, "--json"]) == 0
    rmse = json.loads(capsys.readouterr().out)["translation_m"]["rmse"]
    assert run(["evaluate", "ate", pair[0], saved, "--align", "none", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["translation_m"]["rmse"] == pytest.approx(rmse, abs=1e-6)
    assert run(["evaluate", "rpe", pair[0], saved]) == 4
    assert "4 columns instead of 8" in capsys.readouterr().err
    (tmp_path / "saved.txt").write_text("1305031102.0 1 2 3\n1305031102.1 1 x 3\n")
    assert run(["evaluate", "ate", pair[0], saved]) == 4
    assert "the row of 1305031102.100000000 is no position: '1 x 3'" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["ate", "--max-hole", "1"], "--max-hole is for --interpolate"),
        (["ate", "--json", "--tum-output"], "cannot be had together"),
        (["rpe", "--all-pairs", "--delta", "2"], "--delta has no effect with --all-pairs"),
        (["rpe", "--method", "nearest"], "--method has no effect without --all-pairs"),
        (["rpe", "--random", "--unit", "m"], "--unit has no effect with --random"),
        (["rpe", "--seed", "3"], "--seed has no effect without --random or --max-pairs"),
        (["ate", "--interpolate", "--method", "nearest"], "--method has no effect with --interpolate"),
        (["rpe", "--all-pairs", "--interpolate", "--max-difference", "1"], "no effect with --interpolate"),
        (["ate", "--save", "a", "--save-associations", "a"], "a: two results cannot be written to the same"),
        (["rpe", "--delta", "0"], "must be finite and more than 0"),
        (["ate", "--offset", "a day"], "not a number of seconds"),
        (["ate", "--max-difference", "0"], "must be positive"),
        (["ate", "--scale", "-1"], "must be positive"),
        (["rpe", "--delta", "nan"], "must be finite"),
        (["ate", "--plot", "picture.bmp"], "a picture ends with"),
    ],
)
def test_wrong_usage(
    arguments: list[str], message: str, pair: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["evaluate", arguments[0], *pair, *arguments[1:]]) == 2
    printed = capsys.readouterr()
    assert message in printed.err
    assert printed.out == ""


def test_what_cannot_be_measured_ends_with_4(pair: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["evaluate", "ate", *pair, "--offset", "100"]) == 4
    assert "set the time offset" in capsys.readouterr().err
    assert run(["evaluate", "ate", pair[0], "nowhere.txt"]) == 4


def test_the_wrong_order_is_warned_of(
    pair: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    slow = tmp_path / "slow.txt"
    slow.write_text(aligned_trajectory(drifted(walk(300)).take(slice(0, None, 3))))
    for measure in ("ate", "rpe"):
        assert run(["evaluate", measure, pair[0], str(slow)]) == 0
        assert capsys.readouterr().err == ""
        assert run(["evaluate", measure, str(slow), pair[0]]) == 0
        assert "100.0 poses a second, the ground truth 33.3: if they are the other way round, name the" in (
            capsys.readouterr().err
        )


def test_interpolation(pair: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    sparse = walk(300).take(slice(None, None, 3))
    with open(pair[0], "w") as file:  # noqa: PTH123 - it is a string here
        file.write(aligned_trajectory(sparse))
    assert run(["evaluate", "ate", *pair, "--interpolate", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["pairs"] == 298
    assert run(["evaluate", "ate", *pair, "--interpolate", "--max-hole", "0.02", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["pairs"] == 100


@pytest.mark.real
def test_output_of_the_scripts_line_by_line(real_data: Path, capsys: pytest.CaptureFixture[str]) -> None:
    numbers = json.loads((real_data / "reference/evaluation_detail.json").read_text())["freiburg1_xyz"]
    pair = [
        str(real_data / "groundtruth/rgbd_dataset_freiburg1_xyz-groundtruth.txt"),
        str(real_data / "estimates/freiburg1_xyz-rgbdslam.txt"),
    ]

    def expected(case: str, units: dict[str, str]) -> list[str]:
        return [
            f"{key} {int(value)} pairs"
            if key == "compared_pose_pairs"
            else f"{key} {value:f} {units[key.split('.')[0]]}"
            for key, value in numbers[case].items()
        ]

    assert run(["evaluate", "ate", *pair, "--tum-output"]) == 0
    assert capsys.readouterr().out.splitlines() == expected("ate", {"absolute_translational_error": "m"})
    units = {"translational_error": "m", "rotational_error": "deg"}
    for case, arguments in (("rpe_1s", []), ("rpe_1f", ["--unit", "f"]), ("rpe_1m", ["--unit", "m"])):
        assert run(["evaluate", "rpe", *pair, "--tum-output", *arguments]) == 0
        assert capsys.readouterr().out.splitlines() == expected(case, units)


@pytest.mark.real
def test_associate_prints_the_scripts_lines(real_data: Path, capsys: pytest.CaptureFixture[str]) -> None:
    lists = [str(real_data / f"lists/fr1_rpy_{name}.txt") for name in ("rgb", "depth")]
    expected = (real_data / "lists/fr1_rpy_associate_output.txt").read_text()
    assert run(["associate", *lists]) == 0
    printed = capsys.readouterr()
    assert printed.out == expected
    assert printed.err == (
        "694 pairs; 29 of 723 and 28 of 722 rows have no partner; largest difference 19.930 ms\n"
    )
    assert run(["associate", *lists, "--first-only"]) == 0
    assert capsys.readouterr().out.splitlines() == [
        " ".join(line.split()[:2]) for line in expected.splitlines()
    ]


def test_associate_any_text(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "a").write_text("# a comment\ntime,what\n1.5,one,two\n2.5\tthree\n3.5\n")
    (tmp_path / "b").write_text("2.51 four\n\n1.49 five\n")
    assert run(["associate", str(tmp_path / "a"), str(tmp_path / "b")]) == 0
    printed = capsys.readouterr()
    assert printed.out == "1.500000 one two 1.490000 five\n2.500000 three 2.510000 four\n"
    assert "line 2: taken for a header line without '#'" in printed.err
    (tmp_path / "b").write_text("2.51 four\nfive six\n")
    assert run(["associate", str(tmp_path / "a"), str(tmp_path / "b")]) == 4
    assert "b, line 2: not a number of seconds: 'five'" in capsys.readouterr().err


def test_associate_without_pairs(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "a").write_text("1.0 x\n")
    (tmp_path / "b").write_text("5.0 y\n")
    assert run(["associate", str(tmp_path / "a"), str(tmp_path / "b")]) == 4
    assert "no rows match within 0.02 s (1 and 1 rows)" in capsys.readouterr().err


@pytest.mark.real
def test_associate_two_streams_of_a_sequence(real_data: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = real_data / "rgbd_dataset_freiburg1_rpy"
    assert run(["associate", str(folder)]) == 0
    of_sequence = capsys.readouterr().out
    assert run(["associate", str(folder / "rgb.txt"), str(folder / "depth.txt")]) == 0
    assert of_sequence == capsys.readouterr().out
    assert run(["associate", str(folder), "--second-stream", "groundtruth", "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert (len(document["pairs"]), document["second_rows"]) == (90, 401)
    assert document["pairs"][0]["first"]["stamp"] == "1305031229528748000"
    assert run(["associate", str(folder), "--second-stream", "ir"]) == 4


@pytest.mark.real
def test_stats_of_one_and_of_several(real_data: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = str(real_data / "rgbd_dataset_freiburg1_rpy")
    truth = str(real_data / "groundtruth/rgbd_dataset_freiburg1_xyz-groundtruth.txt")
    assert run(["stats", folder]) == 0
    assert "page's length (m)       0.205" in capsys.readouterr().out
    assert run(["stats", folder, truth, "--json"]) == 0
    one, two = json.loads(capsys.readouterr().out)["sequences"]
    assert (one["pairs"], one["streams"]["rgb"]["with_groundtruth"]) == (90, 90)
    assert two["motion"]["first"] == "1305031098665900000"
    for layout, expected in (
        ("text", "7.112"),
        ("markdown", "| rgbd_dataset_freiburg1_xyz | 30.09 | 30.00 | 0.244 | 8.920 |"),
        ("latex", r"rgbd\_dataset\_freiburg1\_xyz & 30.09 & 30.00"),
        (
            "csv",
            "rgbd_dataset_freiburg1_xyz,30.09,30.00,0.244,8.920,0.46 x 0.70 x 0.44,7.112,9.159,,",
        ),
    ):
        assert run(["stats", folder, truth, "--format", layout]) == 0
        assert expected in capsys.readouterr().out
    own = str(real_data / "rgbd_dataset_freiburg1_rpy/groundtruth.txt")
    assert run(["stats", folder, own, "--format", "csv"]) == 0
    assert [line.split(",")[0] for line in capsys.readouterr().out.splitlines()[1:]] == [folder, own]


def test_a_sequence_without_trajectory_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "rgb.txt").write_text("1.0 rgb/1.png\n")
    assert run(["evaluate", "ate", str(tmp_path), str(tmp_path)]) == 4
    assert "there is no trajectory in it" in capsys.readouterr().err


def test_nan_rows_are_warned_of(pair: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    estimate = drifted(walk(300))
    positions = estimate.positions.copy()
    positions[5, 0] = np.nan
    with open(pair[1], "w") as file:  # noqa: PTH123 - it is a string here
        file.write(aligned_trajectory(Trajectory(estimate.stamps, positions, estimate.quaternions)))
    assert run(["evaluate", "ate", *pair]) == 0
    assert "warning: estimate: 1 of 300 rows with NaN or infinity left out" in capsys.readouterr().err


@pytest.mark.real
def test_topics_of_recordings(real_data: Path, capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    recording = str(real_data / "bags/evo/nav2_turtlebot.mcap")
    assert run(["evaluate", "ate", recording, recording]) == 2
    assert "choose one, as with --groundtruth-topic /" in capsys.readouterr().err
    assert run(["evaluate", "ate", recording, recording, "--groundtruth-topic", "/no"]) == 2
    assert "--groundtruth-topic /no: no such topic" in capsys.readouterr().err
    assert run(["plot", "trajectory", recording, "-o", str(tmp_path / "x.svg")]) == 2
    assert "choose one, as with --topic /" in capsys.readouterr().err
    topics = ["--groundtruth-topic", "/odom", "--estimate-topic", "/amcl_pose"]
    assert run(["evaluate", "ate", recording, recording, *topics]) == 0
    assert "pairs of" in capsys.readouterr().out
    picture = tmp_path / "odom.svg"
    assert run(["plot", "trajectory", recording, "--topic", "/odom", "-o", str(picture)]) == 0
    assert run(["stats", recording, "--topic", "groundtruth=/odom"]) == 0
    assert "path length (m)" in capsys.readouterr().out


@pytest.mark.real
@pytest.mark.parametrize("kind", ["rosbag1", "mcap"])
def test_ground_truth_from_a_recording_gives_the_numbers_of_the_folder(
    kind: str, real_data: Path, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    folder = str(real_data / "rgbd_dataset_freiburg1_rpy")
    recording = str(tmp_path / f"rpy.{kind.removesuffix('1').removeprefix('ros')}")
    assert run(["convert", folder, recording, "--to", kind, "--streams", "groundtruth"]) == 0
    printed = []
    for source in (folder, recording):
        capsys.readouterr()
        assert run(["evaluate", "rpe", source, str(real_data / "estimates/freiburg1_rpy-rgbdslam.txt")]) == 0
        printed.append(capsys.readouterr().out)
    assert printed[0] == printed[1]
