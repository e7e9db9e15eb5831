# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""GenICam pixel formats."""

from __future__ import annotations

import numpy as np
import pytest
from support.camera_emulation import HEIGHT, WIDTH, picture

from cv_active_handeye.cameras.common import BadFrameError
from cv_active_handeye.cameras.pixels import CANDIDATES, decode, layout_of


@pytest.mark.parametrize("bits", [10, 12, 14, 16])
def test_grey_of_more_than_8_bits_fills_16(bits: int) -> None:
    data = (picture(1, np.uint16) >> (16 - bits)).ravel()
    image = decode(data, WIDTH, HEIGHT, f"Mono{bits}")
    assert image.dtype == np.uint16
    np.testing.assert_array_equal(image, picture(1, np.uint16) >> (16 - bits) << (16 - bits))


@pytest.mark.parametrize(
    ("name", "order"),
    [("BGR8", [0, 1, 2]), ("RGB8Packed", [2, 1, 0]), ("BGRa8", [0, 1, 2, 0]), ("RGBa8", [2, 1, 0, 0])],
)
def test_colours_are_sorted_to_blue_green_red(name: str, order: list[int]) -> None:
    colour = picture(2, channels=3)
    np.testing.assert_array_equal(decode(colour[:, :, order].ravel(), WIDTH, HEIGHT, name), colour)


@pytest.mark.parametrize("pattern", ["RG", "GR", "GB", "BG"])
def test_bayer_pattern_gives_the_colour_that_was_sampled(pattern: str) -> None:
    """A plain colour seen through the filters: the first two letters name the filters of the first row."""
    blue_green_red = {"B": 30, "G": 90, "R": 200}
    first = pattern
    second = {"RG": "GB", "GR": "BG", "GB": "RG", "BG": "GR"}[pattern]
    cell = np.array([[blue_green_red[f] for f in row] for row in (first, second)], np.uint8)
    image = decode(np.tile(cell, (HEIGHT // 2, WIDTH // 2)), WIDTH, HEIGHT, f"Bayer{pattern}8")
    np.testing.assert_array_equal(image, np.broadcast_to([30, 90, 200], image.shape))


def test_decoded_image_does_not_share_the_buffer_of_the_driver() -> None:
    data = picture(3).copy()
    image = decode(data, WIDTH, HEIGHT, "Mono8")
    data[:] = 0
    np.testing.assert_array_equal(image, picture(3))


def test_every_format_that_is_asked_for_can_be_read() -> None:
    for names in CANDIDATES.values():
        assert all(layout_of(name) is not None for name in names)


@pytest.mark.parametrize(
    ("name", "size", "told"),
    [
        ("Mono12p", WIDTH * HEIGHT, r"pixel format Mono12p arrived, which this program does not read"),
        ("Mono8", WIDTH * HEIGHT - 1, r"3071 values of uint8 arrived where Mono8 needs 3072 of uint8"),
        ("Mono12", WIDTH * HEIGHT, r"3072 values of uint8 arrived where Mono12 needs 3072 of uint16"),
    ],
)
def test_unknown_or_incomplete_data_is_told(name: str, size: int, told: str) -> None:
    with pytest.raises(BadFrameError, match=told):
        decode(np.zeros(size, np.uint8), WIDTH, HEIGHT, name)
