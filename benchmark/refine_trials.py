# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Trials of refineHandEye in random worlds: errors, bounds and intervals of every parameter."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy.spatial.transform import Rotation

import cv_active_handeye as cah

from .fisher import linear_solution
from .scene import Array
from .stops import STOPS_24, active_stops
from .stripes import SEGMENT_POINTS, random_stripes
from .world import DISTORTED, NAMES, Noise, Recording, World, random_world

PINHOLE = ("fx", "fy", "cx", "cy", "rx", "ry", "rz", "tx", "ty", "tz")
"""Estimated parameters of a lens without distortion; the skew is fixed."""


@dataclass(frozen=True)
class Case:
    """A kind of recording, and the lens model that the calibration is told."""

    name: str
    noise: Noise = field(default_factory=Noise)
    stops: tuple[int, ...] = STOPS_24
    points: int = 60
    distorted: bool = False
    stripes: bool = False
    lens: int | None = None
    """None = the true one."""

    @property
    def lens_model(self) -> int:
        """What the calibration is told."""
        return (cah.LENS_K1_K2 if self.distorted else cah.LENS_FIXED) if self.lens is None else self.lens

    @property
    def free(self) -> tuple[str, ...]:
        """Estimated parameters, light plane aside, when the lens model is the true one."""
        return (*PINHOLE, "k1", "k2") if self.distorted else PINHOLE

    def world(self, rng: np.random.Generator) -> World:
        """A random one."""
        motion = active_stops(rng, self.stops)
        stripes = random_stripes(rng) if self.stripes else None
        return random_world(rng, motion, self.points, DISTORTED if self.distorted else None, stripes)


@dataclass(frozen=True)
class Estimate:
    """What refineHandEye returned: its summary, and the error (20) of NAMES against the truth."""

    error: Array
    calibration: tuple[Array, Array, Array, Array, Array | None]
    summary: cah.RefineSummary


@dataclass(frozen=True)
class Outcome:
    """Of one trial, 20 each: error, variances of the bound, an error that reaches it, deviations, intervals hit."""

    error: Array
    bound: Array
    linear: Array
    deviations: Array
    covered: Array
    noise_levels: Array
    lens_model: int
    p_value: float
    usable: bool
    problem: str = ""


class Outcomes:
    """Of all trials of a case and one way of calling; the arrays of Outcome as (T, 20)."""

    def __init__(self, outcomes: Sequence[Outcome]) -> None:
        good = [outcome for outcome in outcomes if not outcome.problem]
        self.problems = [outcome.problem for outcome in outcomes if outcome.problem]
        self.unusable = sum(not outcome.usable for outcome in good)
        self.errors, self.bounds, self.linear, self.deviations, self.covered, self.levels = (
            np.array([getattr(outcome, name) for outcome in good])
            for name in ("error", "bound", "linear", "deviations", "covered", "noise_levels")
        )

    def rmse(self, at: Sequence[int]) -> float:
        """RMS length of the error in some parameters."""
        return float(np.sqrt(np.mean(np.sum(self.errors[:, at] ** 2, axis=1))))

    def bound(self, at: Sequence[int]) -> float:
        """RMS over the trials of the bound of the same."""
        return float(np.sqrt(np.mean(np.sum(self.bounds[:, at], axis=1))))

    def ratio(self, at: Sequence[int]) -> float:
        """RMSE over bound."""
        return self.rmse(at) / self.bound(at)

    def loss(self, at: Sequence[int]) -> float:
        """The same with the scatter removed that is common with errors which reach the bound, on the same noise."""
        excess = np.mean(np.sum(self.errors[:, at] ** 2 - self.linear[:, at] ** 2, axis=1))
        return float(np.sqrt(max(0.0, 1 + excess / self.bound(at) ** 2)))

    def stated(self, at: Sequence[int]) -> float:
        """RMS of the returned standard deviations over the bound."""
        return float(np.sqrt(np.mean(np.sum(self.deviations[:, at] ** 2, axis=1)))) / self.bound(at)

    def coverage(self, at: int) -> float:
        """Percentage of the 95 % intervals that contain the truth."""
        return 100 * float(np.mean(self.covered[:, at]))


def settings(lens: int, noise: Noise | None = None, flags: int = 0) -> cah.RefineParams:
    """RefineParams; `noise` = the levels given, None = to be estimated."""
    params = cah.RefineParams()
    params.lensModel, params.flags = lens, flags
    if noise is not None:
        params.pointSigma = noise.point_px
        params.stripeSigma = noise.segment_px(SEGMENT_POINTS)
        params.robotTranslationSigma, params.robotRotationSigma = noise.translation, noise.rotation
    return params


def calibrate(
    world: World,
    recording: Recording,
    params: cah.RefineParams,
    start: Sequence[Array | None] = (None,) * 5,
    object_points: Array | None = None,
) -> Estimate:
    """refineHandEye on a recording; `start` is K, D, R, t, light plane, None = none."""
    found = cah.refineHandEye(
        recording.R_gripper2base,
        recording.t_gripper2base,
        recording.image_points,
        *start,
        stripePoints=recording.stripe_points or None,
        stripeViews=recording.stripe_views or None,
        surfaceIds=recording.surface_ids or None,
        objectPoints=object_points,
        params=params,
    )
    _, K, D, R, t, plane, summary = found
    return Estimate(error_of(world, K, D, R, t, plane), (K, D, R, t, plane), summary)


def error_of(world: World, K: Array, D: Array, R: Array, t: Array, plane: Array | None) -> Array:
    """True - estimated (20), in the order of NAMES; the rotation's is log(true R R^T)."""
    dK = world.camera_matrix - K
    lens = world.dist_coeffs - np.resize(np.ravel(D), 5) if np.size(D) == 5 else world.dist_coeffs
    turn = Rotation.from_matrix(world.R_cam2gripper @ R.T).as_rotvec()
    light = np.zeros(4)
    if world.stripes is not None and plane is not None:
        light = world.stripes.light_plane - np.ravel(plane)
    camera = [dK[0, 0], dK[1, 1], dK[0, 2], dK[1, 2], dK[0, 1]]
    return np.concatenate([camera, lens, turn, world.t_cam2gripper - np.ravel(t), light])


def covered(error: Array, estimate: Estimate) -> Array:
    """Which of the 95 % intervals (20) contain the truth."""
    K, D, _, t, plane = estimate.calibration
    light = np.zeros(4) if plane is None else np.ravel(plane)
    value = np.concatenate(
        [[K[0, 0], K[1, 1], K[0, 2], K[1, 2], K[0, 1]], np.ravel(D), np.zeros(3), np.ravel(t), light]
    )
    interval = np.asarray(estimate.summary.intervals95)
    truth = value + error
    return np.asarray((interval[:, 0] <= truth) & (truth <= interval[:, 1]), dtype=np.float64)


def judge(world: World, recording: Recording, params: cah.RefineParams, best: tuple[Array, Array]) -> Outcome:
    """One call and what came out beside the `best` (fisher.linear_solution); a refused one has NaN and its text."""
    variances = np.diag(best[0])
    try:
        found = calibrate(world, recording, params)
    except cah.error as error:
        nothing = np.full(len(NAMES), np.nan)
        return Outcome(nothing, variances, best[1], nothing, nothing, np.full(4, np.nan), -1, np.nan, False, str(error))
    summary = found.summary
    return Outcome(
        found.error,
        variances,
        best[1],
        np.ravel(summary.standardDeviations),
        covered(found.error, found),
        np.asarray(summary.noiseLevels)[:, 0],
        summary.lensModel,
        summary.chiSquarePValue,
        summary.usable,
    )


def trial(case: Case, seed: int, number: int) -> tuple[Outcome, Outcome]:
    """One world and recording, calibrated with the noise levels given, and with noise levels estimated."""
    rng = np.random.default_rng([seed, number])
    world = case.world(rng)
    recording = world.record(rng, case.noise)
    best = linear_solution(world, case.noise, case.free, recording)
    given, estimated = settings(case.lens_model, case.noise), settings(case.lens_model)
    return judge(world, recording, given, best), judge(world, recording, estimated, best)
