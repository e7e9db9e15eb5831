# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""What the page is made from."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import NDArray

import cv_active_handeye as cah

from ..calibration import Calibration
from ..dataset import Dataset
from ..files import FloatArray

if TYPE_CHECKING:
    from ..workflow.compare import Comparison
    from ..workflow.evidence import Evidence

BoolArray = NDArray[np.bool_]
IntArray = NDArray[np.integer[Any]]


class Summary(Protocol):
    """What the page needs of `cah.RefineSummary`, where every attribute is explained; vectors may be n or n x 1."""

    # ruff: noqa: D102 -- the names are those of RefineSummary, which explains them.
    @property
    def usable(self) -> bool: ...
    @property
    def message(self) -> str: ...
    @property
    def stopReason(self) -> str: ...
    @property
    def iterations(self) -> int: ...
    @property
    def rms(self) -> float: ...
    @property
    def parameterNames(self) -> list[str]: ...
    @property
    def covariance(self) -> NDArray[Any]: ...
    @property
    def standardDeviations(self) -> NDArray[Any]: ...
    @property
    def intervals95(self) -> NDArray[Any]: ...
    @property
    def noiseLevels(self) -> NDArray[Any]: ...
    @property
    def robotTranslationSigma(self) -> float: ...
    @property
    def robotRotationSigma(self) -> float: ...
    @property
    def chiSquare(self) -> float: ...
    @property
    def chiSquareDof(self) -> float: ...
    @property
    def chiSquarePValue(self) -> float: ...
    @property
    def lensModel(self) -> int: ...
    @property
    def lensTests(self) -> NDArray[Any]: ...
    @property
    def poseCorrections(self) -> NDArray[Any]: ...
    @property
    def viewRms(self) -> NDArray[Any]: ...
    @property
    def residuals(self) -> NDArray[Any]: ...
    @property
    def rejectedObservations(self) -> NDArray[Any]: ...
    @property
    def rejectedViews(self) -> list[int]: ...
    @property
    def rejectedSegments(self) -> list[int]: ...
    @property
    def stripeResiduals(self) -> NDArray[Any]: ...
    @property
    def stripeGroups(self) -> NDArray[Any]: ...
    @property
    def culprits(self) -> list[str]: ...
    @property
    def scenePoints(self) -> NDArray[Any]: ...
    @property
    def weakDirections(self) -> list[str]: ...
    @property
    def workingDistance(self) -> float: ...
    @property
    def toolCovariance(self) -> NDArray[Any]: ...


@dataclass(frozen=True)
class ReportInput:
    """A calibration with everything known about it, and the arrays that several figures share."""

    dataset: Dataset
    calibration: Calibration
    evidence: Evidence
    summary: Summary
    comparison: Comparison | None = None

    @property
    def image_size(self) -> tuple[int, int]:
        """Width and height in pixels."""
        return self.calibration.image_width, self.calibration.image_height

    @property
    def image_points(self) -> FloatArray:
        """(V, N, 2) px, NaN = not seen."""
        return self.evidence.image_points

    @cached_property
    def residuals(self) -> FloatArray:
        """(V, N, 2) predicted minus measured, px; NaN where there is none."""
        return np.asarray(self.summary.residuals, np.float64).reshape(self.image_points.shape)

    @cached_property
    def rejected(self) -> BoolArray:
        """(V, N): seen, and left out."""
        marked = np.asarray(self.summary.rejectedObservations, np.bool_).reshape(self.image_points.shape[:2])
        return marked & self.seen

    @cached_property
    def seen(self) -> BoolArray:
        """(V, N): found in the image."""
        return np.asarray(np.isfinite(self.image_points).all(axis=2), np.bool_)

    @cached_property
    def used(self) -> BoolArray:
        """(V, N): found in the image, predicted, and not left out."""
        return np.asarray(self.seen & ~self.rejected & np.isfinite(self.residuals).all(axis=2), np.bool_)

    @cached_property
    def group_ids(self) -> IntArray:
        """(V,) number of the group of equal orientation of each view."""
        return cah.groupViews(self.dataset.R_gripper2base).reshape(-1)

    @cached_property
    def view_rms(self) -> FloatArray:
        """(V,) px, NaN where no point was used."""
        return column(self.summary.viewRms)

    @cached_property
    def pose_corrections(self) -> FloatArray:
        """(V, 6) rotation vector in degrees and translation in mm, base frame."""
        corrections: FloatArray = np.asarray(self.summary.poseCorrections, np.float64).reshape(-1, 6)
        return np.asarray(corrections * np.repeat([np.degrees(1.0), 1000.0], 3), np.float64)

    @cached_property
    def stripe_residuals(self) -> FloatArray:
        """(S, 2) px, the two ends of every segment; NaN = not used."""
        return np.asarray(self.summary.stripeResiduals, np.float64).reshape(-1, 2)

    @cached_property
    def free(self) -> list[int]:
        """Rows of the parameters that were estimated and observed."""
        sigmas = column(self.summary.standardDeviations)
        return [int(i) for i in np.flatnonzero((sigmas > 0) & np.isfinite(sigmas))]

    @cached_property
    def unobserved(self) -> list[str]:
        """Names of the parameters that the data say nothing about."""
        sigmas = column(self.summary.standardDeviations)
        names = zip(self.summary.parameterNames, np.isfinite(sigmas), strict=True)
        return [name for name, finite in names if not finite]


def column(values: Any) -> FloatArray:
    """(n,) from (n,) or (n, 1)."""
    return np.asarray(values, np.float64).reshape(-1)
