# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Patch alignment on a texture known in closed form, so that warped images are exact."""

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from cv_active_handeye.tracking.patches import Warps, align, make_templates, sample, upsample
from cv_active_handeye.tracking.refinement import local_warps

Array = NDArray[np.float64]
RADIUS = 10
RNG = np.random.default_rng(4)
WAVES = RNG.uniform(-0.9, 0.9, (60, 2))
PHASES = RNG.uniform(0, 2 * np.pi, 60)
AMPLITUDES = 25.0 / (1.0 + 3.0 * np.linalg.norm(WAVES, axis=1))


def grey(points: Array) -> NDArray[np.float32]:
    angle = points @ WAVES.T + PHASES
    return np.asarray(120.0 + np.sin(angle) @ AMPLITUDES, np.float32)


def image_through(homography: Array, size: tuple[int, int] = (200, 160)) -> NDArray[np.float32]:
    """Image whose pixel H(x) shows what the texture has at x."""
    pixels = np.stack(np.meshgrid(np.arange(size[0]), np.arange(size[1])), axis=-1).reshape(-1, 2).astype(np.float64)
    mapped = np.column_stack([pixels, np.ones(len(pixels))]) @ np.linalg.inv(homography).T
    return grey(mapped[:, :2] / mapped[:, 2:]).reshape(size[1], size[0])


def mapped(homography: Array, points: Array) -> Array:
    there = np.column_stack([points, np.ones(len(points))]) @ homography.T
    return np.asarray(there[:, :2] / there[:, 2:])


def view_homography(turn_deg: float, tilt_deg: float) -> Array:
    """Camera (f = 1413 px) before a plane, turned about its optical axis and tilted, centred on the image."""
    to_image = np.array([[1413.0, 0, 100], [0, 1413.0, 80], [0, 0, 1]])
    rotation = cv2.Rodrigues(np.radians([0.0, 0.0, turn_deg]))[0] @ cv2.Rodrigues(np.radians([0.0, tilt_deg, 0.0]))[0]
    plane_to_camera = np.column_stack([rotation[:, :2], [0.0, 0.0, 1.0]])
    return np.asarray(to_image @ plane_to_camera @ np.linalg.inv(to_image))


CENTRES = np.array([[100.0, 80.0], [92.0, 88.0], [113.0, 71.0], [104.0, 95.0], [85.0, 66.0]])


@pytest.mark.parametrize(("turn", "tilt"), [(0.0, 0.0), (30.0, 0.0), (90.0, 0.0), (0.0, 30.0), (90.0, 30.0)])
def test_align_finds_positions_under_turn_and_tilt(turn: float, tilt: float) -> None:
    homography = view_homography(turn, tilt)
    templates = make_templates(upsample(image_through(np.eye(3))), CENTRES, RADIUS)
    shape, perspective = local_warps(homography, CENTRES)
    truth = mapped(homography, CENTRES)
    start = Warps(truth + np.array([0.7, -0.6]), shape @ np.array([[1.05, 0.04], [-0.03, 0.96]]), perspective)
    found = align(templates, upsample(image_through(homography)), start, 20)
    np.testing.assert_allclose(found.warps.position, truth, atol=0.006)
    np.testing.assert_allclose(found.warps.shape, shape, atol=0.01)
    assert found.correlation.min() > 0.999


def test_align_is_invariant_to_gain_and_offset() -> None:
    homography = np.array([[1.0, 0.0, 0.37], [0.0, 1.0, -0.81], [0.0, 0.0, 1.0]])
    templates = make_templates(upsample(image_through(np.eye(3))), CENTRES, RADIUS)
    start = Warps(CENTRES.copy(), np.tile(np.eye(2), (5, 1, 1)), np.zeros((5, 2)))
    found = align(templates, upsample(0.4 * image_through(homography) + 35.0), start, 20)
    np.testing.assert_allclose(found.warps.position, CENTRES + np.array([0.37, -0.81]), atol=0.004)
    assert found.correlation.min() > 0.999


def test_align_without_the_perspective_part_is_biased_at_30_degrees() -> None:
    homography = view_homography(0.0, 30.0)
    templates = make_templates(upsample(image_through(np.eye(3))), CENTRES, RADIUS)
    shape, perspective = local_warps(homography, CENTRES)
    start = Warps(mapped(homography, CENTRES), shape, np.zeros_like(perspective))
    found = align(templates, upsample(image_through(homography)), start, 20)
    assert 0.004 < np.abs(np.mean(found.warps.position - mapped(homography, CENTRES), axis=0)).max() < 0.03


def test_align_states_the_scatter_of_white_noise() -> None:
    """Standard deviation from residual and structure against the scatter over many noisy images."""
    rng = np.random.default_rng(8)
    templates = make_templates(upsample(image_through(np.eye(3))), CENTRES, RADIUS)
    start = Warps(CENTRES.copy(), np.tile(np.eye(2), (5, 1, 1)), np.zeros((5, 2)))
    clean = image_through(np.eye(3))
    runs = [
        align(templates, upsample(clean + 4 * rng.standard_normal(clean.shape, np.float32)), start, 20)
        for _ in range(60)
    ]
    scatter = np.std([run.warps.position for run in runs], axis=0)
    variance = np.mean([run.residual**2 for run in runs], axis=0)
    stated = np.sqrt(variance[:, None] * np.einsum("nii->ni", templates.noise_gain))
    np.testing.assert_allclose(scatter / stated, 1.0, atol=0.3)


def test_sample_reads_the_image_between_pixels() -> None:
    points = np.random.default_rng(2).uniform(20, 140, (50, 7, 2))
    values = sample(upsample(image_through(np.eye(3))), points)
    np.testing.assert_allclose(values, grey(points.reshape(-1, 2)).reshape(50, 7), atol=1.0)


def test_local_warps_reproduces_the_homography_around_a_point() -> None:
    homography = view_homography(40.0, 25.0)
    offsets = np.array([[5.0, -3.0], [-8.0, 2.0]])
    shape, perspective = local_warps(homography, CENTRES)
    warped = Warps(mapped(homography, CENTRES), shape, perspective).apply(offsets)
    expected = np.stack([mapped(homography, CENTRES + offset) for offset in offsets], axis=1)
    np.testing.assert_allclose(warped, expected, atol=1e-9)
