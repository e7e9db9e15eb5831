# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The simulated camera against OpenCV's model, its images against predicted positions, its noise against statistics."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray
from support.simulated_plate import (
    DISTORTION,
    TEXEL_MM,
    level_plate,
    looking_down,
    paint,
    renderer,
    small_camera,
    small_laser,
)

from cv_active_handeye.simulation.optics import Camera, Sensor, subpixel_grid, through_lens
from cv_active_handeye.simulation.scene import Scene

Array = NDArray[np.float64]

DOT_SIGMA = 0.0026  # metres, 1.7 px of the small camera


def test_project_with_distortion_equals_opencv() -> None:
    camera = small_camera(DISTORTION)
    points = np.random.default_rng(1).uniform([-0.12, -0.09, 0.4], [0.12, 0.09, 0.7], (200, 3))
    expected, _ = cv2.projectPoints(points, np.zeros(3), np.zeros(3), camera.K, camera.D)
    np.testing.assert_allclose(camera.project(points), expected[:, 0], atol=1e-10)


def test_rays_of_distorted_pixels_invert_the_model() -> None:
    camera = small_camera(DISTORTION)
    pixels = subpixel_grid(camera, 1)
    rays = camera.rays(pixels)
    np.testing.assert_allclose(camera.project(0.5 * rays), pixels, atol=1e-9)
    criteria = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 200, 1e-15)
    expected = cv2.undistortPointsIter(pixels[:, None], camera.K, camera.D, None, None, criteria)  # type: ignore[call-overload]
    np.testing.assert_allclose(rays[:, :2], expected[:, 0], atol=1e-9)


def test_rays_of_a_model_that_folds_are_refused() -> None:
    with pytest.raises(ValueError, match="distortion: needs a model that can be inverted"):
        small_camera((-9.0, 0, 0, 0, 0)).rays(np.array([[0.0, 0.0]]))


def test_subpixel_grid_is_centred_on_integer_pixels() -> None:
    grid = subpixel_grid(small_camera(), 2).reshape(240, 320, 2)
    np.testing.assert_allclose(grid[:2, :2, 0], [[-0.25, 0.25], [-0.25, 0.25]])
    np.testing.assert_allclose(grid.reshape(120, 2, 160, 2, 2).mean(axis=(1, 3))[7, 31], [31, 7], atol=1e-12)


@pytest.mark.parametrize("distortion", [(0, 0, 0, 0, 0), DISTORTION])
@pytest.mark.parametrize("tilt", [(0, 0, 0), (18, -14, 70)])
def test_image_of_dots_shows_them_where_they_project(distortion: tuple[float, ...], tilt: tuple[float, ...]) -> None:
    scene, camera = level_plate(), small_camera(distortion)
    x, y = np.meshgrid(np.linspace(-0.096, 0.096, 7), np.linspace(-0.064, 0.064, 5))
    dots = np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], axis=1) + np.array([0.0013, -0.0007, 0])
    paint_dots(scene, dots)
    T = looking_down((tilt[0], tilt[1], tilt[2]))
    image, _ = renderer(scene, camera, small_laser(), laser=False).irradiance(T, np.random.default_rng(0))
    predicted = np.array([seen_centroid(camera, T, dot) for dot in dots])
    inside = (np.abs(predicted - [79.5, 59.5]) < [71, 51]).all(axis=1)
    error = np.array([centroid(image, p) - p for p in predicted[inside]])
    assert inside.sum() >= 20
    assert np.abs(error).max() < 0.02
    assert np.abs(error.mean(axis=0)).max() < 0.004


def seen_centroid(camera: Camera, T: Array, dot: Array) -> Array:
    """Centroid of a dot's image: its points weighted by brightness and by the image area they fill (~ 1 / Z^3)."""
    x, y = np.meshgrid(*[np.linspace(-4, 4, 33) * DOT_SIGMA] * 2)
    points = (dot + np.stack([x, y, 0 * x], axis=-1).reshape(-1, 3) - T[:3, 3]) @ T[:3, :3]
    weight = np.exp(-0.5 * (x**2 + y**2) / DOT_SIGMA**2).ravel() / points[:, 2] ** 3
    return np.asarray(weight @ camera.project(points) / weight.sum())


def paint_dots(scene: Scene, dots: Array) -> None:
    """Bright Gaussian dots on the top of the plate."""
    albedo = np.full_like(scene.albedo, 0.1)
    top = next(i for i, p in enumerate(scene.patches) if p.normal[2] > 0.99)
    patch, (rows, columns), start = scene.patches[top], scene.texture_shape[top], scene.texture_start[top]
    v, u = np.mgrid[:rows, :columns] * TEXEL_MM / 1000
    points = patch.origin + u[..., None] * patch.axes[0] + v[..., None] * patch.axes[1]
    r2 = ((points[:, :, None, :2] - dots[:, :2]) ** 2).sum(axis=-1)
    albedo[start : start + rows * columns] += 0.7 * np.exp(-0.5 * r2 / DOT_SIGMA**2).sum(axis=-1).ravel().astype(
        np.float32
    )
    paint(scene, albedo)


def centroid(image: NDArray[np.float32], near: Array) -> Array:
    column, row = np.round(near).astype(int)
    v, u = np.mgrid[row - 8 : row + 9, column - 8 : column + 9]
    weight = np.maximum(image[v, u] - np.median(image), 0).astype(np.float64)
    return np.asarray(np.array([(weight * u).sum(), (weight * v).sum()]) / weight.sum())


def test_lens_blur_has_the_configured_width_and_keeps_the_light() -> None:
    samples = np.zeros((82, 82), np.float32)
    samples[40:42, 40:42] = 1.0  # exactly pixel (20, 20)
    image = through_lens(samples, 2, 1.1).astype(np.float64)
    x = np.arange(41) - 20
    assert image.sum() == pytest.approx(1.0, abs=1e-5)
    pixel_variance = 2 / 12  # the pixel that emits and the pixel that collects, less the step of two samples
    assert (image.sum(axis=0) * x**2).sum() == pytest.approx(1.1**2 + pixel_variance, abs=0.06)


def test_sensor_noise_variance_is_linear_in_the_mean() -> None:
    sensor, rng = Sensor(8000.0, 30.0, 16), np.random.default_rng(2)
    levels = np.linspace(0.1, 0.8, 8)
    frames = [sensor.expose(np.full((300, 300), x, np.float32), 1.0, rng).astype(np.float64) / 65535 for x in levels]
    slope, offset = np.polyfit([f.mean() for f in frames], [f.var() for f in frames], 1)
    assert slope == pytest.approx(1 / 8000, rel=0.03)  # photon transfer: one electron
    assert offset == pytest.approx((30 / 8000) ** 2, abs=4e-6)


def test_sensor_saturates_and_scales_with_exposure() -> None:
    sensor, rng = Sensor(1e6, 0.0, 8), np.random.default_rng(3)
    light = np.full((50, 50), 0.8, np.float32)
    assert (sensor.expose(light, 2.0, rng) == 255).all()
    assert sensor.expose(light, 0.25, rng).mean() == pytest.approx(0.2 * 255, abs=0.1)
    assert sensor.expose(light, 0.25, rng).dtype == np.uint8
    assert Sensor(1e6, 0.0, 16).expose(light, 0.25, rng).mean() == pytest.approx(0.2 * 65535, abs=5)


def test_noise_of_a_dark_recording_is_larger_relative_to_the_signal() -> None:
    scene, camera = level_plate(), small_camera()
    relative = []
    for exposure in (1.0, 0.1):
        image, _ = renderer(scene, camera, small_laser(), exposure=exposure, bit_depth=16).take(
            looking_down(), np.random.default_rng(4)
        )
        centre = image[40:80, 50:110].astype(np.float64)
        relative.append(centre.std() / centre.mean())
    assert 3.0 < relative[1] / relative[0] < 4.5  # sqrt(10) from the photons, a little more from reading
