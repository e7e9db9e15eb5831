# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Settings of the simulated cell."""

from __future__ import annotations

from typing import Literal

from pydantic import BaseModel, ConfigDict, Field, model_validator


class CellConfig(BaseModel):
    """A simulated cell; the defaults are the hardware of the paper. Unknown keys are refused.

    seed: changes texture, noise, robot errors and, a little, scene, lens and mounting; same seed, same bytes.
    principal_point_px: None = (316.8, 243.3) scaled to the image size, moved a little by the seed.
    distortion: k1, k2, p1, p2, k3 as in OpenCV. The paper neglects distortion, so the default is zero.
    repeatability_mm, repeatability_deg: sigma per axis of the true flange pose about the reported one, drawn per stop.
        0.02 mm is the VP-6242's figure; data sheets give none for orientation, and 0.005 deg is 0.02 mm at a lever
        of 0.23 m. The closed form's rotation error grows in proportion to repeatability_deg.
    servo_mm, servo_deg: sigma per axis of the reported pose about the commanded one (the controller knows this error).
    absolute_error_mm, absolute_error_deg: RMS of a smooth error of the true pose over the workspace, the same at every
        visit, with wavelengths of 0.8 m and more. Zero by default: it scales and shears all translations, which no
        calibration from robot poses can tell from the camera. An arm without factory calibration has 0.3 to 1 mm.
    texture: "natural" repeats nowhere; "repeated" covers everything with one tile of `repeat_mm`.
    exposure: 1 = good light; 0.2 = a dark recording with the noise that belongs to it.
    laser_power: irradiance of the stripe's centre relative to white paper under the lamp.
    laser_sigma_mm: Gaussian half width of the light sheet; 0.65 mm is 1.7 px at 0.55 m.
    laser_speckle: relative contrast of the stripe's grain.
    samples_per_axis: rays per pixel and axis (2 = 4 rays a pixel).
    scene: "workbench" = a welding jig and parts around it; "experiment" = the paper's: a printed sheet and five blocks.
    motion: "default" = the 14 stops of a calibration; "check" = 5 other stops, at another time, to verify one; "scan" =
        40 stops in a straight line across the bench, at a third time, to measure with one; "experiment" = 32 stops that
        light the marks of the experiment's scene, four views for every row of marks.
    bump_mm, bump_deg: how far the camera and its laser were pushed out of their mounting, in a direction and about an
        axis that the seed draws.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    seed: int = Field(default=0, ge=0)
    robot: Literal["denso_vp6242", "ur5e"] = "denso_vp6242"
    width: int = Field(default=640, ge=16)
    height: int = Field(default=480, ge=16)
    focal_px: float = Field(default=1413.5, gt=0)
    principal_point_px: tuple[float, float] | None = None
    distortion: tuple[float, float, float, float, float] = (0.0, 0.0, 0.0, 0.0, 0.0)
    repeatability_mm: float = Field(default=0.02, ge=0)
    repeatability_deg: float = Field(default=0.005, ge=0)
    servo_mm: float = Field(default=0.002, ge=0)
    servo_deg: float = Field(default=0.0005, ge=0)
    absolute_error_mm: float = Field(default=0.0, ge=0)
    absolute_error_deg: float = Field(default=0.0, ge=0)
    texture: Literal["natural", "repeated"] = "natural"
    repeat_mm: float = Field(default=24.0, ge=4)
    texel_mm: float = Field(default=0.2, ge=0.05)
    blur_px: float = Field(default=0.7, ge=0)
    exposure: float = Field(default=1.0, gt=0)
    full_well_electrons: float = Field(default=12000.0, gt=0)
    read_noise_electrons: float = Field(default=12.0, ge=0)
    bit_depth: Literal[8, 16] = 8
    lamp: bool = True
    laser: bool = True
    laser_power: float = Field(default=0.95, ge=0)
    laser_sigma_mm: float = Field(default=0.65, gt=0)
    laser_speckle: float = Field(default=0.06, ge=0)
    samples_per_axis: int = Field(default=2, ge=2, le=8)
    scene: Literal["workbench", "experiment"] = "workbench"
    motion: Literal["default", "check", "scan", "experiment"] = "default"
    bump_mm: float = Field(default=0.0, ge=0, le=50)
    bump_deg: float = Field(default=0.0, ge=0, le=20)

    @model_validator(mode="after")
    def _marks_to_measure(self) -> CellConfig:
        if self.motion == "experiment" and self.scene != "experiment":
            raise ValueError(f"motion: 'experiment' needs the scene 'experiment', got {self.scene!r}")
        return self

    @model_validator(mode="after")
    def _even_texture(self) -> CellConfig:
        if self.texture == "repeated" and self.repeat_mm < 20 * self.texel_mm:
            raise ValueError(f"repeat_mm: needs at least 20 texels ({20 * self.texel_mm:g} mm), got {self.repeat_mm:g}")
        return self
