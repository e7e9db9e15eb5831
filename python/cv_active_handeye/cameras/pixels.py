# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""GenICam pixel formats (PFNC names) as the images of this software: grey or BGR, 8 or 16 bit."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import cv2
import numpy as np
from numpy.typing import NDArray

from ..dataset import Image
from .common import BadFrameError

WantedPixels = Literal["mono8", "mono10", "mono12", "mono16", "bgr8"]

_COLOURS = ("BGR8", "BGR8Packed", "RGB8", "RGB8Packed", "BGRa8", "BGRA8Packed", "RGBa8")
_BAYER = {
    "BayerRG": cv2.COLOR_BayerRGGB2BGR,
    "BayerGR": cv2.COLOR_BayerGRBG2BGR,
    "BayerGB": cv2.COLOR_BayerGBRG2BGR,
    "BayerBG": cv2.COLOR_BayerBGGR2BGR,
}
CANDIDATES: dict[WantedPixels, tuple[str, ...]] = {
    "mono8": ("Mono8",),
    "mono10": ("Mono10",),
    "mono12": ("Mono12",),
    "mono16": ("Mono16",),
    "bgr8": (*_COLOURS, *(f"{pattern}8" for pattern in _BAYER)),
}
"""What a camera may call each of them, the cheapest first; bit-packed formats (Mono12p) are left out."""


@dataclass(frozen=True)
class Layout:
    """channels and bits of a pixel as it is sent; conversion: of cv2.cvtColor to BGR, None where there is none."""

    channels: int
    bits: int
    conversion: int | None


def layout_of(name: str) -> Layout | None:
    """The layout of a PFNC name among `CANDIDATES`, None for any other."""
    if name.startswith("Mono") and name[4:].isdigit():
        return Layout(1, int(name[4:]), None)
    if name[:7] in _BAYER and name[7:] == "8":
        return Layout(1, 8, _BAYER[name[:7]])
    conversions: dict[str, tuple[int, int | None]] = {
        "BGR8": (3, None),
        "RGB8": (3, cv2.COLOR_RGB2BGR),
        "BGRA8": (4, cv2.COLOR_BGRA2BGR),
        "RGBA8": (4, cv2.COLOR_RGBA2BGR),
    }
    found = conversions.get(name.removesuffix("Packed").upper())
    return None if found is None else Layout(found[0], 8, found[1])


def decode(data: NDArray[Any], width: int, height: int, name: str) -> Image:
    """Returns what was sent as `name` as (H, W) or (H, W, 3) BGR; 10 and 12 bits are shifted up to 16.

    The shift makes full scale the same for all 16-bit images. BadFrameError where format or amount are not as said.
    """
    layout = layout_of(name)
    if layout is None:
        raise BadFrameError(f"pixel format {name} arrived, which this program does not read")
    dtype = np.uint8 if layout.bits == 8 else np.uint16
    count = height * width * layout.channels
    if data.dtype != dtype or data.size != count:
        raise BadFrameError(
            f"{data.size} values of {data.dtype} arrived where {name} needs {count} of {dtype.__name__}"
        )
    shape = (height, width) if layout.channels == 1 else (height, width, layout.channels)
    image = data.reshape(shape)
    if layout.conversion is not None:
        return np.asarray(cv2.cvtColor(image, layout.conversion), np.uint8)
    return np.left_shift(image, 16 - layout.bits) if layout.bits > 8 else image.copy()
