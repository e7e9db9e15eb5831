# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The whole job from Python: record in the simulated cell, calibrate from the images, compare with the truth, draw.

The same as `cv-active-handeye simulate` and `calibrate`, for your own program. Needs the extras workflow and sim.

Run: python samples/python/02_simulate_and_calibrate.py out/cell
"""

import sys
from pathlib import Path

from cv_active_handeye.report import calibration_errors
from cv_active_handeye.simulation import CellConfig
from cv_active_handeye.workflow import calibrate_with_evidence
from cv_active_handeye.workflow.pictures import draw_pictures
from cv_active_handeye.workflow.simulate import simulate

folder = Path(sys.argv[1] if len(sys.argv) > 1 else "out/cell")

dataset, truth = simulate(folder / "dataset", folder / "truth.yaml", CellConfig(seed=1, robot="ur5e"))
calibration, evidence = calibrate_with_evidence(dataset)
calibration.save(folder / "calibration.yaml")

print(f"{calibration.points} points, {calibration.observations} observations, RMS {calibration.rms}")
print(f"fx = {calibration.camera_matrix[0, 0]:.2f} +- {calibration.standard_deviation('fx'):.2f} px")
print(calibration_errors(calibration, truth))
print(*draw_pictures(folder / "pictures", dataset, calibration, evidence), sep="\n")
