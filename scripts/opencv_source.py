# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""OpenCV's sources, from the source package of opencv-python-headless: the only place of them in the package registry.

Fetched once into build/opencv-<version>; a folder is complete when its sources are unpacked.
"""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[1]
PACKAGE = "opencv-python-headless"
VERSIONS = {4: "4.14.0.94", 5: "5.0.0.93"}
"""The package's version for each major version of OpenCV."""


def opencv_source(major: int) -> Path:
    """The folder with OpenCV's CMakeLists.txt; fetches and unpacks it the first time."""
    folder = ROOT / "build" / f"opencv-{VERSIONS[major]}"
    source = folder / "opencv"
    if not source.exists():
        print(f"Fetching the sources of OpenCV {VERSIONS[major]}", flush=True)
        _unpack(_download(VERSIONS[major], folder), source)
    return source


def _download(version: str, folder: Path) -> Path:
    archive = folder / f"{PACKAGE.replace('-', '_')}-{version}.tar.gz"
    if not archive.exists():
        folder.mkdir(parents=True, exist_ok=True)
        pip = [sys.executable, "-m", "pip", "download", "--quiet", "--no-deps", "--no-binary", PACKAGE]
        subprocess.run([*pip, "--dest", str(folder), f"{PACKAGE}=={version}"], check=True)
    return archive


def _unpack(archive: Path, source: Path) -> None:
    part = source.with_suffix(".part")
    part.mkdir(exist_ok=True)
    inside = f"{archive.name.removesuffix('.tar.gz')}/{source.name}"
    options = ["--strip-components=2", f"--exclude={inside}/samples", inside]
    subprocess.run(["tar", "-xzf", str(archive), "-C", str(part), *options], check=True)
    part.rename(source)
