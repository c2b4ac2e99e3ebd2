# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Pictures are drawn from every result, the same bytes each time, and whatever the user's own settings."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest

pytest.importorskip("matplotlib")

from PIL import Image

from tests.evaluate.conftest import drifted, walk
from tumtools.cli.main import run
from tumtools.errors import InputError, UsageError
from tumtools.evaluate.allpairs import evaluate_rpe_all_pairs
from tumtools.evaluate.ate import evaluate_ate
from tumtools.evaluate.rpe import Sampling, evaluate_rpe
from tumtools.evaluate.tables import aligned_trajectory
from tumtools.plot.ate import plot_ate
from tumtools.plot.rpe import plot_distances, plot_rpe
from tumtools.plot.style import broken_at_gaps, gaps, save
from tumtools.plot.timeline import spans
from tumtools.plot.trajectory import plot_trajectories

if TYPE_CHECKING:
    from collections.abc import Callable

    from matplotlib.figure import Figure


TRUE, ESTIMATE = walk(200), drifted(walk(200))
PICTURES: dict[str, Callable[[], Figure]] = {
    "trajectory": lambda: plot_trajectories({"true": TRUE, "estimate": ESTIMATE}, "xz", "A title"),
    "ate": lambda: plot_ate(evaluate_ate(TRUE, ESTIMATE)),
    "rpe": lambda: plot_rpe(evaluate_rpe(TRUE, ESTIMATE, delta=20, unit="f")),
    "random": lambda: plot_rpe(evaluate_rpe(TRUE, ESTIMATE, sampling=Sampling(500, random=True))),
    "distances": lambda: plot_distances(evaluate_rpe_all_pairs(TRUE, ESTIMATE)),
    "translation only": lambda: plot_distances(evaluate_rpe_all_pairs(TRUE, ESTIMATE, rotation=False)),
}


@pytest.mark.parametrize(
    ("name", "suffix"), [*((name, ".svg") for name in PICTURES), ("ate", ".png"), ("trajectory", ".pdf")]
)
def test_the_same_input_gives_the_same_bytes(name: str, suffix: str, tmp_path: Path) -> None:
    one, two = tmp_path / f"one{suffix}", tmp_path / f"two{suffix}"
    for target in (one, two):
        save(PICTURES[name](), target)
    assert len(one.read_bytes()) > 5000
    assert one.read_bytes() == two.read_bytes()


def test_bytes_do_not_depend_on_the_process_or_the_users_settings(tmp_path: Path) -> None:
    (tmp_path / "true.txt").write_text(aligned_trajectory(walk(200)))
    (tmp_path / "matplotlibrc").write_text("lines.linewidth: 9\nfont.size: 30\nsvg.hashsalt: other\n")
    for seed, name in (("1", "a.svg"), ("2", "b.svg")):
        subprocess.run(
            [
                sys.executable,
                "-m",
                "tumtools",
                "plot",
                "trajectory",
                tmp_path / "true.txt",
                "-o",
                tmp_path / name,
            ],
            check=True,
            env={
                "PYTHONHASHSEED": seed,
                "PYTHONPATH": ".",
                "MATPLOTLIBRC": str(tmp_path / "matplotlibrc") * (seed == "2"),
            },
        )
    assert (tmp_path / "a.svg").read_bytes() == (tmp_path / "b.svg").read_bytes()


def test_panels_of_a_timeline_are_named_as_the_sources(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    text = "# ground truth trajectory\n# file: 'rgbd_dataset_freiburg1_xyz.bag'\n"
    files = [str(tmp_path / name) for name in ("true.txt", "estimate.txt")]
    for file in files:
        Path(file).write_text(text + aligned_trajectory(walk(50)))
    drawn: list[Figure] = []
    monkeypatch.setattr("tumtools.plot.style.save", lambda figure, *_, **__: drawn.append(figure))
    assert run(["plot", "timeline", *files, "-o", str(tmp_path / "x.svg")]) == 0
    assert [axes.get_title("left") for axes in drawn[0].axes] == ["true", "estimate"]
    assert run(["plot", "timeline", files[0], files[0], "-o", str(tmp_path / "x.svg")]) == 2


def test_a_picture_is_not_empty_and_readable_in_grey(tmp_path: Path) -> None:
    save(PICTURES["ate"](), tmp_path / "ate.png")
    with Image.open(tmp_path / "ate.png") as image:
        grey = np.asarray(image.convert("L"))
    assert grey.shape[0] > 500
    assert np.ptp(grey) == 255
    assert 0.01 < np.mean(grey < 200) < 0.5


def test_existing_pictures_are_not_replaced_unless_asked(tmp_path: Path) -> None:
    target = tmp_path / "x.svg"
    figure = PICTURES["rpe"]()
    save(figure, target)
    with pytest.raises(UsageError, match="exists"):
        save(figure, target)
    save(figure, target, force=True)
    assert [path.name for path in tmp_path.iterdir()] == ["x.svg"]


def test_a_folder_is_not_replaced_by_a_picture(tmp_path: Path) -> None:
    (tmp_path / "x.svg" / "data").mkdir(parents=True)
    with pytest.raises(UsageError, match="this is a folder"):
        save(PICTURES["rpe"](), tmp_path / "x.svg", force=True)
    assert (tmp_path / "x.svg" / "data").is_dir()


def test_a_picture_of_the_relative_error_says_which_pairs() -> None:
    assert PICTURES["rpe"]().axes[0].get_title("left") == "Relative pose error, 179 pairs 20 frames apart"
    assert PICTURES["random"]().axes[0].get_title("left") == "Relative pose error, 500 random pairs"


def test_lines_are_broken_at_gaps() -> None:
    stamps = np.array([0, 10, 20, 30, 140, 150, 160, 300]) * 10_000_000
    assert gaps(stamps).tolist() == [3, 6]
    drawn = broken_at_gaps(stamps, np.arange(8.0)[:, None])[:, 0]
    assert np.flatnonzero(np.isnan(drawn)).tolist() == [4, 8]
    assert gaps(np.array([], np.int64)).tolist() == []


def test_spans_of_a_stream() -> None:
    found = spans(np.array([0, 10, 20, 120, 130]) * 10**8, 0, 200 * 10**8)
    assert found.stretches.tolist() == [[0.0, 2.0], [12.0, 13.0]]
    assert found.gaps.tolist() == [[2.0, 12.0]]
    assert found.covered == pytest.approx(0.15)


def test_nothing_to_draw_is_refused() -> None:
    with pytest.raises(InputError):
        plot_trajectories({})
    with pytest.raises(UsageError, match="unknown plane"):
        plot_trajectories({"a": walk(5)}, "ab")


def test_trajectories_can_be_aligned_to_the_first(tmp_path: Path) -> None:
    for name, trajectory in (("true.txt", walk(200)), ("estimate.txt", drifted(walk(200)))):
        (tmp_path / name).write_text(aligned_trajectory(trajectory))
    files = [str(tmp_path / "true.txt"), str(tmp_path / "estimate.txt")]
    for mode in ("none", "se3", "sim3"):
        assert run(["plot", "trajectory", *files, "-o", str(tmp_path / f"{mode}.svg"), "--align", mode]) == 0
    assert (tmp_path / "none.svg").read_bytes() != (tmp_path / "se3.svg").read_bytes()
    assert run(["plot", "trajectory", files[0], files[0], "-o", str(tmp_path / "twice.svg")]) == 2


@pytest.mark.real
def test_timeline_of_real_sequences(real_data: Path, tmp_path: Path) -> None:
    sources = [
        str(real_data / "rgbd_dataset_freiburg1_rpy"),
        str(real_data / "groundtruth/rgbd_dataset_freiburg2_desk-groundtruth.txt"),
    ]
    for name in ("a.svg", "b.svg"):
        assert run(["plot", "timeline", *sources, "-o", str(tmp_path / name)]) == 0
    assert (tmp_path / "a.svg").read_bytes() == (tmp_path / "b.svg").read_bytes()


def test_without_matplotlib_it_says_what_to_install(tmp_path: Path) -> None:
    (tmp_path / "true.txt").write_text(aligned_trajectory(walk(20)))
    program = (
        "import sys; sys.modules['matplotlib'] = None\n"
        "from tumtools.cli.main import run\n"
        f"sys.exit(run(['plot', 'trajectory', {str(tmp_path / 'true.txt')!r}, '-o', 'x.svg']))"
    )
    result = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=False)
    assert result.returncode == 2
    assert "pip install 'tumtools[plot]'" in result.stderr
    assert "Traceback" not in result.stderr
