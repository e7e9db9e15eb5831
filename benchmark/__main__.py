# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Runs the benchmarks, each in a process of its own, and keeps their reports in out/benchmark/*.json.

With --write, doc/accuracy.md and the accuracy table of the README get the newest report of every benchmark that ran on
this machine; the others keep theirs.
Exit status 1 when a measure is missed or a benchmark fails.
"""

from __future__ import annotations

import argparse
import re
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from fnmatch import fnmatch
from pathlib import Path

from .report import Cell, Measure, Report, Table, format_cell

REPOSITORY = Path(__file__).parents[1]
REPORTS = REPOSITORY / "out/benchmark"
PARALLEL = (
    *("demo", "experiment", "seam", "light_plane", "refine", "lens_models", "measured_points", "opencv_boards"),
    *("planning", "protocols", "degenerate", "mountings", "robust", "hand_eye"),
)
"""Those that run their trials on the workers of cluster.py."""
NAMES = (
    *PARALLEL,
    *("closed_form", "foe", "speed", "refine_speed", "stripe_centre", "reproject_speed", "tracking", "detectors"),
    *("robots", "faults", "real_data"),
)
MARKERS = "<!-- accuracy: written by make bench -->", "<!-- end of accuracy -->"


@dataclass(frozen=True)
class Headline:
    """A line of the README: the worst of the measures of one benchmark whose names match `pattern`."""

    script: str
    pattern: str
    text: str

    def row(self, report: Report) -> list[Cell]:
        """text, value, limit, script."""
        found = [measure for measure in report.measures if fnmatch(measure.name, self.pattern)]
        if not found:
            raise KeyError(f"benchmark/{self.script}.py has no measure {self.pattern!r}")
        worst: Measure = (min if found[0].at_least else max)(found, key=lambda measure: measure.value)
        _, value, limit, _ = worst.row()
        return [self.text, format_cell(value), limit, self.key[1]]

    @property
    def key(self) -> tuple[str, str]:
        """Text and script, as the README shows them."""
        return self.text, f"`benchmark/{self.script}.py`"


HEADLINES = (
    Headline("demo", "24 stops: median rotation*", "simulated cell, images to calibration, 24 stops: rotation [deg]"),
    Headline("demo", "24 stops: median translation*", "- camera position [mm]"),
    Headline("demo", "24 stops: median fx*", "- focal length [%]"),
    Headline("demo", "12 stops: median rotation*", "- with 12 stops: rotation [deg]"),
    Headline("demo", "12 stops: median translation*", "- camera position [mm]"),
    Headline("demo", "demo, 14 stops: median plane normal*", "- with 14 stops: light plane, normal [deg]"),
    Headline("demo", "demo, 14 stops: median plane offset*", "- light plane, offset [mm]"),
    Headline("demo", "95 % intervals*", "- 95 % intervals that hold the truth, off by [%]"),
    Headline("experiment", "median*RMS of 15 points*", "the paper's experiment, 15 points: RMS distance [mm]"),
    Headline("experiment", "median of the largest*", "- the largest of the 15 [mm]"),
    Headline("experiment", "RMSE / predicted", "- RMSE / predicted"),
    Headline("experiment", "*coverage off*", "- coverage of its 95 % intervals is off by [%]"),
    Headline("seam", "*median*", "root of a weld joint, from images alone: RMS distance [mm]"),
    Headline(
        "closed_form",
        "four translations*RMSE / bound",
        "K and rotation from four translations: RMSE / Cramér-Rao bound",
    ),
    Headline("closed_form", "t_cam2gripper*RMSE / bound", "- camera position from turns"),
    Headline("refine", "*RMSE / bound, levels estimated", "refinement of everything: RMSE / Cramér-Rao bound"),
    Headline("refine", "*coverage off*", "- coverage of its 95 % intervals is off by [%]"),
    Headline("light_plane", "*RMSE / bound", "light plane from stripes: RMSE / Cramér-Rao bound"),
    Headline("light_plane", "rendered cell*normal*", "- two groups of five rendered views: normal [deg]"),
    Headline("light_plane", "rendered cell*offset*", "- offset [mm]"),
    Headline("measured_points", "*coverage off*", "- the same for points measured with the laser [%]"),
    Headline(
        "opencv_boards",
        "*400 tracks / best of OpenCV",
        "- without a target, 400 tracks: RMSE / that of the best of OpenCV's methods with a board",
    ),
    Headline("planning", "*the paper's set*", "planned stops: predicted sigma / that of the paper's set of motions"),
    Headline("planning", "prediction*", "- prediction is off from 300 refined trials by [%]"),
    Headline("robots", "ur: median translation*", "`run` with ur_rtde and pypylon on emulators: camera position [mm]"),
    Headline("robots", "denso: median translation*", "- with b-CAP on the emulated DENSO: camera position [mm]"),
    Headline("faults", "moves after*", "faults during captures: moves after a stop condition"),
    Headline("faults", "lost*", "- lost views"),
    Headline("degenerate", "usable answers off by*", "- silent wrong answers in 2200 degenerate recordings"),
    Headline("mountings", "noisy answers off by*", "- any mounting and motion: off by > 6 sigma [per mille]"),
    Headline("robust", "*error / clean error*", "- RMSE with wrong tracks or poses / RMSE without"),
    Headline(
        "hand_eye",
        "10 views*RMSE / bound",
        "`calibrateHandEyeExtended` from poses of a target: RMSE / Cramér-Rao bound",
    ),
    Headline("hand_eye", "*best of OpenCV*", "- RMSE / that of the best of OpenCV's five methods"),
    Headline("foe", "*median error*", "`estimateFOE`: median error / that of OpenCV's essential matrix"),
    Headline("foe", "*times as fast", "- times as fast"),
    Headline(
        "speed", "closed forms / fastest*", "whole closed form, 24 views x 200 points: time / `cv2.calibrateHandEye`"
    ),
    Headline("refine_speed", "*fastest of Ceres", "refinement, 24 views x 200 points: time / the best solver of Ceres"),
    Headline("refine_speed", "scipy*", "- times as fast as `scipy.optimize.least_squares`"),
    Headline("stripe_centre", "*RMSE / bound*", "`detectStripe`: RMSE of a column's centre / Cramér-Rao bound"),
    Headline("stripe_centre", "saturated*", "- with saturated columns and speckle: RMS [px]"),
    Headline("stripe_centre", "*GaussianBlur*", "- time / `cv2.GaussianBlur` 5 x 5"),
    Headline("reproject_speed", "reprojectStripe: *", "`reprojectStripe`: million points a second"),
    Headline("tracking", "*sigma*", "tracks of the default scene: robust sigma [px]"),
)


def run(name: str, where: Sequence[str] = ()) -> int:
    """Runs one benchmark, with the options `where` if its trials can run in parallel; its exit status."""
    print(f"== benchmark/{name}.py", flush=True)
    output = REPORTS / f"{name}.json"
    output.unlink(missing_ok=True)
    command = [sys.executable, "-m", f"benchmark.{name}", "--output", str(output), *(where if name in PARALLEL else ())]
    return subprocess.run(command, cwd=REPOSITORY, check=False).returncode


def write(reports: dict[str, Report]) -> None:
    """doc/accuracy.md, and the README's table between its markers; what has no report here stays as it was."""
    accuracy = REPOSITORY / "doc/accuracy.md"
    sections = _sections(accuracy.read_text(encoding="utf-8")) if accuracy.is_file() else {}
    sections.update({report.title: report.markdown() for report in reports.values()})
    introduction = (
        "# Accuracy and speed\n\nWritten by `make bench` on one machine (two cores, shared with other work); "
        "[benchmark/README.md](../benchmark/README.md) says what each part measures and how to run it alone.\n"
    )
    accuracy.write_text("\n".join([introduction, *sections.values()]), encoding="utf-8")
    readme = REPOSITORY / "README.md"
    text = readme.read_text(encoding="utf-8")
    if not all(marker in text for marker in MARKERS):
        raise ValueError(f"{readme}: needs the lines {' and '.join(MARKERS)} where the accuracy table belongs")
    before, rest = text.split(MARKERS[0])
    old, after = rest.split(MARKERS[1])
    stood = _rows(old)
    rows = [line.row(reports[line.script]) if line.script in reports else stood.get(line.key) for line in HEADLINES]
    columns = ("measured (worst case)", "result", "limit", "printed by")
    table = Table("", columns, [row for row in rows if row]).markdown().split("\n", 2)[2]
    link = "All tables: [doc/accuracy.md](doc/accuracy.md).\n"
    readme.write_text(f"{before}{MARKERS[0]}\n{table}\n{link}{MARKERS[1]}{after}", encoding="utf-8")


def _sections(text: str) -> dict[str, str]:
    """The sections of doc/accuracy.md by their title, in their order."""
    parts = re.split(r"^## ", text, flags=re.MULTILINE)[1:]
    return {part.split("\n", 1)[0]: f"## {part.rstrip()}\n" for part in parts}


def _rows(table: str) -> dict[tuple[str, str], list[Cell]]:
    """The rows of the README's table by their text and script."""
    rows: list[list[Cell]] = []
    for line in table.splitlines():
        if line.startswith("|"):
            rows.append([cell.strip() for cell in line.strip("|").split("|")])
    return {(str(row[0]), str(row[3])): row for row in rows}


def main(arguments: Sequence[str] | None = None) -> int:
    """Command line."""
    line = argparse.ArgumentParser(prog="python -m benchmark", description=__doc__)
    line.formatter_class = argparse.RawDescriptionHelpFormatter
    line.add_argument("names", nargs="*", help=f"benchmarks to run, default all: {', '.join(NAMES)}")
    line.add_argument("--write", action="store_true", help="write doc/accuracy.md and the README's table")
    line.add_argument(
        "--no-run", action="store_true", help="with --write: only write, from the reports of earlier runs"
    )
    line.add_argument("--workers", metavar="N", help="processes of the parallel ones, default all cores")
    line.add_argument("--scheduler", metavar="ADDRESS", help="run the trials of the parallel ones on this dask cluster")
    options = line.parse_args(arguments)
    unknown = set(options.names) - set(NAMES)
    if unknown:
        line.error(f"there is no benchmark {', '.join(sorted(unknown))}; there are {', '.join(NAMES)}")
    REPORTS.mkdir(parents=True, exist_ok=True)
    given = {"--workers": options.workers, "--scheduler": options.scheduler}
    where = [part for option, value in given.items() if value for part in (option, value)]
    failed = [] if options.no_run else [name for name in options.names or NAMES if run(name, where) != 0]
    if options.write:
        files = {name: REPORTS / f"{name}.json" for name in NAMES}
        write({name: Report.load(file) for name, file in files.items() if file.is_file()})
    if failed:
        print(f"measures missed or failed: {', '.join(failed)}", file=sys.stderr)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
