# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Kinematics of six-axis arms: forward, inverse with joint limits, and checks along a straight path.

Poses are 4 x 4 flange-to-base matrices in metres; joint values are radians as the controller shows them.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation, Slerp

Array = NDArray[np.float64]

_STARTS = 96
_ITERATIONS = 60
_ITERATIONS_FROM_NEAR = 15  # a path takes five to eight
_FARTHEST = 100.0  # metres: any straight line to there has few enough samples
_CONVERGED = 1e-9  # metres and radians, before the final polish
_LARGEST_STEP = 0.3  # rad, between two samples of a path


class UnreachableError(ValueError):
    """The arm cannot take the pose or follow the path; the text says which joint or length is in the way."""


@dataclass(frozen=True)
class SerialArm:
    """An arm given by standard Denavit-Hartenberg parameters; theta = sign * q + offset.

    a, d: metres; alpha, offset, lower, upper: radians, six values each. margin: distance (rad) kept from every limit;
    smallest_sigma: least singular value of the Jacobian (lengths divided by `reach`) that is accepted.
    """

    name: str
    a: tuple[float, ...]
    d: tuple[float, ...]
    alpha: tuple[float, ...]
    lower: tuple[float, ...]
    upper: tuple[float, ...]
    reach: float
    sign: tuple[float, ...] = (1.0,) * 6
    offset: tuple[float, ...] = (0.0,) * 6
    margin: float = np.radians(3.0)
    smallest_sigma: float = 0.04

    def frames(self, q: Array) -> Array:
        """Return the poses (..., 7, 4, 4) of base and six links for joint values q (..., 6)."""
        theta = np.asarray(self.sign) * q + np.asarray(self.offset)
        ca, sa = np.cos(self.alpha), np.sin(self.alpha)
        ct, st = np.cos(theta), np.sin(theta)
        link = np.zeros((*theta.shape, 4, 4))
        link[..., 0, 0], link[..., 0, 1], link[..., 0, 2], link[..., 0, 3] = ct, -st * ca, st * sa, self.a * ct
        link[..., 1, 0], link[..., 1, 1], link[..., 1, 2], link[..., 1, 3] = st, ct * ca, -ct * sa, self.a * st
        link[..., 2, 1], link[..., 2, 2], link[..., 2, 3], link[..., 3, 3] = sa, ca, self.d, 1.0
        out = np.empty((*theta.shape[:-1], 7, 4, 4))
        out[..., 0, :, :] = np.eye(4)
        for i in range(6):
            out[..., i + 1, :, :] = out[..., i, :, :] @ link[..., i, :, :]
        return out

    def forward(self, q: Array) -> Array:
        """Return the flange poses (..., 4, 4) for joint values q (..., 6)."""
        return np.asarray(self.frames(np.asarray(q, dtype=np.float64))[..., 6, :, :])

    def jacobian(self, q: Array) -> Array:
        """Return the geometric Jacobian (..., 6, 6) in the base frame: velocity of the flange, then rotation rate."""
        frames = self.frames(np.asarray(q, dtype=np.float64))
        axis = frames[..., :6, :3, 2]
        arm = frames[..., 6:, :3, 3] - frames[..., :6, :3, 3]
        columns = np.concatenate([np.cross(axis, arm), axis], axis=-1) * np.asarray(self.sign)[:, None]
        return np.asarray(np.swapaxes(columns, -1, -2))

    def sigma_min(self, q: Array) -> Any:
        """Return the smallest singular value of the Jacobian with lengths in units of `reach`: 0 = singular."""
        scaled = self.jacobian(q)
        scaled[..., :3, :] /= self.reach
        return np.linalg.svd(scaled, compute_uv=False)[..., -1]

    def limit_margin(self, q: Array) -> Array:
        """Return the distance (..., 6) of each joint from its nearer limit, radians, negative beyond it."""
        return np.minimum(np.asarray(q) - self.lower, np.asarray(self.upper) - q)

    def inverse_all(self, pose: Array) -> Array:
        """Return all joint solutions (S, 6) found for a flange pose, joints wrapped to the middle of their range."""
        start = np.random.default_rng(0).uniform(
            np.maximum(self.lower, -np.pi), np.minimum(self.upper, np.pi), (_STARTS, 6)
        )
        q, error = self._solve(pose, start)
        q = self._wrapped(q[error < _CONVERGED])
        kept: list[Array] = []
        for candidate in q:
            if all(np.abs(np.exp(1j * candidate) - np.exp(1j * other)).max() > 1e-5 for other in kept):
                kept.append(candidate)
        return np.array(kept).reshape(-1, 6)

    def inverse(self, pose: Array, near: Array | None = None) -> Array:
        """Return joint values (6,) for a flange pose: nearest to `near`, else farthest from limits and singularities.

        Raises UnreachableError when no solution keeps `margin` to the limits and `smallest_sigma`.
        """
        solutions = self.inverse_all(_checked(pose))
        if not len(solutions):
            raise UnreachableError(self._out_of_reach(pose))
        if near is not None:
            solutions = self._turned_near(solutions, near)
        allowed = solutions[self._usable(solutions)]
        if not len(allowed):
            raise UnreachableError(self._nearest_refusal(solutions))
        if near is not None:
            return np.asarray(allowed[np.argmin(np.abs(allowed - near).max(axis=1))])
        return np.asarray(allowed[np.argmax(self._comfort(allowed))])

    def follow(self, start: Array, pose: Array, step_m: float = 0.005, step_deg: float = 1.0) -> Array:
        """Return joint values (N, 6) along the straight line (slerp in rotation) from joints `start` to a flange pose.

        Raises UnreachableError when a sample leaves the limits, comes near a singularity or jumps over 0.3 rad.
        """
        q = np.asarray(start, dtype=np.float64)
        samples = straight_line(self.forward(q), _checked(pose), step_m, step_deg)
        path, error = self._solve(samples, np.tile(q, (len(samples), 1)), _ITERATIONS_FROM_NEAR)
        if error.max() > _CONVERGED or np.abs(np.diff(path, axis=0)).max(initial=0) > _LARGEST_STEP:
            return self._follow_one_by_one(samples, q)
        for i in np.flatnonzero(~self._usable(path[1:]))[:1] + 1:
            raise UnreachableError(f"{self._nearest_refusal(path[i][None])} ({_on_the_way(i, samples)})")
        return path

    def _follow_one_by_one(self, samples: Array, q: Array) -> Array:
        """Each sample from the joints of the one before: where all at once from the first do not stay together."""
        path = [q]
        for i, sample in enumerate(samples[1:], start=1):
            solution, error = self._solve(sample, q[None])
            where = _on_the_way(i, samples)
            if error[0] > _CONVERGED or np.abs(solution[0] - q).max() > _LARGEST_STEP:
                raise UnreachableError(f"{self.name}: no continuous joint motion {where}: {self._out_of_reach(sample)}")
            q = solution[0]
            if not self._usable(q[None])[0]:
                raise UnreachableError(f"{self._nearest_refusal(q[None])} ({where})")
            path.append(q)
        return np.array(path)

    def _solve(self, pose: Array, q: Array, iterations: int = _ITERATIONS) -> tuple[Array, Array]:
        """Damped Gauss-Newton from all rows of q at once, to one pose or a pose for each row.

        Returns joints and the largest remaining error.
        """
        weight = np.array([1 / self.reach] * 3 + [1.0] * 3)
        for _ in range(iterations):
            error = weight * _pose_error(pose, self.forward(q))
            size = np.linalg.norm(error, axis=-1)
            if size.max() < 1e-14:
                break
            J = weight[:, None] * self.jacobian(q)
            Jt = np.swapaxes(J, -1, -2)
            normal = Jt @ J + (1e-3 * np.minimum(size, 1.0) ** 2)[:, None, None] * np.eye(6) + 1e-15 * np.eye(6)
            step = np.linalg.solve(normal, Jt @ error[..., None])[..., 0]
            q = q + step * np.minimum(1.0, 0.6 / np.maximum(np.abs(step).max(axis=-1, keepdims=True), 1e-12))
        return q, np.abs(_pose_error(pose, self.forward(q))).max(axis=-1)

    def _wrapped(self, q: Array) -> Array:
        middle = (np.asarray(self.lower) + self.upper) / 2
        return np.asarray(q - 2 * np.pi * np.round((q - middle) / (2 * np.pi)))

    def _turned_near(self, q: Array, near: Array) -> Array:
        """Add whole turns where the limits allow it, so that no joint unwinds without need."""
        turned = q + 2 * np.pi * np.round((near - q) / (2 * np.pi))
        return np.asarray(np.where((turned >= self.lower) & (turned <= self.upper), turned, q))

    def _usable(self, q: Array) -> NDArray[np.bool_]:
        within = self.limit_margin(q).min(axis=-1) >= self.margin
        return np.asarray(within & (self.sigma_min(q) >= self.smallest_sigma))

    def _comfort(self, q: Array) -> Array:
        return np.asarray(np.minimum(self.limit_margin(q).min(axis=-1), 5 * self.sigma_min(q)))

    def _out_of_reach(self, pose: Array) -> str:
        shoulder = np.array([0.0, 0.0, self.d[0]])
        wrist = pose[:3, 3] - self.d[5] * pose[:3, 2]
        distance = float(np.linalg.norm(wrist - shoulder))
        return (
            f"{self.name}: the flange pose at {_mm(pose[:3, 3])} mm cannot be taken: its wrist is "
            f"{1000 * distance:.0f} mm from the shoulder, reach is {1000 * self.reach:.0f} mm"
        )

    def _nearest_refusal(self, solutions: Array) -> str:
        best = solutions[np.argmax(self.limit_margin(solutions).min(axis=-1))]
        joint = int(np.argmin(self.limit_margin(best)))
        if self.limit_margin(best)[joint] < self.margin:
            low, high, value = np.degrees([self.lower[joint], self.upper[joint], best[joint]])
            return (
                f"{self.name}: joint {joint + 1} would be at {value:.1f} deg; its limits are {low:.0f} to "
                f"{high:.0f} deg, kept with a margin of {np.degrees(self.margin):.0f} deg"
            )
        sigma = float(self.sigma_min(best))
        return (
            f"{self.name}: the pose is near a singularity: smallest singular value {sigma:.3f}, "
            f"needed {self.smallest_sigma:.3f} or more"
        )


def straight_line(start: Array, end: Array, step_m: float, step_deg: float) -> Array:
    """Return poses (N, 4, 4) from start to end in steps of at most `step_m` and `step_deg`, both ends included."""
    turn = Rotation.from_matrix(np.stack([start[:3, :3], end[:3, :3]]))
    angle = float(np.degrees((turn[0].inv() * turn[1]).magnitude()))
    length = float(np.linalg.norm(end[:3, 3] - start[:3, 3]))
    fraction = np.linspace(0.0, 1.0, max(1, int(np.ceil(max(length / step_m, angle / step_deg)))) + 1)
    out = np.tile(np.eye(4), (len(fraction), 1, 1))
    out[:, :3, :3] = Slerp([0.0, 1.0], turn)(fraction).as_matrix()
    out[:, :3, 3] = start[:3, 3] + fraction[:, None] * (end[:3, 3] - start[:3, 3])
    return out


def arm(name: str) -> SerialArm:
    """Return the arm called `name`, a key of ARMS; ValueError where there is none."""
    if name not in ARMS:
        raise ValueError(f"name: needs one of {sorted(ARMS)}, got {name!r}")
    return ARMS[name]


def _pose_error(target: Array, pose: Array) -> Array:
    turn = Rotation.from_matrix(target[..., :3, :3] @ np.swapaxes(pose[..., :3, :3], -1, -2)).as_rotvec()
    return np.concatenate([target[..., :3, 3] - pose[..., :3, 3], turn], axis=-1)


def _on_the_way(i: int, samples: Array) -> str:
    return f"on the way, {100 * i / (len(samples) - 1):.0f} % done"


def _checked(pose: Array) -> Array:
    pose = np.asarray(pose, dtype=np.float64)
    if pose.shape != (4, 4) or not np.isfinite(pose).all():
        raise ValueError(f"pose: needs a finite 4 x 4 matrix, got shape {pose.shape}")
    far = np.abs(pose[:3, 3]).max()
    if far > _FARTHEST:
        raise ValueError(f"pose: needs a position within {_FARTHEST:g} m of the base, got {far:.3g} m")
    off = np.abs(pose[:3, :3].T @ pose[:3, :3] - np.eye(3)).max()
    if off > 1e-6 or np.linalg.det(pose[:3, :3]) < 0:
        raise ValueError(f"pose: needs a rotation (R^T R = I to 1e-6, det = +1), got an error of {off:.2g}")
    return pose


def _mm(position: Array) -> str:
    return "(" + ", ".join(f"{1000 * x:.0f}" for x in position) + ")"


def _rad(*degrees: float) -> tuple[float, ...]:
    return tuple(float(x) for x in np.radians(degrees))


def _ur_e(name: str, a: tuple[float, float], d: tuple[float, float, float, float], reach: float) -> SerialArm:
    """An arm of Universal Robots from the parameters of its links that are not zero."""
    return SerialArm(
        name=name,
        a=(0, *a, 0, 0, 0),
        d=(d[0], 0, 0, *d[1:]),
        alpha=_rad(90, 0, 0, 90, -90, 0),
        lower=_rad(*[-360] * 6),
        upper=_rad(*[360] * 6),
        reach=reach,
    )


ARMS = {
    # Universal Robots, "DH parameters for calculations of kinematics and dynamics".
    "ur5e": _ur_e("UR5e", (-0.425, -0.3922), (0.1625, 0.1333, 0.0997, 0.0996), 0.85),
    "ur3e": _ur_e("UR3e", (-0.24355, -0.2132), (0.15185, 0.13105, 0.08535, 0.0921), 0.5),
    "ur10e": _ur_e("UR10e", (-0.6127, -0.57155), (0.1807, 0.17415, 0.11985, 0.11655), 1.3),
    "ur16e": _ur_e("UR16e", (-0.4784, -0.36), (0.1807, 0.17415, 0.11985, 0.11655), 0.9),
    # DENSO drawing 001050_1: 280 / 210 / 210 with 75 mm elbow offset / 70 mm. Joint zeros follow the usual reading
    # (all zero but J3 = 90: upper arm up, forearm level) and were not verified on a controller.
    "denso_vp6242": SerialArm(
        name="DENSO VP-6242",
        a=(0, 0.21, 0.075, 0, 0, 0),
        d=(0.28, 0, 0, 0.21, 0, 0.07),
        alpha=_rad(90, 0, 90, -90, 90, 0),
        lower=_rad(-160, -120, 20, -160, -120, -360),
        upper=_rad(160, 120, 160, 160, 120, 360),
        reach=0.432,
        sign=(1, -1, -1, 1, -1, 1),
        offset=_rad(0, 90, 90, 0, 0, 0),
    ),
}
"""Known arms by name."""
