# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""What is in the wheels that scripts/build_wheels.py made, and whether they work in bare environments and beside cv2.

With --write the result goes into doc/release.md.
"""

from __future__ import annotations

import datetime
import json
import platform
import subprocess
import sys
import zipfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from .report import Cell, Measure, Report, Table, finish, parser

ROOT = Path(__file__).parents[1]
FOLDER = ROOT / "build" / "wheel"
PAGE = ROOT / "doc" / "release.md"
MARKERS = "<!-- written by make wheel -->", "<!-- end of what make wheel wrote -->"
IMPORT_RUNS = 20
AIMED_MEGABYTES = 1.5


@dataclass(frozen=True)
class Contents:
    """What a wheel holds."""

    wheel: Path

    def extension(self) -> Path:
        """The extension, unpacked beside the wheels."""
        folder = FOLDER / "contents" / self.wheel.stem
        with zipfile.ZipFile(self.wheel) as archive:
            (name,) = (name for name in archive.namelist() if "/_core." in name and name.endswith(".so"))
            return Path(archive.extract(name, folder))

    def bundled(self) -> list[str]:
        """Shared libraries that auditwheel had to put into the wheel."""
        with zipfile.ZipFile(self.wheel) as archive:
            return [name for name in archive.namelist() if ".so" in name and "/_core." not in name]

    def exported(self) -> list[str]:
        """Symbols that other libraries of the process can see."""
        listing = _output("nm", "-D", "--defined-only", str(self.extension()))
        return [line.split()[-1] for line in listing.splitlines()]

    def needed(self) -> list[str]:
        """Libraries of the system that have to be there."""
        lines = _output("readelf", "-d", str(self.extension())).splitlines()
        return [line.split("[")[1].rstrip("]") for line in lines if "(NEEDED)" in line]

    @property
    def megabytes(self) -> float:
        """Size of the wheel."""
        return self.wheel.stat().st_size / 1e6

    @property
    def tag(self) -> str:
        """The part of the name that says which systems the wheel is for."""
        return self.wheel.stem.split("-")[-1]


class BareEnvironment:
    """A fresh virtual environment with numpy and the wheel; cv2 can be added."""

    def __init__(self, python: str, wheel: Path) -> None:
        self.version = _output(python, "-c", "import platform; print(platform.python_version())").strip()
        folder = FOLDER / f"bare-{self.version}"
        subprocess.run([python, "-m", "venv", "--clear", str(folder)], check=True)
        self.python = str(folder / "bin" / "python")
        self.install(str(wheel))

    def install(self, requirement: str) -> None:
        """Install a package with what it needs."""
        pip = [self.python, "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
        subprocess.run([*pip, "--only-binary", ":all:", requirement], check=True)

    def packages(self) -> list[str]:
        """Names of all packages but pip and setuptools."""
        listing = _output(self.python, "-m", "pip", "--disable-pip-version-check", "list", "--format=json")
        return sorted({package["name"] for package in json.loads(listing)} - {"pip", "setuptools"})

    def works(self, *options: str) -> bool:
        """Whether scripts/try_wheel.py is content; prints what it says when it is not."""
        command = [self.python, "-I", str(ROOT / "scripts" / "try_wheel.py"), *options]
        done = subprocess.run(command, cwd=FOLDER, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            print(f"Python {self.version}, {' '.join(options)}:\n{done.stdout}{done.stderr}", file=sys.stderr)
        return done.returncode == 0

    def import_times(self) -> dict[str, float]:
        """Seconds that importing takes: numpy alone, and the wheel, which loads numpy with its first array."""
        command = [self.python, "-I", str(ROOT / "scripts" / "try_wheel.py"), "--import-time", str(IMPORT_RUNS)]
        times: dict[str, float] = json.loads(_output(*command))
        return times


def _output(*command: str) -> str:
    return subprocess.run(command, cwd=FOLDER, check=True, capture_output=True, text=True).stdout


def opencv_versions() -> list[str]:
    """Versions of the cv2 packages to try beside, from scripts/opencv_source.py."""
    code = "from opencv_source import VERSIONS; print(*VERSIONS.values())"
    return subprocess.check_output([sys.executable, "-c", code], cwd=ROOT / "scripts", text=True).split()


def trials(environment: BareEnvironment) -> dict[str, bool]:
    """What was tried in one environment, and whether it worked."""
    packages = environment.packages()
    results = {"only numpy": packages == ["cv_active_handeye", "numpy"] and environment.works()}
    for version in opencv_versions():
        environment.install(f"opencv-python-headless=={version}")
        for order in ("first", "last"):
            results[f"cv2 {version} {order}"] = environment.works("--cv2", order)
    return results


def report(built: dict[str, Any]) -> Report:
    """Inspect and try all wheels."""
    contents, tried, failures, slowest = [], [], 0, 0.0
    for entry in built["wheels"]:
        wheel = Contents(Path(entry["wheel"]))
        environment = BareEnvironment(entry["python"], wheel.wheel)
        times = environment.import_times()
        whole, numpy = times["import cv_active_handeye"], times["import numpy"]
        results = trials(environment)
        contents.append((environment.version, wheel))
        row: list[Cell] = [environment.version, whole, numpy]
        tried.append((row + ["works" if good else "FAILS" for good in results.values()], results))
        failures += sum(not good for good in results.values())
        slowest = max(slowest, whole)
    return Report(
        "Wheel",
        _setup(built),
        [_contents_table(contents), _trials_table(tried)],
        [
            Measure("exported symbols", max(len(wheel.exported()) for _, wheel in contents), 1),
            Measure("bundled libraries", max(len(wheel.bundled()) for _, wheel in contents), 0),
            Measure("time to import, beyond an empty interpreter [s]", slowest, 0.15),
            Measure("trials that failed", failures, 0),
        ],
    )


def _setup(built: dict[str, Any]) -> str:
    source = Path(built["source"])
    network = "cut off from every network" if built["offline"] else "with the network within reach"
    return (
        f"Measured on {datetime.date.today().isoformat()} on {platform.system()} {platform.machine()}, two cores with "
        f"other work. Built from the source package ({source.stat().st_size / 1e6:.2f} MB), {network}."
    )


def _contents_table(contents: list[tuple[str, Contents]]) -> Table:
    rows: list[list[Cell]] = [
        [version, wheel.megabytes, wheel.extension().stat().st_size / 1e6, wheel.tag, ", ".join(wheel.exported())]
        for version, wheel in contents
    ]
    needed = sorted({library for _, wheel in contents for library in wheel.needed()})
    columns = ("Python", "wheel [MB]", "unpacked extension [MB]", "systems", "exported symbols")
    largest = max(wheel.megabytes for _, wheel in contents)
    aim = f"Aimed at {AIMED_MEGABYTES} MB: {'reached' if largest <= AIMED_MEGABYTES else 'not reached'}."
    return Table("Contents", columns, rows, f"{aim} Needed of the system: {', '.join(f'`{name}`' for name in needed)}.")


def _trials_table(tried: list[tuple[list[Cell], dict[str, bool]]]) -> Table:
    columns = ("Python", "import [s]", "numpy alone [s]", *tried[0][1])
    note = (
        f"Import times are the best of {IMPORT_RUNS} fresh processes; the wheel loads numpy with its first array. "
        '"Works": calibration, stripe and errors of '
        "`scripts/try_wheel.py` are right; cv2 imported first or last, computes too and raises its own exceptions."
    )
    return Table("Trials in bare environments", columns, [row for row, _ in tried], note)


def write(measured: Report) -> None:
    """Put the report between the markers of doc/release.md."""
    text = PAGE.read_text(encoding="utf-8")
    if not all(marker in text for marker in MARKERS):
        raise ValueError(f"{PAGE}: needs the lines {' and '.join(MARKERS)} where the report belongs")
    before, rest = text.split(MARKERS[0])
    after = rest.split(MARKERS[1])[1]
    PAGE.write_text(f"{before}{MARKERS[0]}\n{measured.markdown()}{MARKERS[1]}{after}", encoding="utf-8")


def main() -> int:
    """Print, save and write; exit status 1 when a measure is missed."""
    command_line = parser(__doc__ or "")
    command_line.add_argument("--write", action="store_true", help="put the result into doc/release.md")
    options = command_line.parse_args()
    measured = report(json.loads((FOLDER / "built.json").read_text(encoding="utf-8")))
    if options.write:
        write(measured)
    return finish(measured, options.output)


if __name__ == "__main__":
    sys.exit(main())
