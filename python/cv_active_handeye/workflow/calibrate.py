# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""From a data set to a calibration: open, points, K and R, t, stripes, light plane, result.

Everything that is estimated comes from the C++ functions named in each step; this file only carries data between them.
"""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np

import cv_active_handeye as cah

from ..calibration import (
    CAMERA_PARAMETERS,
    LIGHT_PLANE_PARAMETERS,
    TRANSLATION_PARAMETERS,
    Calibration,
    Rms,
)
from ..config import CalibrationOptions
from ..dataset import Dataset
from ..files import FloatArray
from .evidence import Evidence, StripeSegment, find_points, find_stripes, open_recording
from .reporter import Reporter, Silent

NOISE_PX = 0.5


class _Camera(NamedTuple):
    """Camera and rotation, from `calibrateHandEyeTranslations`."""

    rms: float
    matrix: FloatArray
    distortion: FloatArray | None
    R_cam2gripper: FloatArray
    covariance: FloatArray


class _Position(NamedTuple):
    """Position of the camera, from `calibrateHandEyeRotation`."""

    rms: float
    t_cam2gripper: FloatArray
    covariance: FloatArray


class _LightPlane(NamedTuple):
    rms: float
    plane: FloatArray
    covariance: FloatArray


def calibrate(
    dataset: Dataset | str | Path, options: CalibrationOptions | None = None, reporter: Reporter | None = None
) -> Calibration:
    """Calibrates camera, hand-eye transform and, with laser images, the light plane.

    Raises `cah.error` (with what is missing) or `InsufficientDataError` when the data do not determine the result, and
    `FileFormatError` for a damaged data set.
    """
    return calibrate_with_evidence(dataset, options, reporter)[0]


def calibrate_with_evidence(
    dataset: Dataset | str | Path,
    options: CalibrationOptions | None = None,
    reporter: Reporter | None = None,
    points: FloatArray | None = None,
) -> tuple[Calibration, Evidence]:
    """`calibrate`, and the points and stripes it used, for pictures and reports; `points` replaces `find_points`."""
    options, reporter = options or CalibrationOptions(), reporter or Silent()
    dataset = open_recording(dataset, reporter)
    points = find_points(dataset, options, reporter) if points is None else points
    camera = _calibrate_translations(dataset, points, options, reporter)
    position = _calibrate_rotation(dataset, points, camera, reporter)
    segments = find_stripes(dataset, camera.matrix, camera.distortion, reporter) if options.use_laser else []
    segments = _associate(dataset, segments, points, camera, position, reporter)
    plane = _calibrate_light_plane(dataset, segments, camera, options, reporter)
    result = _assemble(dataset, points, segments, options, camera, position, plane)
    _judge_residuals(result, reporter)
    return result, Evidence(points, tuple(segments))


def _calibrate_translations(
    dataset: Dataset, points: FloatArray, options: CalibrationOptions, reporter: Reporter
) -> _Camera:
    progress = reporter.step("camera matrix and rotation, from the pure translations")
    flags = int(cah.TRANSLATIONS_ZERO_SKEW) * (options.zero_skew and options.camera_matrix is None)
    flags |= int(cah.TRANSLATIONS_SQUARE_PIXELS) * options.square_pixels
    flags |= int(cah.TRANSLATIONS_FIX_K) * (options.camera_matrix is not None)
    methods = {"metric": cah.TRANSLATIONS_METRIC, "foe": cah.TRANSLATIONS_FOE}
    distortion = options.distortion_coefficients
    rms, matrix, R_cam2gripper, covariance = cah.calibrateHandEyeTranslations(
        dataset.R_gripper2base,
        dataset.t_gripper2base,
        points,
        options.camera_matrix,
        distortion,
        method=methods[options.method],
        flags=flags,
        orientationTolerance=options.orientation_tolerance_deg,
    )
    progress(1, 1)
    return _Camera(rms, matrix, distortion, R_cam2gripper, covariance)


def _calibrate_rotation(dataset: Dataset, points: FloatArray, camera: _Camera, reporter: Reporter) -> _Position:
    progress = reporter.step("camera position, from the changes of orientation")
    rms, t_cam2gripper, covariance = cah.calibrateHandEyeRotation(
        dataset.R_gripper2base,
        dataset.t_gripper2base,
        points,
        camera.matrix,
        camera.distortion,
        camera.R_cam2gripper,
    )
    progress(1, 1)
    return _Position(rms, t_cam2gripper, covariance)


def _associate(
    dataset: Dataset,
    segments: list[StripeSegment],
    points: FloatArray,
    camera: _Camera,
    position: _Position,
    reporter: Reporter,
) -> list[StripeSegment]:
    """Says which segments lie on the same plane: from the data set where it is written there, else from the tracks."""
    known = [dataset.views[segment.view].surface_id for segment in segments]
    if not segments or None not in known:
        return [StripeSegment(s.view, s.points, k) for s, k in zip(segments, known, strict=True) if k is not None]
    progress = reporter.step(f"finding the surfaces of {len(segments)} stripe segments")
    surfaces, _ = cah.associateStripes(
        dataset.R_gripper2base,
        dataset.t_gripper2base,
        [segment.points for segment in segments],
        [segment.view for segment in segments],
        points,
        camera.matrix,
        camera.distortion,
        camera.R_cam2gripper,
        position.t_cam2gripper,
    )
    progress(1, 1)
    return [StripeSegment(s.view, s.points, int(k)) for s, k in zip(segments, surfaces.reshape(-1), strict=True)]


def _calibrate_light_plane(
    dataset: Dataset, segments: list[StripeSegment], camera: _Camera, options: CalibrationOptions, reporter: Reporter
) -> _LightPlane | None:
    if not segments:
        if options.use_laser:
            reporter.note("no light plane: the data set has no laser image that shows a stripe")
        return None
    progress = reporter.step(f"light plane, from {len(segments)} stripe segments")
    rms, plane, covariance = cah.calibrateLightPlane(
        dataset.R_gripper2base,
        dataset.t_gripper2base,
        [segment.points for segment in segments],
        [segment.view for segment in segments],
        [segment.surface for segment in segments],
        camera.matrix,
        camera.distortion,
        camera.R_cam2gripper,
        orientationTolerance=options.orientation_tolerance_deg,
    )
    progress(1, 1)
    return _LightPlane(rms, plane, covariance)


def _assemble(
    dataset: Dataset,
    points: FloatArray,
    segments: list[StripeSegment],
    options: CalibrationOptions,
    camera: _Camera,
    position: _Position,
    plane: _LightPlane | None,
) -> Calibration:
    seen = np.isfinite(points).all(axis=2)
    names = CAMERA_PARAMETERS + TRANSLATION_PARAMETERS + (LIGHT_PLANE_PARAMETERS if plane else ())
    blocks = [camera.covariance, position.covariance] + ([plane.covariance] if plane else [])
    return Calibration(
        software_version=cah.__version__,
        dataset_sha256=dataset.sha256(),
        constraints=options.constraints(),
        image_width=dataset.camera.width,
        image_height=dataset.camera.height,
        camera_matrix=camera.matrix,
        distortion_coefficients=np.zeros(5) if camera.distortion is None else camera.distortion,
        R_cam2gripper=camera.R_cam2gripper,
        t_cam2gripper=position.t_cam2gripper,
        light_plane=plane.plane if plane else None,
        parameter_names=names,
        covariance=_block_diagonal(blocks),
        rms=Rms(translations_px=camera.rms, rotation_px=position.rms, light_plane_px=plane.rms if plane else None),
        views=len(dataset),
        points=int((seen.sum(axis=0) > 0).sum()),
        observations=int(seen.sum()),
        stripe_segments=len(segments),
    )


def _judge_residuals(result: Calibration, reporter: Reporter) -> None:
    """Residuals far above what a point's position is good for mean that the model is wrong somewhere; say so."""
    steps = {"translations": result.rms.translations_px, "turns": result.rms.rotation_px}
    large = [f"{name} {rms:.2f} px" for name, rms in steps.items() if rms > NOISE_PX]
    if large:
        reporter.note(
            f"residuals of the {' and '.join(large)} are more than image noise: errors of the robot's poses, lens "
            "distortion or a camera matrix that the motion determines badly weigh more, and the sigmas are too small. "
            "A known camera asks less of the data."
        )


def _block_diagonal(blocks: list[FloatArray]) -> FloatArray:
    joint = np.zeros((sum(map(len, blocks)),) * 2)
    start = 0
    for block in blocks:
        stop = start + len(block)
        joint[start:stop, start:stop] = block
        start = stop
    return joint
