# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The bindings add nothing: results are those of the C++ functions, bit for bit."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from support.direct_calls import direct_call
from support.exact_recording import exact_recording

import cv_active_handeye as cah

Array = NDArray[np.float64]


def noisy(points: Array) -> Array:
    """Pixels with noise, so that every bit of a result hangs on every step."""
    return np.asarray(points + np.random.default_rng(11).normal(0, 0.1, points.shape))


def arguments(function: str) -> tuple[Any, ...]:
    """Inputs of a function from the recording, noise added."""
    r = exact_recording()
    poses = r.R_gripper2base, r.t_gripper2base
    points = noisy(r.imagePoints)
    stripes = [noisy(stripe) for stripe in r.stripePoints]
    camera = r.cameraMatrix, r.distCoeffs
    rows = np.arange(120)[:, None]
    image = (20 + 180 * np.exp(-0.5 * ((rows - 60.3 - 0.01 * np.arange(160)) / 1.5) ** 2)).astype(np.uint8)
    line = np.column_stack([np.arange(200.0), 100 + 0.2 * np.abs(np.arange(200.0) - 90)])
    return {
        "estimateFOE": (points[0], points[3]),
        "groupViews": (r.R_gripper2base,),
        "calibrateHandEyeTranslations": (*poses, points, None, r.distCoeffs),
        "calibrateHandEyeRotation": (*poses, points, *camera, r.R_cam2gripper),
        "calibrateLightPlane": (*poses, stripes, r.stripeViews, r.surfaceIds, *camera, r.R_cam2gripper),
        "detectStripe": (image,),
        "splitStripe": (noisy(line), np.full(200, 0.1), *camera),
        "associateStripes": (*poses, stripes, r.stripeViews, points, *camera, r.R_cam2gripper, r.t_cam2gripper),
    }[function]


def as_direct(function: str, inputs: tuple[Any, ...]) -> list[Any]:
    """The same inputs for direct_call: lists where the C++ function takes several arrays; None is left out."""
    several = {"estimateFOE": 0, "detectStripe": 0, "splitStripe": 0, "groupViews": 1}.get(function, 3)
    result = [list(a) if i < several else a for i, a in enumerate(inputs) if a is not None]
    if function == "associateStripes":
        result[4] = list(result[4])
    return result


@pytest.mark.parametrize(
    "function",
    [
        "estimateFOE",
        "groupViews",
        "calibrateHandEyeTranslations",
        "calibrateHandEyeRotation",
        "calibrateLightPlane",
        "detectStripe",
        "splitStripe",
        "associateStripes",
    ],
)
def test_python_and_cpp_give_the_same_bits(function: str) -> None:
    inputs = arguments(function)
    results = getattr(cah, function)(*inputs)
    expected = direct_call(function, *as_direct(function, inputs))

    results = results if isinstance(results, tuple) else (results,)
    assert len(results) == len(expected)
    for result, reference in zip(results, expected, strict=True):
        array = np.asarray(result, dtype=np.float64).reshape(reference.shape)
        assert array.size > 0
        assert array.tobytes() == reference.tobytes()
