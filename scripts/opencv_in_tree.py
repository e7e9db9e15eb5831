# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Build the module inside OpenCV 4 or 5, run its tests there, and say what came of it.

The first run takes half an hour on two cores; later ones build what changed. Everything is in build/opencv-<version>.
With --write the result goes into doc/in_tree.md. Exit status: 0 when every line of the table is as it should be.
"""

from __future__ import annotations

import argparse
import datetime
import json
import os
import re
import subprocess
import sys
import sysconfig
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

from opencv_source import ROOT, VERSIONS, opencv_source

MODULE = ROOT / "modules" / "active_handeye"
TARGETS = ("opencv_active_handeye", "opencv_test_active_handeye", "opencv_perf_active_handeye", "opencv_python3")
PAGE = ROOT / "doc" / "in_tree.md"
CPP_FAILED, PYTHON_RAN = r"\[  FAILED  \] (\d+) tests?", r"Ran (\d+) tests? in"


@dataclass(frozen=True)
class Line:
    """One line of the table: what was looked at, what came of it, and whether that is right."""

    what: str
    result: str
    good: bool


@dataclass(frozen=True)
class InTree:
    """The build of one major version of OpenCV with the module in it."""

    major: int

    @property
    def source(self) -> Path:
        """OpenCV's sources."""
        return opencv_source(self.major)

    @property
    def build(self) -> Path:
        """Folder of the build."""
        return ROOT / "build" / f"opencv-{VERSIONS[self.major]}" / "in_tree"

    def configure(self) -> Line:
        """Run CMake; whether the module is in "To be built", since OpenCV leaves out modules without an error."""
        self.build.mkdir(parents=True, exist_ok=True)
        command = ["cmake", "-S", str(self.source), "-B", str(self.build), "-G", "Ninja", *_options()]
        done = _run(command, self.build / "configure.log")
        done.check_returncode()
        listed = re.search(r"To be built:.*", done.stdout)
        built = listed is not None and "active_handeye" in listed[0].split() and "python3" in listed[0].split()
        return Line("in the list of modules to be built, with Python", "yes" if built else "no", built)

    def compile(self) -> Line:
        """Build the targets; the compiler's warnings about the module's sources (errors there) and headers."""
        log = self.build / "build.log"
        with log.open("a", encoding="utf-8") as output:
            command = ["cmake", "--build", str(self.build), "--target", *TARGETS]
            status = subprocess.run(command, stdout=output, stderr=subprocess.STDOUT, check=False).returncode
        text = log.read_text(encoding="utf-8", errors="replace")
        if status:
            sys.exit(f"{text[-6000:]}\nThe build failed; all of its output is in {log.relative_to(ROOT)}")
        warnings = re.findall(r"active_handeye/.*: warning: .*", text)
        return Line("warnings of the compiler", str(len(warnings)), not warnings)

    def accuracy(self) -> Line:
        """The module's C++ tests on OpenCV's own test framework."""
        return self._gtest("accuracy tests in C++", "opencv_test_active_handeye")

    def performance(self) -> Line:
        """The performance tests; one sample each, since here only their passing counts."""
        once = ("--perf_min_samples=1", "--perf_force_samples=1")
        return self._gtest("performance tests", "opencv_perf_active_handeye", *once)

    def _gtest(self, what: str, program: str, *options: str) -> Line:
        done = _run([str(self.build / "bin" / program), *options], self.build / f"{program}.log")
        passed = re.search(r"\[  PASSED  \] (\d+) tests?", done.stdout)
        failed = re.search(CPP_FAILED, done.stdout)
        count = int(passed[1]) if passed else 0
        return _tests(what, done, count, int(failed[1]) if failed else 0)

    def python(self) -> Line:
        """The module's Python tests, as OpenCV would run them."""
        path = os.pathsep.join(map(str, [self.build / "lib" / "python3", self.source / "modules" / "python" / "test"]))
        command = [sys.executable, str(MODULE / "misc" / "python" / "test" / "test_active_handeye.py")]
        done = _run(command, self.build / "python.log", PYTHONPATH=path)
        ran = re.search(PYTHON_RAN, done.stdout)
        return _tests("tests of cv2.active_handeye", done, int(ran[1]) if ran else 0, 0)

    def parity(self) -> Line:
        """The same calls through cv2.active_handeye and cv_active_handeye."""
        command = [sys.executable, "-m", "pytest", "-q", "test/parity"]
        done = _run(command, self.build / "parity.log", PYTHONPATH=str(self.build / "lib" / "python3"))
        passed = re.search(r"(\d+) passed", done.stdout)
        return _tests("parity tests with the wheel", done, int(passed[1]) if passed else 0, 0)


def _tests(what: str, done: subprocess.CompletedProcess[str], passed: int, failed: int) -> Line:
    good = done.returncode == 0 and passed > 0 and failed == 0
    if not good:
        print(done.stdout[-6000:], file=sys.stderr)
    return Line(what, f"{passed} passed" if good else f"{passed} passed, {failed} failed, exit {done.returncode}", good)


def _run(command: Sequence[str | Path], log: Path, **environment: str) -> subprocess.CompletedProcess[str]:
    done = subprocess.run(
        [str(part) for part in command],
        cwd=ROOT,
        env=os.environ | environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        encoding="utf-8",
        errors="replace",
        check=False,
    )
    log.write_text(done.stdout, encoding="utf-8")
    return done


def _options() -> list[str]:
    import numpy as np

    library = Path(sysconfig.get_config_var("LIBDIR"), sysconfig.get_config_var("LDLIBRARY"))
    off = ["EXAMPLES", "JAVA", "opencv_apps", "PROTOBUF"]
    without = "IPP ITT OPENCL TBB LAPACK EIGEN PROTOBUF ADE QUIRC VA GTK FFMPEG GSTREAMER V4L 1394 JPEG PNG TIFF WEBP"
    without += " OPENJPEG JASPER OPENEXR AVIF JPEGXL IMGCODEC_GIF UNIFONT"
    values = {
        "CMAKE_BUILD_TYPE": "Release",
        "OPENCV_EXTRA_MODULES_PATH": MODULE.parent,
        "BUILD_LIST": "core,imgproc,active_handeye,python3,ts",
        "ACTIVE_HANDEYE_WERROR": "ON",
        "BUILD_ZLIB": "ON",
        "CPU_DISPATCH": "",
        "BUILD_TESTS": "ON",
        "BUILD_PERF_TESTS": "ON",
        "ENABLE_CCACHE": "OFF",
        **{f"BUILD_{name}": "OFF" for name in off},
        **{f"WITH_{name}": "OFF" for name in without.split()},
        "PYTHON3_EXECUTABLE": sys.executable,
        "PYTHON3_INCLUDE_DIR": sysconfig.get_path("include"),
        "PYTHON3_LIBRARY": library,
        "PYTHON3_NUMPY_INCLUDE_DIRS": np.get_include(),
    }
    return [f"-D{name}={value}" for name, value in values.items()]


def table(lines: list[Line]) -> str:
    """The lines as a markdown table."""
    width = max(len(line.what) for line in lines)
    rows = [f"| {line.what:{width}} | {line.result}{'' if line.good else ' (wrong)'} |" for line in lines]
    return "\n".join([f"| {'':{width}} | result |", f"| {'-' * width} | ------ |", *rows])


def write(major: int, lines: list[Line]) -> None:
    """Put the table between the marks of this version in the page."""
    begin, end = f"<!-- OpenCV {major} -->", f"<!-- end of OpenCV {major} -->"
    head, _, rest = PAGE.read_text(encoding="utf-8").partition(begin)
    _, _, tail = rest.partition(end)
    today = datetime.datetime.now(tz=datetime.timezone.utc).date()
    title = f"OpenCV {VERSIONS[major]}, {today}:"
    PAGE.write_text(f"{head}{begin}\n{title}\n\n{table(lines)}\n{end}{tail}", encoding="utf-8")


def main() -> int:
    """Build, test, print; the exit status."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("major", type=int, choices=sorted(VERSIONS), help="major version of OpenCV")
    parser.add_argument("--write", action="store_true", help=f"write the result into {PAGE.relative_to(ROOT)}")
    options = parser.parse_args()
    tree = InTree(options.major)
    lines = []
    for step in (tree.configure, tree.compile, tree.accuracy, tree.performance, tree.python, tree.parity):
        print(f"OpenCV {VERSIONS[options.major]}: {step.__name__}", flush=True)
        lines.append(step())
    print(table(lines))
    (tree.build / "result.json").write_text(json.dumps([asdict(line) for line in lines], indent=1), encoding="utf-8")
    if options.write:
        write(options.major, lines)
    return 0 if all(line.good for line in lines) else 1


if __name__ == "__main__":
    sys.exit(main())
