# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The camera: pinhole with OpenCV's distortion, optics blur, sensor."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from .parts import Array


@dataclass(frozen=True)
class Camera:
    """Exact camera model of OpenCV: K (3, 3) with skew, D = (k1, k2, p1, p2, k3); pixel centres at integers."""

    width: int
    height: int
    K: Array
    D: Array

    def project(self, points: Array) -> Array:
        """Return pixels (N, 2) of points (N, 3) in the camera frame (metres, Z > 0)."""
        distorted = self._distort(points[:, :2] / points[:, 2:])
        return distorted @ self.K[:2, :2].T + self.K[:2, 2]

    def rays(self, pixels: Array) -> Array:
        """Return rays (N, 3) = (X/Z, Y/Z, 1) of distorted pixels (N, 2), inverted to 1e-12."""
        y = (pixels[:, 1] - self.K[1, 2]) / self.K[1, 1]
        x = (pixels[:, 0] - self.K[0, 2] - self.K[0, 1] * y) / self.K[0, 0]
        target = np.stack([x, y], axis=1)
        ideal = target.copy()
        for _ in range(50 if self.D.any() else 0):
            step = np.linalg.solve(self._jacobian(ideal), (target - self._distort(ideal))[..., None])[..., 0]
            ideal += step
            if np.abs(step).max(initial=0.0) < 1e-13:
                break
        if not self._is_solution(ideal, target):
            raise ValueError(f"distortion: needs a model that can be inverted over the image, got {self.D.tolist()}")
        return np.column_stack([ideal, np.ones(len(ideal))])

    def inside(self, pixels: Array) -> NDArray[np.bool_]:
        """Return which pixels (N, 2) lie in the image."""
        limit = np.array([self.width, self.height]) - 0.5
        return np.asarray(((pixels >= -0.5) & (pixels <= limit)).all(axis=1))

    def _distort(self, ideal: Array) -> Array:
        k1, k2, p1, p2, k3 = self.D
        x, y = ideal.T
        r2 = x * x + y * y
        radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3))
        return np.stack(
            [x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x), y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y],
            axis=1,
        )

    def _is_solution(self, ideal: Array, target: Array) -> bool:
        """Whether `ideal` maps to `target` without a fold of the model before it."""
        axis = np.linalg.eigvals(self._jacobian(ideal)).real
        return bool((axis > 0).all() and np.abs(self._distort(ideal) - target).max(initial=0.0) <= 1e-12)

    def _jacobian(self, ideal: Array) -> Array:
        k1, k2, p1, p2, k3 = self.D
        x, y = ideal.T
        r2 = x * x + y * y
        radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3))
        slope = 2 * (k1 + r2 * (2 * k2 + 3 * r2 * k3))  # d radial / d(r2) * 2
        cross = x * y * slope + 2 * p1 * x + 2 * p2 * y
        return np.stack(
            [
                radial + x * x * slope + 2 * p1 * y + 6 * p2 * x,
                cross,
                cross,
                radial + y * y * slope + 6 * p1 * y + 2 * p2 * x,
            ],
            axis=1,
        ).reshape(-1, 2, 2)


def subpixel_grid(camera: Camera, per_axis: int) -> Array:
    """Return the pixels (H * s * W * s, 2), row by row, of a grid with s = `per_axis` samples per pixel and axis."""
    x = (np.arange(camera.width * per_axis) + 0.5) / per_axis - 0.5
    y = (np.arange(camera.height * per_axis) + 0.5) / per_axis - 0.5
    return np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)


def through_lens(signal: NDArray[np.float32], per_axis: int, blur_px: float) -> NDArray[np.float32]:
    """Return the image (H, W) on the sensor from samples (H * s, W * s): Gaussian blur, then pixel areas."""
    if blur_px > 0:
        sigma = blur_px * per_axis
        signal = cv2.GaussianBlur(signal, (0, 0), sigma, borderType=cv2.BORDER_REPLICATE).astype(np.float32)
    rows, columns = signal.shape
    cells = signal.reshape(rows // per_axis, per_axis, columns // per_axis, per_axis)
    return np.asarray(cells.mean(axis=(1, 3)), dtype=np.float32)


@dataclass(frozen=True)
class Sensor:
    """Photon shot noise, read noise, saturation, quantisation. Signal 1 = full well."""

    full_well_electrons: float
    read_noise_electrons: float
    bit_depth: int

    def expose(
        self, irradiance: NDArray[np.float32], exposure: float, rng: np.random.Generator
    ) -> NDArray[np.uint8] | NDArray[np.uint16]:
        """Return the digital image of an irradiance (1 at `exposure` 1 fills the wells)."""
        electrons = np.maximum(irradiance, 0).astype(np.float64) * exposure * self.full_well_electrons
        noisy = electrons + np.sqrt(electrons) * rng.standard_normal(electrons.shape)
        noisy += self.read_noise_electrons * rng.standard_normal(electrons.shape)
        top = 2**self.bit_depth - 1
        digital = np.clip(np.rint(noisy * (top / self.full_well_electrons)), 0, top)
        return np.asarray(digital, np.uint8) if self.bit_depth == 8 else np.asarray(digital, np.uint16)
