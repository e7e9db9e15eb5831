# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Put what a wheel is built with into build/wheel-dependencies: OpenCV's core as a static library, and Eigen's headers.

Made once; made again when version, options or compiler have changed. Needs CMake and a C++ compiler. Runs under Python
3.9 too, which is what cibuildwheel starts it with in its Linux images.
"""

from __future__ import annotations

import json
import os
import platform
import shutil
import subprocess
import sys
from pathlib import Path

from opencv_source import ROOT, VERSIONS, opencv_source

FOLDER = ROOT / "build" / "wheel-dependencies"
EIGEN = "cmeel-eigen==3.4.1"

_OFF = [
    *(f"BUILD_{part}" for part in ("SHARED_LIBS", "TESTS", "PERF_TESTS", "EXAMPLES", "JAVA", "WITH_STATIC_CRT")),
    *(f"BUILD_opencv_{part}" for part in ("apps", "python3", "python_bindings_generator")),
    *(f"WITH_{accelerator}" for accelerator in ("IPP", "ITT", "OPENCL", "TBB", "LAPACK", "EIGEN", "VA", "DIRECTX")),
    *(f"WITH_{accelerator}" for accelerator in ("CAROTENE", "KLEIDICV", "NDSRVP", "HAL_RVV")),
    *(f"WITH_{reader}" for reader in ("JPEG", "PNG", "TIFF", "WEBP", "OPENJPEG", "JASPER", "OPENEXR", "AVIF", "QUIRC")),
    *(f"WITH_{device}" for device in ("FFMPEG", "GSTREAMER", "GTK", "V4L", "1394", "VTK")),
    *(f"WITH_{language}" for language in ("PROTOBUF", "FLATBUFFERS", "ADE")),
    "ENABLE_CCACHE",
]
OPTIONS = {
    # Small, for the baseline of every processor, with nothing chosen at run time: the core is not where time goes.
    "CMAKE_BUILD_TYPE": "Release",
    "CMAKE_CXX_FLAGS_RELEASE": "/O1 /DNDEBUG" if sys.platform == "win32" else "-Os -DNDEBUG",
    "BUILD_LIST": "core",
    "BUILD_ZLIB": "ON",
    "CPU_DISPATCH": "",
    "CMAKE_POSITION_INDEPENDENT_CODE": "ON",
    "CMAKE_CXX_VISIBILITY_PRESET": "hidden",
    "CMAKE_VISIBILITY_INLINES_HIDDEN": "ON",
    **dict.fromkeys(_OFF, "OFF"),
}


def contents() -> dict[str, object]:
    """What the folder is to hold: versions, options, compiler and what it builds for."""
    return {
        "OpenCV": VERSIONS[4],
        "options": dict(OPTIONS),
        "Eigen": EIGEN,
        "compiler": _compiler(),
        "machine": platform.machine(),
        "macOS": {name: os.environ.get(name) for name in ("ARCHFLAGS", "MACOSX_DEPLOYMENT_TARGET")},
    }


def _compiler() -> str:
    if sys.platform == "win32":
        return "the newest Visual Studio"
    command = [*os.environ.get("CXX", "c++").split(), "--version"]
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout.splitlines()[0]


def _build_opencv(prefix: Path) -> None:
    build = ROOT / "build" / "opencv-static"
    options = [f"-D{name}={value}" for name, value in OPTIONS.items()]
    jobs = os.environ.get("CMAKE_BUILD_PARALLEL_LEVEL", str(os.cpu_count()))
    shutil.rmtree(build, ignore_errors=True)
    _run("cmake", "-S", str(opencv_source(4)), "-B", str(build), f"-DCMAKE_INSTALL_PREFIX={prefix}", *options)
    _run("cmake", "--build", str(build), "--config", "Release", "--parallel", jobs)
    _run("cmake", "--install", str(build), "--config", "Release")


def _run(*command: str) -> None:
    """The output goes to the log, and to the screen when the command fails."""
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
    if done.returncode != 0:
        sys.exit(f"{done.stdout}\n{' '.join(command)} ended with exit status {done.returncode}")


def _install_eigen(prefix: Path) -> None:
    _run(sys.executable, "-m", "pip", "install", "--quiet", "--no-deps", "--target", str(prefix / "eigen"), EIGEN)


def wheel_dependencies() -> Path:
    """The folder for CMake's ACTIVE_HANDEYE_WHEEL_DEPENDENCIES; fills it the first time."""
    stamp = FOLDER / "contents.json"
    wanted = json.dumps(contents(), indent=1)
    if not stamp.exists() or stamp.read_text(encoding="utf-8") != wanted:
        print(f"Building OpenCV's core {VERSIONS[4]} as a static library (some minutes)", flush=True)
        shutil.rmtree(FOLDER, ignore_errors=True)
        _build_opencv(FOLDER)
        _install_eigen(FOLDER)
        stamp.write_text(wanted, encoding="utf-8")
    return FOLDER


if __name__ == "__main__":
    print(wheel_dependencies())
