# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Pictures show what they are given, for grey and colour images, horizontal and vertical stripes."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray
from support.exact_recording import exact_recording

import cv_active_handeye as cah
from cv_active_handeye.report import picture_motion, picture_points, picture_stripe, picture_tracks
from cv_active_handeye.report.cloud_picture import picture_cloud
from cv_active_handeye.report.pictures import GROUP_COLOURS, POINT_COLOUR, UNSURE_COLOUR


def share_of(path: Path, colour: str) -> float:
    """Share of pixels near a colour given as #rrggbb."""
    image = cv2.imread(str(path))
    assert image is not None
    wanted = [int(colour[i : i + 2], 16) for i in (5, 3, 1)]
    return float((np.abs(image.astype(int) - wanted).max(axis=2) < 30).mean())


def grey() -> NDArray[np.uint8]:
    return np.full((480, 640), 90, np.uint8)


def test_tracks_have_rays_of_one_colour_for_every_other_view(tmp_path: Path) -> None:
    picture_tracks(tmp_path / "tracks.png", grey(), exact_recording().imagePoints, 2, [0, 1, 2, 3, 4])
    for colour in GROUP_COLOURS[:4]:
        assert share_of(tmp_path / "tracks.png", colour) > 1e-3, colour
    assert share_of(tmp_path / "tracks.png", GROUP_COLOURS[4]) == 0


def test_tracks_of_a_view_that_sees_nothing_are_drawn_empty(tmp_path: Path) -> None:
    points = exact_recording().imagePoints.copy()
    points[2] = np.nan
    picture_tracks(tmp_path / "tracks.png", grey(), points, 2, [0, 1, 2])
    assert (tmp_path / "tracks.png").stat().st_size > 1000


@pytest.mark.parametrize("vertical", [False, True])
@pytest.mark.parametrize("colour", [False, True])
def test_stripe_shows_surfaces_in_their_colours(tmp_path: Path, vertical: bool, colour: bool) -> None:
    line = np.column_stack([np.arange(300.0), 200 + 0.05 * np.arange(300.0)])
    if vertical:
        line = line[:, ::-1]
    image = np.repeat(grey()[:, :, None], 3, axis=2) if colour else grey()
    picture_stripe(tmp_path / "stripe.png", image, [(line[:100], 0), (line[120:200], 1), (line[220:], -1)], 0)
    for shown in (*GROUP_COLOURS[:2], UNSURE_COLOUR):
        assert share_of(tmp_path / "stripe.png", shown) > 3e-4, shown


def test_motion_has_one_colour_for_every_orientation(tmp_path: Path) -> None:
    r = exact_recording()
    groups = cah.groupViews(r.R_gripper2base).reshape(-1)
    poses = (r.R_gripper2base, r.t_gripper2base, r.R_cam2gripper, r.t_cam2gripper)
    picture_motion(tmp_path / "motion.png", *poses, groups, (0.2, 0.2))
    for colour in GROUP_COLOURS[:4]:
        assert share_of(tmp_path / "motion.png", colour) > 3e-4, colour


@pytest.mark.parametrize("views", [1, 3])
def test_points_are_marked_in_the_image_of_their_view(tmp_path: Path, views: int) -> None:
    points = [{f"S{3 * view + i}": (100.0 * (i + 1), 60.0 + 120 * view) for i in range(3)} for view in range(views)]
    picture_points(tmp_path / "points.png", [(grey(), one) for one in points])
    marked = share_of(tmp_path / "points.png", POINT_COLOUR)
    picture_points(tmp_path / "bare.png", [(grey(), {}) for _ in points])
    assert marked > 3e-4
    assert share_of(tmp_path / "bare.png", POINT_COLOUR) == 0


@pytest.mark.parametrize("shape", ["tall", "wide", "one profile", "one point"])
def test_cloud_has_the_colours_of_height_and_sigma(tmp_path: Path, shape: str) -> None:
    size = {"tall": (0.1, 0.3), "wide": (0.4, 0.05), "one profile": (0.0, 0.2), "one point": (0.0, 0.0)}[shape]
    a, b = np.meshgrid(*(np.linspace(0, s, 60 if s else 1) for s in size))
    points = np.column_stack([a.ravel(), 0.02 * b.ravel(), b.ravel()])  # thinnest along y
    sigmas = np.linspace(1e-4, 3e-4, len(points))
    sigmas[-1] = np.inf
    picture_cloud(tmp_path / "cloud.png", points, sigmas)
    image = cv2.imread(str(tmp_path / "cloud.png"))
    assert image is not None
    assert 400 < image.shape[0] < 1500
    for colour in ("#440154", "#21918c", "#fde725", "#f0f921", "#cc4778", "#0d0887"):  # viridis and plasma
        assert share_of(tmp_path / "cloud.png", colour) > 2e-4, colour
