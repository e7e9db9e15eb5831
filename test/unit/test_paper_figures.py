# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""doc/paper/errata.md, the light plane and the printed figures: Table 1, R, P, A and the plane of section 7."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from support.exact_recording import Array, gripper_poses, stripe_in_camera

import cv_active_handeye as cah

# "A New Method of Self-calibration of Hand-Eye Systems Based on Active Vision", section 7.1. Pixels and millimetres.
R_PRINTED = np.array([[-0.9996, -0.0278, 0.0142], [-0.0218, -0.9997, -0.0240], [0.0089, -0.0241, 0.9997]])
P_PRINTED = np.array([[-1400.5, 2.7, 282.5], [39.2, -1399.5, 205.9], [0, 0, 1]])
A_PRINTED = np.array([[1413.46, -9.7941, 285.565], [0, 1425.20, 236.27], [0, 0, 1]])
N_PRINTED, D4_PRINTED = np.array([0.1197, -8.8011, 1.8562]), 598.7141
PLANE_PRINTED = np.array([10.0002, -0.0147, 0.0031])
LARGEST_ERROR_PRINTED = 0.40
TABLE_1 = np.array(
    [  # computed x, y, z; actual x, y, z
        [301.08, 6.2873, -0.16, 301.08, 6.2873, -0.16],
        [310.44, 7.02, 0.23, 310.74, 6.80, -0.16],
        [325.99, 7.33, 0.22, 325.91, 7.18, -0.16],
        [341.03, 8.42, 0.23, 340.82, 8.14, -0.16],
        [341.44, -11.77, 0.01, 341.71, -11.95, -0.16],
        [327.47, -12.52, 0.23, 327.08, -12.59, -0.16],
        [312.06, -13.83, -0.51, 311.68, -13.46, -0.16],
        [313.04, -33.56, -0.54, 312.72, -33.65, -0.16],
        [328.11, -32.39, 0.02, 327.51, -32.62, -0.16],
        [342.49, -32.27, 0.07, 342.87, -31.98, -0.16],
        [332.34, -26.13, 46.41, 333.49, -25.94, 46.57],
        [328.88, -8.86, 33.61, 328.57, -8.50, 33.26],
        [324.13, 7.52, 23.47, 324.53, 7.91, 23.07],
        [320.79, 23.63, 12.24, 320.90, 24.03, 11.84],
        [312.46, 40.24, 1.94, 312.82, 40.63, 1.76],
    ]
)

K = np.array([[1413.0, 0, 322], [0, 1409, 236], [0, 0, 1]])
R_CAM2GRIPPER = Rotation.from_euler("xyz", [3, -4, 95], degrees=True).as_matrix()
T_CAM2GRIPPER = np.array([0.035, -0.06, 0.045])
SURFACES = np.array([[0.1, 0.05, 1, 0.02], [-0.35, 0.1, 1, -0.15]])
"""Base frame, metres."""


@dataclass(frozen=True)
class Stripes:
    """Segments without noise, and the five views of one orientation they were seen in."""

    R_gripper2base: Array
    t_gripper2base: Array
    points: list[Array]
    views: Array
    surfaces: Array


def light_plane(d: float) -> Array:
    return np.append(np.array([0.05, 0.87, 0.45]) / np.linalg.norm([0.05, 0.87, 0.45]), d)


def stripes(light: Array, surfaces: Array = SURFACES) -> Stripes:
    R, t = (poses[:5] for poses in gripper_poses())
    points, views, ids = [], [], []
    for i, (orientation, position) in enumerate(zip(R, t, strict=True)):
        for j, surface in enumerate(surfaces):
            to_base, origin = orientation @ R_CAM2GRIPPER, orientation @ T_CAM2GRIPPER + position
            in_camera = np.append(surface[:3] @ to_base, surface[3] - surface[:3] @ origin)
            seen = stripe_in_camera(in_camera, light) @ K.T
            points.append(seen[:, :2] / seen[:, 2:])
            views.append(i)
            ids.append(j)
    return Stripes(R, t, points, np.array(views), np.array(ids))


def lines(seen: Stripes, surface: int) -> Array:
    """(21): a, b, c with a^2 + b^2 = 1 of the lines of one surface."""
    chosen = [points for points, j in zip(seen.points, seen.surfaces, strict=True) if j == surface]
    ends = [np.cross([*points[0], 1], [*points[-1], 1]) for points in chosen]
    return np.array([line / np.linalg.norm(line[:2]) for line in ends])


def vanishing_pixel(seen: Stripes, surface: int) -> tuple[Array, int]:
    """(22), meant as the pixel nearest to all lines; and the rank of its equations."""
    by_line = lines(seen, surface)
    pixel, _, rank, _ = np.linalg.lstsq(by_line[:, :2], -by_line[:, 2], rcond=1e-9)
    return np.asarray(pixel), int(rank)


def vanishing_direction(seen: Stripes, surface: int) -> Array:
    """Ours: the direction nearest to all interpretation planes, also at infinity."""
    planes = lines(seen, surface) @ K
    return np.asarray(np.linalg.svd(planes / np.linalg.norm(planes, axis=1, keepdims=True))[2][-1])


def true_direction(light: Array, surface: int, surfaces: Array = SURFACES) -> Array:
    r = np.cross(light[:3], surfaces[surface, :3] @ gripper_poses()[0][0] @ R_CAM2GRIPPER)
    return np.asarray(r / np.linalg.norm(r))


def calibrated(seen: Stripes) -> Array:
    poses = seen.R_gripper2base, seen.t_gripper2base
    _, plane, _ = cah.calibrateLightPlane(*poses, seen.points, seen.views, seen.surfaces, K, None, R_CAM2GRIPPER)
    return plane[:, 0]


def test_sum_of_22_over_the_variables_of_the_lines_does_not_depend_on_the_vanishing_point() -> None:
    light = light_plane(0.23)
    seen = stripes(light)
    by_line = lines(seen, 1)
    on_lines = [points for points, j in zip(seen.points, seen.surfaces, strict=True) if j == 1]
    for row in range(len(on_lines[0])):
        variables = np.array([[*points[row], 1] for points in on_lines])
        assert np.sum(np.sum(by_line * variables, axis=1) ** 2) < 1e-18
        assert np.linalg.norm(variables[0, :2] - vanishing_pixel(seen, 1)[0]) > 100

    meant, rank = vanishing_pixel(seen, 1)
    assert rank == 2
    truth = K @ true_direction(light, 1)
    np.testing.assert_allclose(meant, truth[:2] / truth[2], rtol=1e-8)
    for step in np.array([[1, 0], [-1, 0], [0, 1], [0, -1]]):
        assert np.sum((by_line @ [*(meant + step), 1]) ** 2) > 1e-4
    np.testing.assert_allclose(calibrated(seen), light, atol=1e-9)


def test_vanishing_point_of_22_at_infinity_is_a_direction() -> None:
    light = light_plane(0.23)
    to_base = gripper_poses()[0][0] @ R_CAM2GRIPPER
    sideways = np.cross(light[:3], [0, 0, 1])
    tilted = np.cross(sideways, light[:3]) + 0.9 * light[:3]
    normal = to_base @ tilted / np.linalg.norm(tilted)
    surfaces = np.array([np.append(normal, normal @ [0.4, 0.0, 0.0]), SURFACES[1]])
    seen = stripes(light, surfaces)

    pixel, rank = vanishing_pixel(seen, 0)
    assert rank == 1
    printed = np.linalg.solve(K, [*pixel, 1])
    truth = true_direction(light, 0, surfaces)
    assert abs(printed @ truth) < 0.7 * np.linalg.norm(printed)
    assert abs(vanishing_direction(seen, 0) @ truth) == pytest.approx(1, abs=1e-12)
    np.testing.assert_allclose(calibrated(seen), light, atol=1e-9)


def test_directions_of_25_leave_the_offset_of_the_plane_open() -> None:
    near, far = light_plane(0.23), light_plane(0.26)
    for surface in (0, 1):
        pixels = [vanishing_pixel(stripes(light), surface)[0] for light in (near, far)]
        np.testing.assert_allclose(pixels[1], pixels[0], rtol=1e-7)
    for light in (near, far):
        r1, r2 = (vanishing_direction(stripes(light), surface) for surface in (0, 1))
        normal = np.cross(r1, r2) / np.linalg.norm(np.cross(r1, r2))
        assert abs(normal @ light[:3]) == pytest.approx(1, abs=1e-12)
        np.testing.assert_allclose(calibrated(stripes(light)), light, atol=1e-9)


def test_printed_rotation_is_no_rotation() -> None:
    assert np.max(np.abs(R_PRINTED.T @ R_PRINTED - np.eye(3))) == pytest.approx(0.049, abs=5e-4)
    lengths = np.linalg.norm(R_PRINTED, axis=0)
    angle = np.degrees(np.arccos(R_PRINTED[:, 0] @ R_PRINTED[:, 1] / (lengths[0] * lengths[1])))
    assert abs(angle - 90) == pytest.approx(2.83, abs=0.005)

    U, scales, Vt = np.linalg.svd(R_PRINTED)
    nearest = U @ Vt
    np.testing.assert_allclose(nearest.T @ nearest, np.eye(3), atol=1e-12)
    assert np.linalg.det(nearest) == pytest.approx(1, abs=1e-12)
    between = np.degrees(np.arccos(np.sum(R_PRINTED * nearest, axis=0) / lengths))
    np.testing.assert_allclose(between, [1.42, 1.41, 0.14], atol=0.005)
    # Rounding to four decimals changes them by 1.5e-4 at most.
    np.testing.assert_allclose(scales, [1.0246, 1.0000, 0.9750], atol=1e-4)


def test_printed_camera_matrix_is_not_the_product_of_18() -> None:
    product = P_PRINTED @ R_PRINTED
    assert A_PRINTED[0, 0] - product[0, 0] == pytest.approx(11.1, abs=0.05)
    assert A_PRINTED[0, 1] - product[0, 1] == pytest.approx(-39.2, abs=0.05)
    assert A_PRINTED[1, 1] - product[1, 1] == pytest.approx(32.2, abs=0.05)
    assert A_PRINTED[0, 2] - product[0, 2] == pytest.approx(23.1, abs=0.05)
    assert product[1, 0] == pytest.approx(-6.8, abs=0.05)
    # The third row of P says that the optical axis is the z axis of the hand; R_PRINTED turns it by 1.6 degrees.
    assert np.degrees(np.arctan2(np.hypot(*R_PRINTED[:2, 2]), R_PRINTED[2, 2])) == pytest.approx(1.6, abs=0.05)


def test_printed_light_plane_is_behind_the_camera_for_every_pixel() -> None:
    np.testing.assert_allclose((N_PRINTED / D4_PRINTED)[1:], PLANE_PRINTED[1:], atol=5e-5)
    assert N_PRINTED[0] / D4_PRINTED == pytest.approx(0.0002, abs=5e-5)
    assert N_PRINTED[0] / D4_PRINTED < PLANE_PRINTED[0] - 9.9

    u, v = np.meshgrid(np.arange(640.0), np.arange(480.0))
    pixels = np.column_stack([u.ravel(), v.ravel()])
    rays = np.insert(pixels, 2, 1.0, axis=1) @ np.linalg.inv(A_PRINTED).T
    for plane in (np.append(N_PRINTED / D4_PRINTED, 1), np.array([0.0002, *PLANE_PRINTED[1:], 1])):
        depths = -plane[3] / (rays @ plane[:3])
        assert depths.max() < -170
        # In our form n.X = d, d > 0.
        ours = np.append(-plane[:3], plane[3]) / np.linalg.norm(plane[:3])
        with pytest.raises(cah.error, match="plane"):
            cah.reprojectStripe(pixels[:1], A_PRINTED, None, ours)
        # The other sign of d4 is a plane that could be meant.
        points, _ = cah.reprojectStripe(pixels, A_PRINTED, None, np.append(-ours[:3], ours[3]))
        np.testing.assert_allclose(points[:, 2], -depths, rtol=1e-9)
    literal = -1 / (rays @ PLANE_PRINTED)
    assert 0.4 < np.mean(literal > 0) < 0.5


def test_table_1_has_larger_errors_than_the_printed_maximum() -> None:
    errors = TABLE_1[:, :3] - TABLE_1[:, 3:]
    lengths = np.linalg.norm(errors, axis=1)
    assert lengths.max() == pytest.approx(1.18, abs=0.005)
    assert np.sqrt(np.mean(lengths**2)) == pytest.approx(0.60, abs=0.005)
    assert lengths.mean() == pytest.approx(0.555, abs=0.0005)
    assert np.sum(lengths > LARGEST_ERROR_PRINTED) == 13

    above = np.argwhere(np.abs(errors) > LARGEST_ERROR_PRINTED + 1e-9)
    assert above.tolist() == [[8, 0], [10, 0]]
    np.testing.assert_allclose(errors[above[:, 0], above[:, 1]], [0.60, -1.15], atol=1e-9)
    # S1: computed and actual are the same numbers; without it the other fourteen have
    assert np.all(errors[0] == 0)
    assert np.sqrt(np.mean(lengths[1:] ** 2)) == pytest.approx(0.62, abs=0.005)


def test_the_page_names_every_test_of_errata_and_no_other() -> None:
    here = Path(__file__).resolve()
    page = (here.parents[2] / "doc/paper/errata.md").read_text(encoding="utf-8")
    tests = "".join(path.read_text(encoding="utf-8") for path in sorted(here.parent.glob("test_paper_*.py")))
    defined = set(re.findall(r"^def (test_\w+)\(", tests, re.MULTILINE))
    named = set(re.findall(r"`(test_\w+)`", page))
    assert named == defined - {"test_the_page_names_every_test_of_errata_and_no_other"}
