# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Sequences are found by every name that people use for them."""

from __future__ import annotations

import subprocess
import sys

import pytest

from tumtools.catalogue import UnknownNameError, packaged_catalogue

CATALOGUE = packaged_catalogue()


@pytest.mark.parametrize(
    "name",
    [
        "fr1/desk",
        "fr1_desk",
        "fr1 desk",
        "FR1/Desk",
        "freiburg1_desk",
        "freiburg1/desk",
        "rgbd_dataset_freiburg1_desk",
        "rgbd_dataset_freiburg1_desk/",
        "rgbd_dataset_freiburg1_desk.tgz",
        "rgbd_dataset_freiburg1_desk.bag",
        "rgbd_dataset_freiburg1_desk-2hz-with-pointclouds.bag",
    ],
)
def test_all_spellings_of_a_name_find_the_sequence(name: str) -> None:
    assert CATALOGUE.get(name).name == "rgbd_dataset_freiburg1_desk"


@pytest.mark.parametrize(
    ("name", "short"),
    [
        ("fr2/360 hemisphere", "fr2/360_hemisphere"),  # the paper's Table I
        ("fr3/office", "fr3/long_office_household"),
        ("fr3_nstr_tex_near", "fr3/nostructure_texture_near_withloop"),
        ("fr3/w_xyz", "fr3/walking_xyz"),
        ("fr3_sitting_halfsphere", "fr3/sitting_halfsphere"),
        ("fr3/rgb_calibration", "fr3/calibration_rgb_depth"),
    ],
)
def test_names_of_papers_are_known(name: str, short: str) -> None:
    assert CATALOGUE.get(name).short == short


def test_each_name_of_each_sequence_finds_it_and_no_other() -> None:
    for entry in CATALOGUE:
        for name in (entry.name, entry.short or "", entry.name.removeprefix("rgbd_dataset_"), *entry.aliases):
            assert CATALOGUE.get(name) is entry


@pytest.mark.parametrize(
    ("name", "suggestion"),
    [
        ("fr1/dsk", "fr1/desk"),
        ("desk", "fr1/desk"),
        ("fr3/walkingxyz", "fr3/walking_xyz"),
        ("freiburg2_pioneer", "fr2/pioneer_slam"),
    ],
)
def test_a_misspelt_name_gets_a_suggestion(name: str, suggestion: str) -> None:
    with pytest.raises(UnknownNameError, match=f"'{name}'") as caught:
        CATALOGUE.get(name)
    assert caught.value.hint is not None
    assert suggestion in caught.value.hint
    assert caught.value.exit_code == 2


def test_a_name_that_is_like_nothing_points_to_the_list() -> None:
    with pytest.raises(UnknownNameError) as caught:
        CATALOGUE.get("kitti/00")
    assert caught.value.hint is not None
    assert "tumtools list" in caught.value.hint


def test_the_list_can_be_filtered() -> None:
    assert len(CATALOGUE.filter(kind="sequence")) == 47
    assert len(CATALOGUE.filter(kind="validation")) == 33
    assert len(CATALOGUE.filter(kind="calibration")) == 9
    assert [entry.short for entry in CATALOGUE.filter(camera="fr2", category="testing")] == [
        "fr2/xyz",
        "fr2/rpy",
    ]


def test_the_catalogue_loads_neither_requests_nor_numpy() -> None:
    code = (
        "import sys; from tumtools.catalogue import load_catalogue; load_catalogue().get('fr1/xyz');"
        "print(sorted({'requests', 'numpy', 'click'} & set(sys.modules)))"
    )
    assert (
        subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
        == "[]\n"
    )
