# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Measured points are where they are within their intervals, in one view and in several; wrong rows are named."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from support.exact_recording import exact_recording
from support.recordings import Notes
from support.stripe_recording import (
    Stop,
    calibration_of_truth,
    laser_dataset,
    record,
    stops_through,
    true_plane,
    true_points,
)

from cv_active_handeye.dataset import Dataset
from cv_active_handeye.files import FileFormatError
from cv_active_handeye.measured_points import PointRow
from cv_active_handeye.workflow.measure import MeasuredPoint, measure

Array = NDArray[np.float64]
VIEWS = (0, 6, 11)


def row(
    name: str,
    view: int,
    pixel: Sequence[float] | Array,
    beside: Sequence[float] = (0, 0),
    known: Array | None = None,
    sigma: float = 0.02,
) -> PointRow:
    """The row that names `pixel` + `beside` px, to `sigma` px along the stripe; `known`: reference, m."""
    u, v = np.add(pixel, beside).tolist()
    reference = None if known is None else (1000 * float(known[0]), 1000 * float(known[1]), 1000 * float(known[2]))
    return PointRow(f"points.csv, row {name} {view}", name, view, u, v, sigma, reference)


def scene_point() -> Array:
    """A point of surface 0 that all of VIEWS can see."""
    return np.asarray(true_points(0, exact_recording().stripePoints[0][20:21])[0], np.float64)


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Dataset:
    return laser_dataset(tmp_path_factory.mktemp("measure") / "set", (0, 1, None))


def test_point_of_an_exact_calibration_is_found_to_hundredths_of_a_millimetre(recording: Dataset) -> None:
    rows, truth = [], []
    for view, k in ((0, 5), (0, 30), (1, 20)):
        pixel = exact_recording().stripePoints[3 * view + view][k]
        truth.append(true_points(view, pixel[None])[0])
        rows.append(row(f"S{k}", view, pixel, (0, 4), truth[-1]))
    found = measure(recording, calibration_of_truth(covariance=np.zeros((20, 20))), rows)
    assert [point.name for point in found] == ["S5", "S30", "S20"]
    for point, true in zip(found, truth, strict=True):
        np.testing.assert_allclose(point.position, true, atol=5e-5)
        assert point.reference is not None
        assert point.difference is not None
        np.testing.assert_allclose(point.reference, true, atol=1e-15)
        np.testing.assert_array_equal(point.difference, point.position - point.reference)
        assert (point.half_widths < 3e-4).all()


@pytest.mark.parametrize("views", [(0,), VIEWS, (0, 0, 0)], ids=["one view", "three views", "the same three times"])
def test_intervals_hold_the_truth(tmp_path: Path, views: tuple[int, ...]) -> None:
    """Forty calibrations and robots. In three views of three orientations the calibration's error partly cancels, in
    three equal views it does not: the intervals must hold in both cases."""
    truth = scene_point()
    stops, pixels = stops_through(truth, true_plane(0), views)
    errors = []
    for seed in range(40):
        dataset = record(tmp_path / str(seed), stops, robot_seed=seed)
        rows = [row("S1", view, pixel) for view, pixel in enumerate(pixels)]
        [point] = measure(dataset, calibration_of_truth(1000 + seed), rows)
        assert point.views == tuple(range(len(views)))
        errors.append((point.position - truth) / point.half_widths)
    inside = np.mean(np.abs(errors) < 1)
    assert inside >= 0.9
    assert np.sqrt(np.mean(np.square(errors))) > 0.25  # not wider than need be


def test_three_views_are_better_than_one(tmp_path: Path) -> None:
    stops, pixels = stops_through(scene_point(), true_plane(0), VIEWS)
    dataset = record(tmp_path / "set", stops)
    rows = [row("S1", view, pixel) for view, pixel in enumerate(pixels)]
    alone = [measure(dataset, calibration_of_truth(), [one])[0] for one in rows]
    [together] = measure(dataset, calibration_of_truth(), rows)
    volumes = [np.linalg.det(point.covariance) for point in alone]
    assert np.linalg.det(together.covariance) < min(volumes)
    assert together.half_widths.max() < min(point.half_widths.max() for point in alone)


def test_error_of_the_calibration_does_not_average_out(tmp_path: Path) -> None:
    """The same view three times: what is shared stays, what is not is divided by three."""
    stops, pixels = stops_through(scene_point(), true_plane(0), (0, 0, 0))
    dataset = record(tmp_path / "set", stops)
    rows = [row("S1", view, pixel) for view, pixel in enumerate(pixels)]
    exact = calibration_of_truth(covariance=np.zeros((20, 20)))
    shared, noise = [
        [measure(dataset, calibration, chosen)[0].covariance for chosen in (rows[:1], rows)]
        for calibration in (calibration_of_truth(), exact)
    ]
    np.testing.assert_allclose(noise[1], noise[0] / 3, rtol=1e-6, atol=1e-14)
    np.testing.assert_allclose(shared[1], shared[0] - noise[0] + noise[0] / 3, rtol=1e-6, atol=1e-14)


def test_view_that_contradicts_the_others_is_told(tmp_path: Path) -> None:
    stops, pixels = stops_through(scene_point(), true_plane(0), VIEWS)
    rows = [row("S1", view, pixel, (30.0 * (view == 2), 0)) for view, pixel in enumerate(pixels)]
    reporter = Notes()
    measure(record(tmp_path / "set", stops), calibration_of_truth(), rows, reporter)
    assert any(note.startswith("point S1: view 2 contradicts the others by more than") for note in reporter.notes)
    reporter = Notes()
    picked = [one._replace(sigma=30) for one in rows]
    measure(record(tmp_path / "again", stops), calibration_of_truth(), picked, reporter)
    assert reporter.notes == []


def test_pixel_picked_by_hand_is_less_certain_along_the_stripe(recording: Dataset) -> None:
    pixel = exact_recording().stripePoints[0][20]
    rows = [row("sharp", 0, pixel, sigma=0.0), row("picked", 0, pixel, sigma=2.0)]
    sharp, picked = measure(recording, calibration_of_truth(covariance=np.zeros((20, 20))), rows)
    along = true_points(0, exact_recording().stripePoints[0][[19, 21]])
    direction = (along[1] - along[0]) / np.linalg.norm(along[1] - along[0])
    pixels = np.linalg.norm(exact_recording().stripePoints[0][21] - exact_recording().stripePoints[0][19])
    more = picked.covariance - sharp.covariance
    expected = 2.0 * np.linalg.norm(along[1] - along[0]) / pixels
    assert np.sqrt(direction @ more @ direction) == pytest.approx(expected, rel=0.02)
    assert np.linalg.matrix_rank(more, tol=1e-3 * np.trace(more)) == 1


def test_vertical_stripe_is_measured_at_the_row(tmp_path: Path) -> None:
    pixel = exact_recording().stripePoints[0][20]
    calibration = calibration_of_truth()
    assert calibration.light_plane is not None
    K, D, plane = calibration.camera_matrix, calibration.distortion_coefficients, calibration.light_plane
    mirror = np.eye(3)[[1, 0, 2]]
    changes = {
        "image_width": 480,
        "image_height": 640,
        "camera_matrix": mirror @ K @ mirror,
        "distortion_coefficients": D[[0, 1, 3, 2, 4]],
        "light_plane": np.append(mirror @ plane[:3], plane[3]),
        # a mirrored camera sees mirrored points, so both are compared in the camera frame
        "R_cam2gripper": np.eye(3),
        "t_cam2gripper": np.zeros(3),
    }
    dataset = laser_dataset(tmp_path / "a", (0,), turned=True)
    straight = laser_dataset(tmp_path / "b", (0,))
    exact = calibration.model_copy(update={"R_cam2gripper": np.eye(3), "t_cam2gripper": np.zeros(3)})
    [mirrored] = measure(dataset, calibration.model_copy(update=changes), [row("S1", 0, pixel[::-1], (3, 0))])
    [expected] = measure(straight, exact, [row("S1", 0, pixel, (0, 3))])
    R, t = exact_recording().R_gripper2base[0], exact_recording().t_gripper2base[0]
    np.testing.assert_allclose((mirrored.position - t) @ R @ mirror, (expected.position - t) @ R, atol=1e-12)


@pytest.mark.parametrize(
    ("view", "pixel", "message"),
    [
        (3, (320, 240), r"points.csv, row S 3: needs a view of the data set \(0 to 2\), given 3"),
        (2, (320, 240), r"within 10 px of \(320, 240\) in view 2; the view shows no stripe"),
        (0, (320, 20), r"within 10 px of \(320, 20\) in view 0; the nearest point of the stripe is \("),
        (0, (5, 240), r"within 10 px of \(5, 240\) in view 0; the nearest point of the stripe is \(\d+\.\d, \d+\.\d\)"),
    ],
)
def test_row_without_a_stripe_is_named(recording: Dataset, view: int, pixel: tuple[float, float], message: str) -> None:
    with pytest.raises(FileFormatError, match=message):
        measure(recording, calibration_of_truth(), [row("S", view, pixel)])


def test_view_without_laser_image_is_named(tmp_path: Path) -> None:
    dataset = laser_dataset(tmp_path / "set", (0,))
    dataset.add_view(np.eye(3), np.zeros(3))
    with pytest.raises(FileFormatError, match="row S 1: needs a view with a laser image, view 1 has none"):
        measure(dataset, calibration_of_truth(), [row("S", 1, (320, 240))])


def test_calibration_without_light_plane_is_refused(recording: Dataset) -> None:
    with pytest.raises(FileFormatError, match="needs a light plane, has none"):
        measure(recording, calibration_of_truth(light_plane=None), [row("S", 0, (320, 240))])


def test_parameter_that_was_not_observed_leaves_the_interval_open(recording: Dataset) -> None:
    covariance = calibration_of_truth().covariance.copy()
    covariance[13, 13] = np.inf
    pixel = exact_recording().stripePoints[0][20]
    [point] = measure(recording, calibration_of_truth(covariance=covariance), [row("S", 0, pixel)])
    assert np.isinf(point.half_widths).any()
    assert np.isfinite(point.position).all()


def test_pixel_beside_no_straight_piece_is_named(tmp_path: Path) -> None:
    """A stripe that waves by two pixels every fifty columns has no straight piece of twenty."""
    columns = np.arange(100.0, 500.0)
    waves = np.column_stack([columns, 240 + 8 * np.sin(columns / 8)])
    truth = exact_recording()
    dataset = record(tmp_path / "set", [Stop(truth.R_gripper2base[0], truth.t_gripper2base[0], waves)])
    with pytest.raises(FileFormatError, match=r"in view 0; the stripe is not straight around \(\d+\.\d, \d+\.\d\)"):
        measure(dataset, calibration_of_truth(), [row("S", 0, (300.0, 240.0))])


def test_interval_is_1_96_standard_deviations() -> None:
    point = MeasuredPoint("S", (0,), np.zeros(3), np.diag([1e-8, 4e-8, 9e-8]))
    np.testing.assert_allclose(point.half_widths, [1.959964e-4, 3.919928e-4, 5.879892e-4], rtol=1e-6)
    assert point.difference is None
