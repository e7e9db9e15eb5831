# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""reprojectStripe from Python: truth of an exact recording, covariances against derivatives taken with numpy."""

from __future__ import annotations

import re
from typing import Any, TypedDict

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation
from support.exact_recording import Recording, exact_recording

import cv_active_handeye as cah

Array = NDArray[np.float64]
SEGMENT = 4


def calibration(r: Recording) -> tuple[Array, Array, Array, Array]:
    """Positional arguments of reprojectStripe."""
    return r.stripePoints[SEGMENT], r.cameraMatrix, r.distCoeffs, r.lightPlane


class Hand(TypedDict):
    """Keywords that carry points into the gripper frame."""

    R_cam2gripper: Array
    t_cam2gripper: Array


class Transforms(Hand):
    """Keywords that carry points into the base frame."""

    R_gripper2base: Array
    t_gripper2base: Array


def transforms(r: Recording) -> Transforms:
    """Of the view of the segment."""
    view = r.stripeViews[SEGMENT]
    return {
        "R_cam2gripper": r.R_cam2gripper,
        "t_cam2gripper": r.t_cam2gripper,
        "R_gripper2base": r.R_gripper2base[view],
        "t_gripper2base": r.t_gripper2base[view],
    }


def expected_points(r: Recording, error: Array) -> Array:
    """Points in the base frame by OpenCV's own undistortion, for errors in the order of RefineSummary.covariance."""
    K = r.cameraMatrix + np.array([[error[0], error[4], error[2]], [0, error[1], error[3]], [0, 0, 0]])
    pixels = r.stripePoints[SEGMENT].copy()
    y = (pixels[:, 1] - K[1, 2]) / K[1, 1]
    x = (pixels[:, 0] - K[0, 2] - K[0, 1] * y) / K[0, 0]
    criteria = (cv2.TERM_CRITERIA_COUNT + cv2.TERM_CRITERIA_EPS, 100, 1e-15)
    normalised = np.column_stack([x, y])[:, None]
    ideal = cv2.undistortPointsIter(normalised, np.eye(3), r.distCoeffs + error[5:10], np.eye(3), np.eye(3), criteria)
    rays = np.insert(ideal[:, 0], 2, 1.0, axis=1)
    plane = r.lightPlane + error[16:]
    in_camera = rays * (plane[3] / (rays @ plane[:3]))[:, None]
    in_gripper = in_camera @ (Rotation.from_rotvec(error[10:13]).as_matrix() @ r.R_cam2gripper).T
    motion = transforms(r)
    result: Array = (in_gripper + r.t_cam2gripper + error[13:16]) @ motion["R_gripper2base"].T
    return result + motion["t_gripper2base"]


def test_points_are_those_of_opencv_in_every_frame() -> None:
    r = exact_recording()
    motion = transforms(r)
    in_base, nothing = cah.reprojectStripe(*calibration(r), **motion)
    hand = Hand(R_cam2gripper=r.R_cam2gripper, t_cam2gripper=r.t_cam2gripper)
    in_gripper, _ = cah.reprojectStripe(*calibration(r), **hand)
    in_camera, _ = cah.reprojectStripe(*calibration(r))
    assert nothing is None
    assert in_base.shape == (40, 3)
    np.testing.assert_allclose(in_base, expected_points(r, np.zeros(20)), rtol=0, atol=1e-9)
    np.testing.assert_allclose(in_camera @ r.R_cam2gripper.T + r.t_cam2gripper, in_gripper, rtol=0, atol=1e-14)
    moved = in_gripper @ motion["R_gripper2base"].T + motion["t_gripper2base"]
    np.testing.assert_allclose(moved, in_base, rtol=0, atol=1e-14)


def test_covariance_follows_from_numerical_derivatives() -> None:
    r = exact_recording()
    rng = np.random.default_rng(4)
    steps = np.array([1e-2] * 5 + [1e-4] * 5 + [1e-5] * 10)
    factor = 10 * steps[:, None] * rng.normal(size=(20, 20))
    C = factor @ factor.T
    _, covariances = cah.reprojectStripe(*calibration(r), **transforms(r), calibrationCovariance=C)
    assert covariances is not None
    errors = np.diag(steps)
    J = np.stack([(expected_points(r, e) - expected_points(r, -e)) / (2 * e.sum()) for e in errors], axis=-1)
    expected = J @ C @ J.transpose(0, 2, 1)
    np.testing.assert_allclose(covariances, expected, rtol=0, atol=1e-4 * np.abs(expected).max())
    np.testing.assert_array_equal(covariances, covariances.transpose(0, 2, 1))


@pytest.mark.parametrize(
    "one", [0.1, np.float32(0.1), np.array([0.1]), [0.1]], ids=["float", "float32", "array", "list"]
)
def test_pixel_sigmas_are_one_number_or_one_for_each_point(one: Any) -> None:
    r = exact_recording()
    _, covariances = cah.reprojectStripe(*calibration(r), pixelSigmas=one)
    sigmas = np.linspace(0.1, 0.5, 40)
    _, growing = cah.reprojectStripe(*calibration(r), pixelSigmas=sigmas)
    assert covariances is not None
    assert growing is not None
    np.testing.assert_allclose(growing, covariances * (sigmas[:, None, None] / 0.1) ** 2, rtol=1e-6)


def test_errors_of_the_robot_are_added() -> None:
    r = exact_recording()
    points, covariances = cah.reprojectStripe(
        *calibration(r), **transforms(r), robotTranslationSigma=2e-5, robotRotationSigma=1e-4
    )
    assert covariances is not None
    arms = points - transforms(r)["t_gripper2base"]
    squares = (arms**2).sum(axis=1)[:, None, None]
    turned = 1e-8 * (squares * np.eye(3) - arms[:, :, None] * arms[:, None])
    np.testing.assert_allclose(covariances, 4e-10 * np.eye(3) + turned, rtol=1e-9)


def test_an_empty_stripe_gives_no_points() -> None:
    r = exact_recording()
    nothing = np.zeros((0, 2))
    points, covariances = cah.reprojectStripe(nothing, r.cameraMatrix, r.distCoeffs, r.lightPlane, pixelSigmas=0.1)
    assert points.shape == (0, 3)
    assert covariances is not None
    assert covariances.shape == (0, 3, 3)


@pytest.mark.parametrize(
    ("keywords", "text"),
    [
        ({"R_cam2gripper": np.eye(3)}, "t_cam2gripper: needed together with R_cam2gripper, given none"),
        ({"calibrationCovariance": np.eye(4)}, "calibrationCovariance: needed 20 x 20 numbers .* given 4 x 4"),
        ({"pixelSigmas": [0.1, 0.2]}, "pixelSigmas: needed one number, or one for each of the 40 points, given 2"),
        ({"pixelSigmas": "0.1"}, "pixelSigmas: needed an array"),
        ({"robotRotationSigma": 1e-4}, "robotRotationSigma: needed R_gripper2base"),
    ],
)
def test_wrong_input_is_refused_by_name(keywords: dict[str, Any], text: str) -> None:
    with pytest.raises(cah.error, match=f"^{text}"):
        cah.reprojectStripe(*calibration(exact_recording()), **keywords)


def test_points_beside_the_light_plane_are_named() -> None:
    r = exact_recording()
    plane = np.array([1.0, 0.0, 0.0, 0.1])
    pixels = np.array([[600.0, 240.0], [100.0, 240.0], [500.0, 10.0]])
    with pytest.raises(cah.error) as caught:
        cah.reprojectStripe(pixels, r.cameraMatrix, r.distCoeffs, plane)
    assert re.search(r"given 1 of 3 points whose rays do not: 1; point 1 is \(100, 240\)$", str(caught.value))


def test_characteristic_points_of_two_views_are_placed_where_they_are() -> None:
    """The same segment given as two views of its points, the second shifted by its own covariance's worth."""
    r = exact_recording()
    points, _ = cah.reprojectStripe(*calibration(r), **transforms(r))
    view = r.stripeViews[SEGMENT]
    pixels, sigmas = r.stripePoints[SEGMENT], np.full(40, 0.1)
    stripe = (pixels, sigmas, np.zeros(40, np.int32))
    middle, covariance = cah.locateOnStripe(
        *stripe, pixels[20:21], r.cameraMatrix, r.distCoeffs, sigmaAlong=0.5, halfWindow=300
    )
    np.testing.assert_allclose(middle[0], pixels[20], atol=1e-6)
    place = (r.R_gripper2base, r.t_gripper2base, np.repeat(middle, 2, axis=0), [view, view], [0, 0])
    tool = (r.cameraMatrix, r.distCoeffs, r.lightPlane, r.R_cam2gripper, r.t_cam2gripper)
    X, C, apart = cah.measureStripePoints(
        *place, *tool, calibrationCovariance=None, pixelCovariances=np.repeat(covariance, 2, axis=0)
    )
    np.testing.assert_allclose(X[0], points[20], atol=1e-8)
    assert C.shape == (1, 3, 3)
    np.testing.assert_allclose(apart, 0, atol=1e-6)


def test_corner_of_two_pieces_is_their_intersection() -> None:
    r = exact_recording()
    u = np.arange(100.0, 180.0)
    pixels = np.column_stack([u, 240 - 0.5 * np.abs(u - 139.7)])
    ids = (u > 139.7).astype(np.int32)
    corners, covariances, angles, segments = cah.findProfileCorners(
        pixels, np.full(80, 0.1), ids, r.cameraMatrix, None, r.lightPlane
    )
    np.testing.assert_allclose(corners, [[139.7, 240.0]], atol=1e-6)
    np.testing.assert_array_equal(segments, [[0, 1]])
    assert covariances.shape == (1, 2, 2)
    assert np.linalg.eigvalsh(covariances[0]).min() > 0
    assert 0 < angles[0, 0] < 360
