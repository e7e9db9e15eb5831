# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest
from numpy.typing import NDArray
from support.patch_scene import natural_texture

from cv_active_handeye.tracking import TrackingConfig
from cv_active_handeye.tracking.features import detect_features, grey_image, normalise_brightness


def texture() -> NDArray[np.float32]:
    return natural_texture(np.random.default_rng(3), 300, 400)


def test_detect_features_has_no_bias_under_a_turn_by_180_degrees() -> None:
    image = texture()
    features = detect_features(image, TrackingConfig())
    turned = detect_features(np.ascontiguousarray(image[::-1, ::-1]), TrackingConfig())
    back = np.array([image.shape[1] - 1, image.shape[0] - 1]) - turned.points
    difference = features.points[:, None] - back[None]
    near = np.linalg.norm(difference, axis=2) < 1.0
    assert near.sum() > 150
    np.testing.assert_allclose(np.median(difference[near], axis=0), 0.0, atol=0.02)


def test_detect_features_keeps_the_number_asked_for() -> None:
    features = detect_features(texture(), TrackingConfig(max_features=60))
    assert 60 <= len(features) <= 61  # SIFT keeps ties of the last one
    np.testing.assert_allclose(np.linalg.norm(features.descriptors, axis=1), 1.0, atol=1e-5)


def test_detect_features_of_an_empty_image_is_empty() -> None:
    assert len(detect_features(np.full((60, 80), 100.0, np.float32), TrackingConfig())) == 0


@pytest.mark.parametrize("factor", [0.1, 40.0])
def test_normalise_brightness_brings_dark_and_16_bit_recordings_to_the_same_grey_values(factor: float) -> None:
    image, scale, half = texture(), np.float32(factor), np.float32(0.5)
    expected = normalise_brightness([image, half * image])
    for ours, theirs in zip(normalise_brightness([scale * image, scale * half * image]), expected, strict=True):
        np.testing.assert_allclose(ours, theirs, rtol=1e-4)
    assert np.percentile(expected[0], 99) > 180


def test_grey_image_of_colour_and_grey_agree() -> None:
    grey = np.asarray(np.rint(texture()), np.uint8)
    np.testing.assert_allclose(grey_image(np.dstack([grey] * 3), "image 0"), grey_image(grey, "image 0"), atol=1e-3)


@pytest.mark.parametrize(
    ("image", "text"),
    [
        (np.zeros((64, 64), np.float64), "image 3: need uint8 or uint16 pixels, got float64"),
        (np.zeros((64, 64, 4), np.uint8), r"image 3: need H x W or H x W x 3 .* got shape \(64, 64, 4\)"),
        (np.zeros((8, 64), np.uint8), r"at least 32 x 32 pixels, got shape \(8, 64\)"),
    ],
)
def test_grey_image_refuses_other_pixels_and_shapes(image: np.ndarray, text: str) -> None:
    with pytest.raises(ValueError, match=text):
        grey_image(image, "image 3")
