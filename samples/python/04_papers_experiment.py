# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The paper's experiment: calibrate by moving the robot, measure 15 points with the laser, compare.

What happens, all in a simulated cell with the paper's hardware (no robot is needed):

1. The robot visits 14 stops over a desk with a printed text and five blocks, and takes an image with the laser off and
   on at each. From these alone come camera matrix, hand-eye transform and light plane.
2. The robot lays the stripe across the letters, four views for every point. A characteristic point is where the stripe
   crosses the middle of a letter's stroke; both are found in the images to a fiftieth of a pixel.
3. The points are placed in the robot's base frame, with 95 % intervals from pixels, robot and calibration, and compared
   with what the robot's tip says when it touches them (0.02 mm per axis).

Written to the folder: both data sets, calibration.yaml, points.csv, points.png. The same by the command line:

  cv-active-handeye calibrate out/experiment/calibration_views -o out/experiment/calibration.yaml
  cv-active-handeye measure out/experiment/measuring_views --calibration out/experiment/calibration.yaml \\
      --points out/experiment/points.csv

With your own robot: record two data sets (03_write_a_dataset.py), and write points.csv by hand or with
cv_active_handeye.workflow.strokes. Needs the extras workflow and sim; takes about a minute.
doc/paper/experiment.md has the table beside the paper's.
"""

import argparse
from pathlib import Path

import numpy as np

from cv_active_handeye.dataset import Dataset
from cv_active_handeye.measured_points import read_point_rows
from cv_active_handeye.report import picture_points
from cv_active_handeye.workflow.experiment import ExperimentPoint, ExperimentResult, experiment


def row(point: ExperimentPoint) -> str:
    """A line of the table, mm."""
    numbers = [*point.measured.position, *point.touched, *point.difference, np.linalg.norm(point.difference)]
    cells = [f"{1000 * value:8.3f}" for value in numbers] + [f"{1000 * value:5.3f}" for value in point.half_widths]
    return f"| {point.measured.name:>3} | " + " | ".join(cells) + " |"


def table(result: ExperimentResult) -> str:
    """Like Table 1 of the paper: point, measured, touched, difference, distance, halves of the 95 % intervals."""
    groups = [f"{what} {axis}" for what in ("measured", "touched", "diff.") for axis in "xyz"]
    names = ["S", *groups, "distance", "± x", "± y", "± z"]
    head = ["| " + " | ".join(names) + " |", "|" + " ---: |" * len(names)]
    return "\n".join([*head, *(row(point) for point in result.points)])


def draw(result: ExperimentResult) -> Path:
    """One laser image of every row of points, with the points that were found in it."""
    dataset = Dataset.open(result.folder / "measuring_views")
    first: dict[str, int] = {}
    seen: dict[int, dict[str, tuple[float, float]]] = {}
    for found in read_point_rows(result.folder / "points.csv"):
        if first.setdefault(found.name, found.view) == found.view:
            seen.setdefault(found.view, {})[found.name] = (found.u, found.v)
    path = result.folder / "points.png"
    picture_points(path, [(dataset.laser_image(view), points) for view, points in seen.items()])
    return path


parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("folder", nargs="?", type=Path, default=Path("out/experiment"), help="a new folder for the results")
parser.add_argument("--seed", type=int, default=0, help="another seed is another cell (default 0)")
options = parser.parse_args()

result = experiment(options.folder, options.seed)
print(table(result))
print(
    f"\nDistances of the 15 points: RMS {1000 * result.rms:.3f} mm, largest {1000 * result.distances.max():.3f} mm, "
    f"predicted RMS {1000 * result.predicted_rms:.3f} mm.\n"
    "The paper's, recomputed from its Table 1: RMS 0.60 mm, largest 1.18 mm.\n"
    f"{sum(result.inside)} of {len(result.inside)} differences are in their 95 % intervals.\nPicture: {draw(result)}"
)
