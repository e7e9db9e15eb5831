# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""calibrateHandEye against cv2, the refined method against scipy, and the wheel's own conversions."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt
import pytest
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

import cv_active_handeye as cah

Array = npt.NDArray[np.float64]
METHODS = ("TSAI", "PARK", "HORAUD", "ANDREFF", "DANIILIDIS")
CAMERA_NOISE, ROBOT_NOISE = (0.002, 0.005), (0.001, 0.001)

needs_cv2_hand_eye = pytest.mark.skipif(
    not hasattr(cv2, "calibrateHandEye"), reason="this cv2 has no calibrateHandEye (OpenCV 5.0.0)"
)


@dataclass(frozen=True)
class Poses:
    """gripper2base (V, 4, 4), target2cam (V, 4, 4) and the true cam2gripper (4, 4)."""

    gripper2base: Array
    target2cam: Array
    cam2gripper: Array

    @property
    def arguments(self) -> tuple[Array, Array, Array, Array]:
        """As calibrateHandEye takes them."""
        G, C = self.gripper2base, self.target2cam
        return G[:, :3, :3], G[:, :3, 3], C[:, :3, :3], C[:, :3, 3]

    @property
    def lists(self) -> tuple[list[Array], list[Array], list[Array], list[Array]]:
        """As cv2's stubs want them."""
        R, t, R_target, t_target = self.arguments
        return list(R), list(t), list(R_target), list(t_target)


def calibrate(arguments: Sequence[Any], method: int) -> tuple[Array, Array]:
    R, t, R_target, t_target = arguments
    return cah.calibrateHandEye(R, t, R_target, t_target, method=method)


def pose(rotation: Array, translation: Array) -> Array:
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = Rotation.from_rotvec(rotation).as_matrix(), translation
    return T


def disturbed(rng: np.random.Generator, T: Array, noise: tuple[float, float]) -> Array:
    result = pose(rng.normal(0, noise[0], 3), np.zeros(3)) @ T
    result[:3, 3] = T[:3, 3] + rng.normal(0, noise[1], 3)
    return np.asarray(result, dtype=np.float64)


def random_poses(
    seed: int, views: int = 10, camera: tuple[float, float] = (0, 0), robot: tuple[float, float] = (0, 0)
) -> Poses:
    rng = np.random.default_rng(seed)
    X, target = pose(rng.normal(0, 0.5, 3), rng.normal(0, 0.2, 3)), pose(rng.normal(0, 1, 3), rng.normal(0, 1, 3))
    gripper = [pose(rng.normal(0, 0.4, 3), rng.normal(0, 0.5, 3)) for _ in range(views)]
    seen = [disturbed(rng, np.linalg.inv(T @ X) @ target, camera) for T in gripper]
    return Poses(np.array([disturbed(rng, T, robot) for T in gripper]), np.array(seen), X)


def method_of(name: str) -> int:
    return int(getattr(cah, f"CALIB_HAND_EYE_{name}"))


@needs_cv2_hand_eye
@pytest.mark.parametrize("name", METHODS)
@pytest.mark.parametrize(
    ("camera", "robot"), [((0, 0), (0, 0)), (CAMERA_NOISE, ROBOT_NOISE), ((0.02, 0.05), (0.01, 0.01))]
)
def test_closed_forms_are_those_of_opencv(name: str, camera: tuple[float, float], robot: tuple[float, float]) -> None:
    assert method_of(name) == getattr(cv2, f"CALIB_HAND_EYE_{name}")
    for seed in range(20):
        poses = random_poses(seed, 8, camera, robot)
        R, t = calibrate(poses.arguments, method_of(name))
        R_cv2, t_cv2 = cv2.calibrateHandEye(*poses.lists, method=method_of(name))
        np.testing.assert_allclose(R, R_cv2, atol=1e-9)
        np.testing.assert_allclose(t, t_cv2, atol=1e-9)


@needs_cv2_hand_eye
def test_the_signature_is_that_of_opencv() -> None:
    documented = re.match(r"calibrateHandEye\((.*)\) -> (.*)", cv2.calibrateHandEye.__doc__ or "")
    ours = re.match(r"calibrateHandEye\((.*)\) ->", cah.calibrateHandEye.__doc__ or "")
    assert documented
    assert ours
    names = [name.strip() for name in re.sub(r"[\[\]]", "", documented[1]).split(",")]
    assert [argument.split(":")[0].strip() for argument in re.split(r", (?=\w+:)", ours[1])] == names
    assert [name.strip() for name in documented[2].split(",")] == ["R_cam2gripper", "t_cam2gripper"]
    assert cah.CALIB_HAND_EYE_TSAI == 0
    arguments = random_poses(1, camera=CAMERA_NOISE).arguments
    by_default, tsai = cah.calibrateHandEye(*arguments), cah.calibrateHandEye(*arguments, method=0)
    np.testing.assert_array_equal(by_default[1], tsai[1])


def test_outputs_may_be_given_as_in_opencv() -> None:
    arguments = random_poses(2).arguments
    R, t = np.zeros((3, 3)), np.zeros((3, 1))
    returned = cah.calibrateHandEye(*arguments, R, t, cah.CALIB_HAND_EYE_PARK)
    assert returned[0] is R
    assert returned[1] is t
    np.testing.assert_allclose(t, random_poses(2).cam2gripper[:3, 3:], atol=1e-9)


@pytest.mark.parametrize("wrong", [4, np.zeros((3, 3), np.float32), np.zeros(9), [[1, 0, 0], [0, 1, 0], [0, 0, 1]]])
def test_a_method_in_the_place_of_an_output_is_refused(wrong: object) -> None:
    with pytest.raises(cah.error, match=r"R_cam2gripper: is an output; .*give method by keyword"):
        cah.calibrateHandEye(*random_poses(2).arguments, wrong)  # type: ignore[arg-type]


LAYOUTS: dict[str, Callable[[Array], object]] = {
    "stacked": lambda a: a,
    "list": list,
    "tuple": tuple,
    "nested lists": lambda a: a.tolist(),
    "columns": lambda a: a[:, :, None] if a.ndim == 2 else a,
    "rows": lambda a: a[:, None, :] if a.ndim == 2 else a,
    "rotation vectors": lambda a: Rotation.from_matrix(a).as_rotvec() if a.ndim == 3 else a,
    "Fortran order": np.asfortranarray,
    "read only": lambda a: np.frombuffer(a.tobytes()).reshape(a.shape),
}


@pytest.mark.parametrize("layout", LAYOUTS)
@pytest.mark.parametrize("method", range(6))
def test_every_layout_gives_the_same(layout: str, method: int) -> None:
    arguments = random_poses(3, camera=CAMERA_NOISE).arguments
    R, t = cah.calibrateHandEye(*arguments, method=method)
    assert R.shape == (3, 3)
    assert t.shape == (3, 1)
    again = calibrate([LAYOUTS[layout](a) for a in arguments], method)
    np.testing.assert_allclose(again[0], R, atol=1e-12)
    np.testing.assert_allclose(again[1], t, atol=1e-11)


@pytest.mark.parametrize("method", range(6))
def test_float32_is_read(method: int) -> None:
    poses = random_poses(3)
    R, t = calibrate([a.astype(np.float32) for a in poses.arguments], method)
    np.testing.assert_allclose(R, poses.cam2gripper[:3, :3], atol=1e-5)
    np.testing.assert_allclose(t, poses.cam2gripper[:3, 3:], atol=1e-5)


def scipy_solution(poses: Poses, sigmas: tuple[float, float, float, float]) -> tuple[Array, Array]:
    """cam2gripper with every reported pose corrected by unknown errors of its own, and the covariance."""
    target_rotation, target_translation, robot_rotation, robot_translation = sigmas
    views = len(poses.gripper2base)
    start = poses.cam2gripper
    target_start = poses.gripper2base[0] @ start @ poses.target2cam[0]

    def moved(T: Array, step: Array) -> Array:
        return pose(step[:3], np.zeros(3)) @ T + np.pad(step[3:, None], ((0, 1), (3, 0)))

    def residuals(x: Array) -> Array:
        X, target = moved(start, x[:6]), moved(target_start, x[6:12])
        parts = [x[12:]]
        for view in range(views):
            error = x[12 + 6 * view : 18 + 6 * view] * np.repeat([robot_rotation, robot_translation], 3)
            seen = np.linalg.inv(moved(poses.gripper2base[view], error) @ X) @ target
            turn = Rotation.from_matrix(seen[:3, :3] @ poses.target2cam[view][:3, :3].T).as_rotvec()
            parts += [turn / target_rotation, (seen[:3, 3] - poses.target2cam[view][:3, 3]) / target_translation]
        return np.concatenate(parts)

    found = least_squares(residuals, np.zeros(12 + 6 * views), x_scale="jac", xtol=1e-14, ftol=1e-14, gtol=1e-14)
    jacobian = np.asarray(found.jac, dtype=np.float64)
    return moved(start, found.x[:6]), np.asarray(np.linalg.inv(jacobian.T @ jacobian)[:6, :6], dtype=np.float64)


def params_of(sigmas: tuple[float, float, float, float]) -> cah.HandEyeParams:
    params = cah.HandEyeParams()
    params.targetRotationSigma, params.targetTranslationSigma = sigmas[:2]
    params.robotRotationSigma, params.robotTranslationSigma = sigmas[2:]
    return params


@pytest.mark.parametrize("robot", [(1e-9, 1e-9), ROBOT_NOISE])
def test_refined_is_the_optimum_that_scipy_finds(robot: tuple[float, float]) -> None:
    poses = random_poses(5, 6, CAMERA_NOISE, robot)
    sigmas = (*CAMERA_NOISE, *robot)
    deviation, R, t, summary = cah.calibrateHandEyeExtended(*poses.arguments, params=params_of(sigmas))
    X, covariance = scipy_solution(poses, sigmas)
    sigma = summary.standardDeviations.ravel()
    # scipy also lets the arm, which weights the robot's errors, follow the residuals.
    tolerance = 1e-4 if robot[0] < 1e-6 else 0.1
    turn = Rotation.from_matrix(X[:3, :3] @ R.T).as_rotvec()
    np.testing.assert_array_less(np.abs(np.append(turn, X[:3, 3] - t.ravel())) / sigma, tolerance)
    np.testing.assert_allclose(summary.covariance, covariance, atol=2e-2 * sigma.max() ** 2)
    assert deviation == pytest.approx(np.sqrt(np.trace(covariance[3:, 3:])), rel=1e-2)
    assert summary.usable, summary.message
    assert summary.noiseLevels[:, 0] == pytest.approx(sigmas)


def test_refined_names_a_swapped_pair_and_is_right_without_it() -> None:
    poses = random_poses(6, 12, CAMERA_NOISE, ROBOT_NOISE)
    order = np.arange(12)
    order[[2, 7]] = order[[7, 2]]
    deviation, _, t, summary = cah.calibrateHandEyeExtended(
        *replace(poses, target2cam=poses.target2cam[order]).arguments
    )
    assert summary.rejectedViews == [2, 7]
    assert "2 of 12 views contradict the others" in summary.message
    assert [text.split(":")[0] for text in summary.culprits] == ["view 2", "view 7"]
    assert np.linalg.norm(t.ravel() - poses.cam2gripper[:3, 3]) < 4 * deviation
    assert summary.residuals.shape == (12, 6)
    assert summary.viewPValues.shape == (12, 2)


def spoilt(poses: Poses, which: int, view: int, value: float) -> list[Array]:
    arguments = [a.copy() for a in poses.arguments]
    arguments[which][view] *= value
    return arguments


BAD: dict[str, tuple[Callable[[Poses], list[object]], int, str]] = {
    "NaN": (lambda p: [*spoilt(p, 3, 1, np.nan)], -5, r"t_target2cam\[1\]: needed finite numbers"),
    "scaled rotation": (lambda p: [*spoilt(p, 0, 2, 2)], -5, r"R_gripper2base\[2\]: needed a rotation"),
    "left-handed": (lambda p: [*spoilt(p, 2, 0, -1)], -5, r"R_target2cam\[0\]: .*left-handed"),
    "fewer translations": (lambda p: [*p.arguments[:3], p.arguments[3][:-1]], -201, r"t_target2cam: .*given 9"),
    "fewer poses of the target": (
        lambda p: [a[: 9 + (k < 2)] for k, a in enumerate(p.arguments)],
        -201,
        "R_target2cam",
    ),
    "two views": (lambda p: [a[:2] for a in p.arguments], -201, r"R_gripper2base: needed at least 3 views, given 2"),
    "no list": (lambda p: [None, *p.arguments[1:]], -5, "R_gripper2base: needed a sequence"),
    "quaternions": (lambda p: [np.ones((10, 4)), *p.arguments[1:]], -201, r"R_gripper2base\[0\]: .*rotation vector"),
    "metres and millimetres": (
        lambda p: [a * (1000 if k == 1 else 1) for k, a in enumerate(p.arguments)],
        -5,
        "millimetres",
    ),
    "no motion": (lambda p: [np.repeat(a[:1], 10, axis=0) for a in p.arguments], -7, "no motion at all"),
}


@pytest.mark.parametrize("case", BAD)
@pytest.mark.parametrize("method", range(6))
def test_bad_input_is_refused_by_name(case: str, method: int) -> None:
    spoil, code, text = BAD[case]
    with pytest.raises(cah.error, match=text) as caught:
        calibrate(spoil(random_poses(4)), method)
    assert caught.value.code == code


@pytest.mark.parametrize("method", [-1, 6, 99])
def test_unknown_methods_are_refused(method: int) -> None:
    with pytest.raises(cah.error, match=f"method: needed .*given {method}") as caught:
        cah.calibrateHandEye(*random_poses(4).arguments, method=method)
    assert caught.value.code == -211


def test_inputs_are_left_as_they_were() -> None:
    arguments = random_poses(7, camera=CAMERA_NOISE).arguments
    before = [a.copy() for a in arguments]
    for method in range(6):
        cah.calibrateHandEye(*arguments, method=method)
    for given, kept in zip(arguments, before, strict=True):
        np.testing.assert_array_equal(given, kept)
