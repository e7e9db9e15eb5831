# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Settings of the tracker."""

from __future__ import annotations

from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field

Positive = Annotated[float, Field(gt=0.0)]
Fraction = Annotated[float, Field(gt=0.0, lt=1.0)]


class TrackingConfig(BaseModel):
    """How images of one recording become tracks; unknown keys are refused. Lengths are pixels of the image.

    The defaults were chosen on the simulated cell (doc/decisions/tracking-features.md); `benchmark/tracking.py` prints
    what they reach.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    contrast_threshold: Positive = 0.04
    """SIFT contrast threshold. Lower values give more and worse features."""

    max_features: Annotated[int, Field(ge=50)] = 2000
    """Features kept in one image, strongest first."""

    ratio: Fraction = 0.8
    """Largest descriptor distance of a match, as a fraction of that to the nearest other feature of either image."""

    copy_distance: Annotated[float, Field(ge=0.0, lt=1.4)] = 0.33
    """A feature with a copy in its own image that is nearer than this (RootSIFT distance, 0 to 1.4) is ambiguous and
    not used. On textures that do not repeat, 99 % of the features have no copy nearer than 0.37."""

    all_pairs_up_to: Annotated[int, Field(ge=2)] = 16
    """Up to this number of views every pair is matched; beyond it, see `matching.select_pairs`."""

    min_pair_matches: Annotated[int, Field(ge=8)] = 12
    """A pair of views with fewer matches, before or after geometric rejection, is left out."""

    match_threshold: Positive = 3.0
    """Distance to the epipolar geometry at which a match is rejected. Lens distortion is not removed before tracking,
    so this must exceed what it adds between two views."""

    min_inlier_fraction: Fraction = 0.5
    """A pair of views where fewer matches fit one motion is left out: on repeated texture, most are wrong."""

    consistency_threshold: Positive = 1.5
    """The same distance, for the refined positions of all pairs of views of a track."""

    orientation_tolerance: Positive = 0.05
    """Degrees; views whose orientations differ by less are one group (`cah.groupViews`)."""

    patch_radius: Annotated[int, Field(ge=4, le=30)] = 7
    """Half width of the square reference patch. Larger patches are less noisy, but what lies in them otherwise than the
    homography of the two views says displaces all patches of the pair alike, in proportion to their area."""

    min_distance: Annotated[float, Field(ge=0.0)] = 7.0
    """Tracks nearer than this to a better one, in any view, are left out (0 = none): overlapping patches err alike, and
    a calibration that takes their errors as independent states too small standard deviations."""

    max_iterations: Annotated[int, Field(ge=2, le=100)] = 15
    """Iterations of the patch alignment."""

    max_wander: Positive = 2.0
    """Largest distance the alignment may move away from the detected feature."""

    min_correlation: Fraction = 0.85
    """Smallest correlation of the aligned patch with its reference."""

    max_sigma: Positive = 0.3
    """An observation with a larger standard deviation per axis is left out."""

    min_views: Annotated[int, Field(ge=2)] = 3
    """Tracks seen in fewer views are left out. With a recording of two views it is two."""
