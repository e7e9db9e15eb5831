# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Geometry, texture, light and laser of the simulated bench against positions worked out by hand."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
import trimesh
from numpy.typing import NDArray
from support.simulated_plate import (
    DISTORTION,
    level_plate,
    looking_down,
    renderer,
    small_camera,
    small_laser,
)

from cv_active_handeye.simulation import exact
from cv_active_handeye.simulation.bench import workbench
from cv_active_handeye.simulation.light import Lamp
from cv_active_handeye.simulation.optics import subpixel_grid
from cv_active_handeye.simulation.parts import box, plate, pose
from cv_active_handeye.simulation.texture import STYLES, synthesize, tile

Array = NDArray[np.float64]
TILTED = (12.0, -9.0, 5.0)


def test_box_is_closed_with_outward_faces() -> None:
    parts = box("box", "steel", (0.03, 0.05, 0.02), pose(0.1, -0.2, 0.3, (20, -30, 50)))
    corners = np.concatenate([p.vertices[p.faces] for p in parts]).reshape(-1, 3)
    mesh = trimesh.Trimesh(corners, np.arange(len(corners)).reshape(-1, 3))
    mesh.merge_vertices()
    assert mesh.is_watertight
    assert mesh.volume == pytest.approx(0.03 * 0.05 * 0.02, rel=1e-9)


def test_workbench_numbers_its_planes_and_has_a_groove_of_60_degrees() -> None:
    parts = workbench(np.random.default_rng(1))
    planar = [p.surface_id for p in parts if p.relief is None]
    assert planar == list(range(len(planar)))
    assert [p.surface_id for p in parts if p.relief is not None] == [-1]
    bevel = [
        max(p.normal[2] * (p.normal[2] < 0.9) for p in parts if p.name.startswith(f"weld {side}"))
        for side in ("left", "right")
    ]
    normals = [
        next(p.normal for p in parts if p.name.startswith(f"weld {side}") and p.normal[2] == z)
        for side, z in zip(("left", "right"), bevel, strict=True)
    ]
    opening = 180 - np.degrees(np.arccos(normals[0] @ normals[1]))
    assert opening == pytest.approx(60, abs=0.01)


def test_workbench_with_another_seed_is_arranged_differently() -> None:
    first, same, other = (np.concatenate([p.vertices for p in workbench(np.random.default_rng(s))]) for s in (1, 1, 2))
    np.testing.assert_array_equal(first, same)
    assert 0.0005 < np.abs(first - other).max() < 0.05


def test_cast_meets_the_plane_in_double_precision() -> None:
    scene, T = level_plate(), looking_down(TILTED)
    directions = small_camera().rays(subpixel_grid(small_camera(), 1)) @ T[:3, :3].T
    hits = scene.cast(T[:3, 3], directions)
    assert (hits.triangle >= 0).all()
    np.testing.assert_allclose(hits.depth, -T[2, 3] / directions[:, 2], rtol=1e-14)


def test_cast_beyond_the_bench_gives_nan_and_no_triangle() -> None:
    hits = level_plate().cast(np.array([0, 0, 0.5]), np.array([[0.0, 0, 1], [0, 0, -1]]))
    assert hits.triangle[0] == -1
    assert np.isnan(hits.depth[0])
    assert hits.depth[1] == pytest.approx(0.5)


def test_lamp_casts_the_shadow_of_a_box_where_geometry_puts_it() -> None:
    lamp = Lamp((0.5, 0.0, 0.5), 1e-6, 1.0)  # 45 degrees: the shadow reaches as far as the box is high
    block = box("box", "steel", (0.02, 0.10, 0.03), np.eye(4))
    scene, camera, T = level_plate(block, [lamp], ambient=0.1), small_camera(), looking_down()
    image, _ = renderer(scene, camera, small_laser(), laser=False).irradiance(T, np.random.default_rng(0))

    def radiance(x: float) -> float:
        u, v = np.rint(camera.project((np.array([[x, 0.0, 0.0]]) - T[:3, 3]) @ T[:3, :3])[0]).astype(int)
        return float(image[v, u])

    tip = -0.01 - 0.03 * 0.51 / 0.47  # ray over the upper edge (x = -0.01, z = 0.03)
    assert radiance(tip + 0.004) == pytest.approx(0.05, rel=0.03)
    ray = np.array([0.5 - (tip - 0.004), 0, 0.5])
    lit = 0.5 * (0.1 + 0.5**2 / (ray @ ray) * ray[2] / np.linalg.norm(ray))
    assert radiance(tip - 0.004) == pytest.approx(lit, rel=0.01)


@pytest.mark.parametrize("style", sorted(set(STYLES) - {"paper"}))
def test_natural_texture_is_rich_seeded_and_repeats_nowhere(style: str) -> None:
    first, same, other = (synthesize(STYLES[style], (400, 400), 0.2, np.random.default_rng(s)) for s in (1, 1, 2))
    np.testing.assert_array_equal(first, same)
    assert np.corrcoef(first.ravel(), other.ravel())[0, 1] < 0.3
    assert 0.05 < first.std() < 0.3
    assert first.min() >= 0.07
    assert first.max() <= 0.92
    assert strongest_repeat(first) < 0.5
    grey = cv2.resize((255 * first).astype(np.uint8), None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA)
    assert len(cv2.SIFT.create(contrastThreshold=0.04).detect(grey)) > 100


def test_texture_holds_nothing_that_two_samples_a_pixel_would_alias() -> None:
    image = synthesize(STYLES["stone"], (512, 512), 0.2, np.random.default_rng(3))
    power = np.abs(np.fft.rfft2(image - image.mean())) ** 2
    frequency = np.hypot(np.fft.fftfreq(512)[:, None], np.fft.rfftfreq(512)[None])  # cycles per texel
    assert power[frequency > 0.4].sum() < 1e-3 * power.sum()


def test_repeated_texture_has_the_configured_period_without_seams() -> None:
    image = tile((400, 400), 0.2, np.random.default_rng(4), 24.0)
    np.testing.assert_array_equal(image[:, :200], image[:, 120:320])
    np.testing.assert_array_equal(image[:200], image[120:320])
    jump = np.abs(np.diff(image[:, :240], axis=1)).mean(axis=0)
    assert jump[119] < 1.5 * np.median(jump)


def strongest_repeat(image: NDArray[np.float32]) -> float:
    """Highest correlation of the image with itself shifted by more than 6 mm."""
    patch = image[150:250, 150:250]
    match = cv2.matchTemplate(image, patch, cv2.TM_CCOEFF_NORMED)
    match[120:181, 120:181] = 0
    return float(match.max())


@pytest.mark.parametrize("distortion", [(0, 0, 0, 0, 0), DISTORTION])
@pytest.mark.parametrize("tilt", [(0.0, 0.0, 0.0), TILTED])
def test_stripe_in_the_image_lies_where_the_light_plane_meets_the_plate(
    distortion: tuple[float, ...], tilt: tuple[float, float, float]
) -> None:
    camera, laser, scene, T = small_camera(distortion), small_laser(), level_plate(), looking_down(tilt)
    off, on = renderer(scene, camera, laser).irradiance(T, np.random.default_rng(0))
    assert on is not None
    truth = exact.stripe(scene, camera, laser, T)
    np.testing.assert_array_equal(truth.points[:, 0], np.arange(camera.width))
    measured = np.array([row_centroid((on - off)[:, int(u)], v) for u, v in truth.points])
    error = measured - truth.points[:, 1]
    assert np.abs(error).max() < 0.02
    assert abs(error.mean()) < 0.01


def row_centroid(column: NDArray[np.float32], near: float) -> float:
    """Gaussian-weighted centroid, iterated: blind to the slope that perspective gives the profile's tails."""
    rows, centre = np.arange(len(column)), near
    for _ in range(30):
        weight = column * np.exp(-0.5 * ((rows - centre) / 1.7) ** 2)
        centre = float(2 * (weight @ rows) / weight.sum() - centre)
    return centre


def test_stripe_has_the_width_of_the_sheet_and_the_optics() -> None:
    camera, laser, scene = small_camera(), small_laser(2.6), level_plate()
    off, on = renderer(scene, camera, laser, blur_px=0.7).irradiance(looking_down(), np.random.default_rng(0))
    assert on is not None
    profile = (on - off)[:, 80].astype(np.float64)
    rows = np.arange(camera.height)
    centre = profile @ rows / profile.sum()
    sigma = np.sqrt(profile @ (rows - centre) ** 2 / profile.sum())
    sheet = 0.0026 / 0.55 * camera.K[1, 1] / abs(laser.n[1])
    assert sigma == pytest.approx(np.sqrt(sheet**2 + 0.7**2 + 1 / 12), rel=0.02)


def test_exact_stripe_lies_on_light_plane_and_surface_and_names_the_surface() -> None:
    ramp = plate("ramp", "steel", (0.06, 0.2, 0.004), pose(0.03, 0, 0.03, (0, 20, 0)))
    camera, laser, scene, T = small_camera(DISTORTION), small_laser(), level_plate(ramp), looking_down()
    scene.surface_id[:] = scene.patch_index
    stripe = exact.stripe(scene, camera, laser, T)
    np.testing.assert_allclose(stripe.points_3d @ laser.n, laser.d, atol=1e-12)
    on_plane = np.einsum("ij,ij->i", stripe.planes[:, :3], stripe.points_3d) - stripe.planes[:, 3]
    assert np.abs(on_plane).max() < 1e-9
    np.testing.assert_allclose(camera.project(stripe.points_3d), stripe.points, atol=1e-9)
    names = [scene.patches[i].name.split("/")[0] for i in stripe.surface_ids]
    x = stripe.points_3d[:, 0]
    assert all(
        name == ("ramp" if -0.01 < p < 0.05 else "plate")
        for name, p in zip(names, x, strict=True)
        if abs(p) < 0.04 and not -0.01 < p < 0.01
    )


def test_box_between_laser_and_plate_leaves_a_gap_in_image_and_truth() -> None:
    # The box hides the middle of the plate from the laser, which shines from the side of image top (+y of the scene).
    screen = box("screen", "steel", (0.05, 0.014, 0.06), pose(0, 0.013, 0))
    camera, laser, scene, T = small_camera(), small_laser(), level_plate(screen), looking_down()
    off, on = renderer(scene, camera, laser).irradiance(T, np.random.default_rng(0))
    assert on is not None
    truth = exact.stripe(scene, camera, laser, T)
    level = truth.points[np.abs(truth.planes @ [0, 0, -1, 0] - 1) < 1e-9]
    shadow = np.abs(truth.points_3d[:, 0]) < 0.02
    on_plate = np.abs(truth.points_3d[:, 2] - 0.55) < 1e-6
    assert not (shadow & on_plate).any()
    assert (shadow & ~on_plate).any()  # the light falls on the box instead
    row = round(float(np.median(level[:, 1])))
    light = (on - off)[row]
    assert light[70:88].max() < 1e-3 * light.max()
    assert light[20] > 0.5 * light.max()


def test_stripe_light_falls_with_the_angle_of_the_surface() -> None:
    camera, laser = small_camera(), small_laser()
    peaks = []
    for angle in (0.0, 40.0):
        wedge = plate("wedge", "steel", (0.2, 0.2, 0.004), pose(0, 0, 0.02, (angle, 0, 0)))
        off, on = renderer(level_plate(wedge), camera, laser).irradiance(looking_down(), np.random.default_rng(0))
        assert on is not None
        peaks.append(float((on - off)[:, 80].max()))
    ray = np.array([0, -0.55 * laser.n[2] / laser.n[1], -0.55])  # from the laser, about straight down, towards -y
    ray = np.array([0, -abs(ray[1]), ray[2]]) / np.linalg.norm(ray)
    turned = np.array([0, -np.sin(np.radians(40)), np.cos(np.radians(40))])
    assert peaks[1] / peaks[0] == pytest.approx((-ray @ turned) / -ray[2], abs=0.06)
