# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The bindings add nothing: results are those of the C++ functions, bit for bit."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray
from support.direct_calls import direct_call
from support.exact_recording import Recording, exact_recording, to_camera

import cv_active_handeye as cah

Array = NDArray[np.float64]


def noisy(points: Array) -> Array:
    """Pixels with noise, so that every bit of a result hangs on every step."""
    return np.asarray(points + np.random.default_rng(11).normal(0, 0.1, points.shape))


def points_on_stripes(r: Recording) -> Array:
    """(V, M, 2) pixels of scene points that the laser hits in one view or another, seen in all views."""
    scene = []
    for pixels, i in zip(r.stripePoints, r.stripeViews, strict=True):
        rays = np.insert(cv2.undistortPoints(pixels[::8].copy(), r.cameraMatrix, r.distCoeffs)[:, 0], 2, 1.0, axis=1)
        hits = rays * (r.lightPlane[3] / (rays @ r.lightPlane[:3]))[:, None]
        scene.append((hits @ r.R_cam2gripper.T + r.t_cam2gripper) @ r.R_gripper2base[i].T + r.t_gripper2base[i])
    base = np.vstack(scene)
    poses = zip(r.R_gripper2base, r.t_gripper2base, strict=True)
    in_views = [to_camera(base, R, t, r.R_cam2gripper, r.t_cam2gripper) for R, t in poses]
    identity = np.zeros(3), np.zeros(3)
    images = [cv2.projectPoints(X.copy(), *identity, r.cameraMatrix, r.distCoeffs)[0][:, 0] for X in in_views]
    return noisy(np.array(images))


def arguments(function: str) -> tuple[Any, ...]:
    """Inputs of a function from the recording, noise added."""
    r = exact_recording()
    poses = r.R_gripper2base, r.t_gripper2base
    points = noisy(r.imagePoints)
    stripes = [noisy(stripe) for stripe in r.stripePoints]
    views, surfaces = np.array(r.stripeViews), np.array(r.surfaceIds)
    camera = r.cameraMatrix, r.distCoeffs
    rows = np.arange(120)[:, None]
    image = (20 + 180 * np.exp(-0.5 * ((rows - 60.3 - 0.01 * np.arange(160)) / 1.5) ** 2)).astype(np.uint8)
    line = np.column_stack([np.arange(200.0), 100 + 0.2 * np.abs(np.arange(200.0) - 90)])
    return {
        "estimateFOE": (points[0], points[3]),
        "groupViews": (r.R_gripper2base,),
        "calibrateHandEyeTranslations": (*poses, points, None, r.distCoeffs),
        "calibrateHandEyeRotation": (*poses, points, *camera, r.R_cam2gripper),
        "calibrateLightPlane": (*poses, stripes, views, surfaces, *camera, r.R_cam2gripper),
        "detectStripe": (image,),
        "splitStripe": (noisy(line), np.full(200, 0.1), *camera),
        "associateStripes": (*poses, stripes, views, points_on_stripes(r), *camera, r.R_cam2gripper, r.t_cam2gripper),
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
