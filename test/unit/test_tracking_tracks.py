# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Whole tracks of small rendered scenes against exact correspondences."""

from dataclasses import dataclass

import numpy as np
import pytest
from numpy.typing import NDArray
from support.patch_scene import PatchScene, looking_at, workbench

from cv_active_handeye.tracking import TrackingConfig, TrackingError, Tracks, track_points

Array = NDArray[np.float64]
STAND_OFF = 0.55
STOPS = [  # target (m), turn, tilt about x and y (deg)
    ((0.0, 0.0, 0.0), 0.0, 0.0, 0.0),
    ((0.03, 0.0, 0.01), 0.0, 0.0, 0.0),
    ((0.0, 0.03, -0.01), 0.0, 0.0, 0.0),
    ((0.02, -0.02, 0.0), 90.0, 0.0, 0.0),
    ((-0.02, 0.01, 0.0), 0.0, 30.0, 0.0),
    ((0.01, 0.02, 0.01), -90.0, 0.0, -30.0),
]


@dataclass(frozen=True)
class Recording:
    scene: PatchScene
    poses: list[Array]
    images: list[NDArray[np.uint8]]

    @property
    def rotations(self) -> Array:
        return np.array([pose[:3, :3] for pose in self.poses])


def record(repeated: bool) -> Recording:
    scene = workbench(repeated=repeated, table=0.3, width=400, height=300)
    poses = [looking_at(target, STAND_OFF, *angles) for target, *angles in STOPS]
    gains = [1.0, 0.9, 1.0, 0.8, 1.0, 0.9]
    return Recording(
        scene, poses, [scene.render(pose, samples=2, gain=gain) for pose, gain in zip(poses, gains, strict=True)]
    )


@pytest.fixture(scope="module")
def natural() -> Recording:
    return record(repeated=False)


@pytest.fixture(scope="module")
def tracks(natural: Recording) -> Tracks:
    return track_points(natural.images, natural.rotations)


def errors(recording: Recording, tracks: Tracks) -> tuple[Array, NDArray[np.int64], Array]:
    """Errors (n, 2) of all observations but references (inf where hidden), their views, stated standard deviations."""
    error, views, sigmas = [], [], []
    for view, reference in np.argwhere(np.ones((len(STOPS), len(STOPS)))):
        chosen = np.flatnonzero((tracks.reference == reference) & tracks.seen[view])
        if view == reference or len(chosen) == 0:
            continue
        poses = recording.poses[reference], recording.poses[view]
        found = tracks.points[view, chosen] - recording.scene.correspond(*poses, tracks.points[reference, chosen])
        error.append(np.where(np.isnan(found), np.inf, found))
        views.append(np.full(len(chosen), view))
        sigmas.append(np.hypot(tracks.sigmas[view, chosen], tracks.sigmas[reference, chosen]))
    return np.concatenate(error), np.concatenate(views), np.concatenate(sigmas)


def test_track_points_is_precise_and_unbiased_in_every_view(natural: Recording, tracks: Tracks) -> None:
    error, views, _ = errors(natural, tracks)
    assert len(tracks) > 150
    for view in range(len(STOPS)):
        part = error[views == view]
        assert len(part) > 30
        assert (1.4826 * np.median(np.abs(part), axis=0)).max() < 0.06
        assert np.abs(np.median(part, axis=0)).max() < 0.015
    assert np.abs(np.median(error, axis=0)).max() < 0.01
    assert np.mean(np.linalg.norm(error, axis=1) > 2.0) <= 0.005


def test_track_points_states_standard_deviations_that_hold(natural: Recording, tracks: Tracks) -> None:
    error, _, sigmas = errors(natural, tracks)
    ratio = np.abs(error) / sigmas[:, None]
    assert 0.7 < 1.4826 * np.median(ratio) < 1.3
    assert np.percentile(ratio, 95) < 3.0
    weak = sigmas > np.median(sigmas)
    assert np.median(np.abs(error[weak])) > 1.2 * np.median(np.abs(error[~weak]))


def test_track_points_returns_consistent_arrays(natural: Recording, tracks: Tracks) -> None:
    assert tracks.points.shape == (len(STOPS), len(tracks), 2)
    assert tracks.points.dtype == np.float64
    np.testing.assert_array_equal(np.isfinite(tracks.sigmas), tracks.seen)
    assert (tracks.seen.sum(axis=0) >= 3).all()
    assert tracks.seen[tracks.reference, np.arange(len(tracks))].all()
    assert tracks.empty_views == []


def test_track_points_gives_the_same_bytes_again(natural: Recording, tracks: Tracks) -> None:
    again = track_points(natural.images, natural.rotations)
    np.testing.assert_array_equal(again.points, tracks.points)
    np.testing.assert_array_equal(again.sigmas, tracks.sigmas)


def test_track_points_reports_progress_up_to_the_end(natural: Recording) -> None:
    calls: list[tuple[int, int]] = []
    track_points(natural.images[:3], natural.rotations[:3], None, lambda done, total: calls.append((done, total)))
    assert calls == [(k + 1, 9) for k in range(9)]


def test_track_points_leaves_ambiguous_points_out_on_repeated_texture() -> None:
    recording = record(repeated=True)
    tracks = track_points(recording.images, recording.rotations)
    error, _, _ = errors(recording, tracks)
    assert len(tracks) > 20
    assert np.mean(np.linalg.norm(error, axis=1) > 2.0) <= 0.02


def test_track_points_works_on_two_views(natural: Recording) -> None:
    found = track_points(natural.images[:2], natural.rotations[:2])
    assert len(found) > 100
    assert (found.seen.sum(axis=0) == 2).all()


def test_track_points_of_16_bit_images_agrees_with_8_bit(natural: Recording) -> None:
    wide = [image.astype(np.uint16) * 16 for image in natural.images[:3]]
    found = track_points(wide, natural.rotations[:3])
    expected = track_points(natural.images[:3], natural.rotations[:3])
    np.testing.assert_allclose(found.points, expected.points, atol=1e-3)


def test_track_points_names_the_view_of_another_scene(natural: Recording) -> None:
    noise = np.random.default_rng(3).integers(0, 255, natural.images[0].shape, np.uint8)
    images = [*natural.images[:3], noise]
    found = track_points(images, natural.rotations[:4])
    assert found.empty_views == [3]
    assert {(0, 3), (1, 3), (2, 3)} <= set(found.left_out)


@pytest.mark.parametrize(
    ("change", "text"),
    [
        (lambda images, R: (images[:1], R[:1]), "images: need at least 2, got 1"),
        (lambda images, R: ([images[0], images[1][:200]], R[:2]), "image 0 is 400 x 300 and image 1 is 400 x 200"),
        (lambda images, R: (images[:3], R[:2]), r"R_gripper2base: need one 3x3 rotation for each of 3 images, got"),
        (lambda images, R: ([images[0], images[1] * 1.0], R[:2]), "image 1: need uint8 or uint16 pixels, got float64"),
        (lambda images, R: ([images[0], 0 * images[0]], R[:2]), r"Features in view 0: \d+, 1: 0. views 0 and 1: 0 mat"),
    ],
)
def test_track_points_names_what_is_wrong(natural: Recording, change: object, text: str) -> None:
    images, rotations = change(natural.images, natural.rotations)  # type: ignore[operator]
    with pytest.raises(TrackingError, match=text):
        track_points(images, rotations, TrackingConfig())
