# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Calls of every public function, by name: positional arguments and keywords, alike for both bindings."""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from support.exact_recording import Recording

Array = NDArray[np.float64]
NOTHING: Mapping[str, Any] = MappingProxyType({})


class Call(NamedTuple):
    """One call. Parameter structures are given as the name of their class and the values of their fields."""

    function: str
    inputs: tuple[Any, ...]
    options: Mapping[str, Any] = NOTHING


class Params(NamedTuple):
    """A parameter structure of either binding."""

    name: str
    fields: Mapping[str, Any] = NOTHING


@cache
def recording() -> Recording:
    """The exact recording, made in another process with the cv2 of the environment: the one under test is too small."""
    program = "import pickle, sys; from support.exact_recording import exact_recording as r; "
    program += "sys.stdout.buffer.write(pickle.dumps(r()))"
    environment = os.environ | {"PYTHONPATH": str(Path(__file__).parents[1])}
    done = subprocess.run([sys.executable, "-c", program], env=environment, stdout=subprocess.PIPE, check=True)
    result: Recording = pickle.loads(done.stdout)
    return result


def noisy(points: Array, sigma: float = 0.1) -> Array:
    """Pixels with noise, so that every bit of a result hangs on every step."""
    return np.asarray(points + np.random.default_rng(11).normal(0, sigma, points.shape))


def poses(r: Recording) -> tuple[list[Array], list[Array]]:
    """As cv2 takes them."""
    return list(r.R_gripper2base), list(r.t_gripper2base)


def image() -> NDArray[np.uint8]:
    """A stripe over 160 columns."""
    rows = np.arange(120)[:, None]
    centre = 60.3 + 0.01 * np.arange(160)
    return (20 + 180 * np.exp(-0.5 * ((rows - centre) / 1.5) ** 2)).astype(np.uint8)


def stripe_calls(r: Recording) -> dict[str, Call]:
    """Images, pixels and points of stripes."""
    line = np.column_stack([np.arange(200.0), 100 + 0.2 * np.abs(np.arange(200.0) - 90)])
    sigmas, ids = np.full(200, 0.1), np.repeat([0, 1], 100).astype(np.int32)
    camera, light = (r.cameraMatrix, r.distCoeffs), r.lightPlane
    pixels, view = r.stripePoints[4], r.stripeViews[4]
    hand = {"R_cam2gripper": r.R_cam2gripper, "t_cam2gripper": r.t_cam2gripper}
    base = hand | {"R_gripper2base": r.R_gripper2base[view], "t_gripper2base": r.t_gripper2base[view]}
    errors = {"calibrationCovariance": 1e-8 * np.eye(20), "robotTranslationSigma": 2e-5, "robotRotationSigma": 1e-4}
    across = {"pixelSigmas": np.full(40, 0.1)}
    several = (*poses(r), np.repeat(pixels[20:21], 2, axis=0), np.array([view, view]), np.array([0, 0]))
    wide = {"params": Params("StripeParams", {"sigma": 2.0, "roi": (5, 5, 120, 110)})}
    return {
        "detect": Call("detectStripe", (image(),)),
        "detect 16 bit": Call("detectStripe", (image().astype(np.uint16) * 257,)),
        "detect on background": Call("detectStripe", (image(),), {"background": np.full((120, 160), 20, np.uint8)}),
        "detect in a part": Call("detectStripe", (image(),), wide),
        "detect nothing": Call("detectStripe", (np.full((60, 80), 10, np.uint8),)),
        "split": Call("splitStripe", (noisy(line), sigmas, *camera)),
        "split coarsely": Call("splitStripe", (noisy(line), None, *camera), {"breakDistance": 3.0, "minPoints": 5}),
        "locate": Call("locateOnStripe", (noisy(line), sigmas, ids, line[40:42], *camera), {"sigmaAlong": 0.5}),
        "corners": Call("findProfileCorners", (noisy(line), sigmas, ids, *camera, light)),
        "points in the camera frame": Call("reprojectStripe", (pixels, *camera, light)),
        "points in the gripper frame": Call("reprojectStripe", (pixels, *camera, light), hand),
        "points in the base frame": Call("reprojectStripe", (pixels, *camera, light), base | across),
        "points with all errors": Call("reprojectStripe", (pixels, *camera, light), base | errors),
        "measure": Call(
            "measureStripePoints",
            (*several, *camera, light, r.R_cam2gripper, r.t_cam2gripper),
            {"calibrationCovariance": 1e-8 * np.eye(20), "pixelCovariances": np.tile(0.01 * np.eye(2), (2, 1, 1))},
        ),
    }


def calibration_calls(r: Recording) -> dict[str, Call]:
    """Closed forms, refinement, verification and planning."""
    hand, points = poses(r), list(noisy(r.imagePoints))
    stripes, views, ids = [noisy(s) for s in r.stripePoints], np.array(r.stripeViews), np.array(r.surfaceIds)
    on_surfaces = list(noisy(r.surfaceImagePoints))
    camera, X = (r.cameraMatrix, r.distCoeffs), (r.R_cam2gripper, r.t_cam2gripper)
    laser = {"stripePoints": stripes, "stripeViews": views, "surfaceIds": ids}
    nothing = (None,) * 5
    exact_robot = Params("RefineParams", {"robotTranslationSigma": 0.0, "robotRotationSigma": 0.0, "lensModel": 2})
    known = {"pointSigma": 0.1, "stripeSigma": 0.1, "robotTranslationSigma": 2e-5, "robotRotationSigma": 1e-4}
    scene = np.random.default_rng(7).uniform([0.25, -0.15, -0.06], [0.55, 0.45, 0.06], (60, 3))
    seen = np.random.default_rng(8).uniform([0.42, 0.08, -0.06], [0.54, 0.2, 0.06], (60, 3))
    future = (*hand, seen, (640, 480), *camera, *X)
    levels = {"params": Params("RefineParams", known)}
    check = Params("VerifyParams", {"pointSigma": 0.1, "robotTranslationSigma": 2e-5, "robotRotationSigma": 1e-4})
    return {
        "FOE": Call("estimateFOE", (points[0], points[3])),
        "FOE least squares": Call("estimateFOE", (points[0], points[3]), {"method": 0}),
        "groups": Call("groupViews", (hand[0],)),
        "translations": Call("calibrateHandEyeTranslations", (*hand, points, None, r.distCoeffs)),
        "translations by FOE": Call("calibrateHandEyeTranslations", (*hand, points, None, r.distCoeffs), {"method": 1}),
        "translations, known K": Call("calibrateHandEyeTranslations", (*hand, points, *camera), {"flags": 1}),
        "rotation": Call("calibrateHandEyeRotation", (*hand, points, *camera, r.R_cam2gripper)),
        "light plane": Call("calibrateLightPlane", (*hand, stripes, views, ids, *camera, r.R_cam2gripper)),
        "associate": Call("associateStripes", (*hand, stripes, views, on_surfaces, *camera, *X)),
        "refine": Call("refineHandEye", (*hand, points, *nothing)),
        "refine with stripes": Call("refineHandEye", (*hand, points, *nothing), laser),
        "refine, exact robot": Call("refineHandEye", (*hand, points, *nothing), laser | {"params": exact_robot}),
        "refine from a start": Call("refineHandEye", (*hand, points, *camera, *X, None)),
        "refine with known points": Call("refineHandEye", (*hand, points, *nothing), {"objectPoints": scene}),
        "verify": Call("verifyHandEye", (*hand, points, *camera, *X, 1e-8 * np.eye(20)), {"params": check}),
        "predict": Call("predictHandEyeCovariance", future, levels),
        "plan": Call("planHandEyeViews", (*future, 10), levels),
    }


def target_poses(r: Recording) -> tuple[list[Array], list[Array]]:
    """R_target2cam, t_target2cam of a board, t with noise of 0.1 mm."""
    cam2base = r.R_gripper2base @ r.R_cam2gripper
    centres = r.R_gripper2base @ r.t_cam2gripper + r.t_gripper2base
    board = np.array([0.4, 0.1, 0.0])
    positions = noisy(np.einsum("vji,vj->vi", cam2base, board - centres), 1e-4)
    return [R.T.copy() for R in cam2base], list(positions)


def hand_eye_calls(r: Recording) -> dict[str, Call]:
    """From poses of a target."""
    poses_of_both = (*poses(r), *target_poses(r))
    names = ("Tsai", "Park", "Horaud", "Andreff", "Daniilidis", "refined")
    methods = {
        f"hand-eye by {name}": Call("calibrateHandEye", poses_of_both, {"method": number})
        for number, name in enumerate(names)
    }
    known = {"targetRotationSigma": 1e-4, "targetTranslationSigma": 1e-4, "robotRotationSigma": 1e-5}
    given = {"params": Params("HandEyeParams", known)}
    return methods | {
        "hand-eye": Call("calibrateHandEye", poses_of_both),
        "hand-eye, extended": Call("calibrateHandEyeExtended", poses_of_both),
        "hand-eye, known noise": Call("calibrateHandEyeExtended", poses_of_both, given),
    }


def calls() -> dict[str, Call]:
    """All of them."""
    r = recording()
    return hand_eye_calls(r) | calibration_calls(r) | stripe_calls(r)
