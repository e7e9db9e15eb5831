# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Calls that both bindings have to refuse: wrong input, and data that cannot answer."""

from __future__ import annotations

import numpy as np
from parity.calls import Call, Params, calls, image, poses, recording, target_poses

NO_SUCH = 99


def _refused_inputs() -> dict[str, Call]:
    r = recording()
    R, t = poses(r)
    points, camera = list(r.imagePoints), (r.cameraMatrix, r.distCoeffs)
    three = np.zeros((5, 3))
    bent = [2 * R[0], *R[1:]]
    hole = [np.full((3, 3), np.nan), *R[1:]]
    flat = np.diag([1000.0, 1000.0, 0.0])
    line = np.column_stack([np.arange(200.0), np.full(200, 100.0)])
    half = {"R_cam2gripper": r.R_cam2gripper}
    board = target_poses(r)
    wide = Params("StripeParams", {"roi": (0, 0, 1000, 1000)})
    return {
        "points of three columns": Call("estimateFOE", (three, three)),
        "two lengths": Call("estimateFOE", (points[0], points[1][:-1])),
        "threshold below zero": Call("estimateFOE", (points[0], points[1]), {"threshold": -1.0}),
        "confidence above one": Call("estimateFOE", (points[0], points[1]), {"confidence": 1.5}),
        "unknown method": Call("calibrateHandEyeTranslations", (R, t, points, None, None), {"method": NO_SUCH}),
        "unknown flags": Call("calibrateHandEyeTranslations", (R, t, points, None, None), {"flags": 1 << 20}),
        "no rotation": Call("calibrateHandEyeTranslations", (bent, t, points, None, None)),
        "NaN in a pose": Call("calibrateHandEyeTranslations", (hole, t, points, None, None)),
        "a pose too few": Call("calibrateHandEyeTranslations", (R, t[:-1], points, None, None)),
        "camera matrix of zeros": Call("calibrateHandEyeRotation", (R, t, points, flat, None, r.R_cam2gripper)),
        "six coefficients": Call(
            "calibrateHandEyeRotation", (R, t, points, r.cameraMatrix, np.zeros(6), r.R_cam2gripper)
        ),
        "negative tolerance": Call("groupViews", (R,), {"orientationTolerance": -1.0}),
        "image too small": Call("detectStripe", (image(),), {"params": wide}),
        "background of another size": Call("detectStripe", (image(),), {"background": image()[:-1]}),
        "sigmas too few": Call("splitStripe", (line, np.full(9, 0.1), *camera)),
        "unknown hand-eye method": Call("calibrateHandEye", (R, t, *board), {"method": NO_SUCH}),
        "two poses of the target": Call("calibrateHandEye", (R, t, board[0][:2], board[1][:2])),
        "inverted poses": Call("calibrateHandEye", (R, t, [T.T.copy() for T in board[0]], board[1])),
        "no light plane": Call("reprojectStripe", (line, *camera, np.zeros(4))),
        "half of a transform": Call("reprojectStripe", (line, *camera, r.lightPlane), half),
        "stripes without views": Call("refineHandEye", (R, t, points, *(None,) * 5), {"stripePoints": r.stripePoints}),
        "covariance too small": Call(
            "verifyHandEye", (R, t, points, *camera, r.R_cam2gripper, r.t_cam2gripper, np.eye(6))
        ),
        "image of no size": Call(
            "predictHandEyeCovariance", (R, t, points[0], (0, 480), *camera, r.R_cam2gripper, r.t_cam2gripper)
        ),
    }


def _no_answer() -> dict[str, Call]:
    r = recording()
    R, t = poses(r)
    points, camera = list(r.imagePoints), (r.cameraMatrix, r.distCoeffs)
    still = ([R[0]] * 5, [t[0]] * 5, [points[0]] * 5)
    same = ([R[0]] * 5, t[:5], points[:5])
    beside = np.array([1.0, 0.0, 0.0, 0.1])
    return {
        "one match": Call("estimateFOE", (points[0][:1], points[1][:1])),
        "hand-eye without turns": Call("calibrateHandEye", (R[:5], t[:5], *(poses[:5] for poses in target_poses(r)))),
        "no motion in the image": Call("estimateFOE", (points[0], points[0])),
        "no motion": Call("calibrateHandEyeTranslations", (*still, None, None)),
        "orientation never changed": Call("calibrateHandEyeRotation", (*same, *camera, r.R_cam2gripper)),
        "refinement without rotation": Call("refineHandEye", (*same, *(None,) * 5)),
        "rays beside the light plane": Call("reprojectStripe", (np.array([[600.0, 240], [100, 240]]), *camera, beside)),
        "too many stops": Call("planHandEyeViews", (*calls()["plan"].inputs[:-1], 1000), calls()["plan"].options),
    }


def refused() -> dict[str, Call]:
    """All of them."""
    return _refused_inputs() | _no_answer()
