# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Build the source package, and from it a wheel for each of the interpreters that are named (default: this one).

Everything is in build/wheel; the finished packages are in build/wheel/dist. The wheels are built from the unpacked
source package, without a network where the system allows that, and repaired by auditwheel.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

from opencv_source import ROOT
from requirements import pyproject_file
from wheel_dependencies import wheel_dependencies

FOLDER = ROOT / "build" / "wheel"
DIST = FOLDER / "dist"
BUILT = FOLDER / "built.json"
OLDEST_GLIBC = (2, 34)
"""The wheels run where the C library is this old: Debian 12, Ubuntu 22.04, RHEL 9."""


def source_package() -> Path:
    """Make the source package; what is not in .gitignore and not excluded in pyproject.toml is in it."""
    command = [sys.executable, "-m", "build", "--sdist", "--no-isolation", "--outdir", str(DIST), str(ROOT)]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    (archive,) = DIST.glob("*.tar.gz")
    return archive


def unpack(archive: Path) -> Path:
    """The source package as a folder, always the same one; files that did not change keep their time."""
    fresh, source = FOLDER / "fresh", FOLDER / "source"
    shutil.rmtree(fresh, ignore_errors=True)
    fresh.mkdir()
    subprocess.run(["tar", "-xzf", str(archive), "-C", str(fresh)], check=True)
    (unpacked,) = fresh.iterdir()
    _keep_times(source, unpacked)
    shutil.rmtree(source, ignore_errors=True)
    unpacked.rename(source)
    return source


def _keep_times(old: Path, new: Path) -> None:
    for file in (path for path in new.rglob("*") if path.is_file()):
        before = old / file.relative_to(new)
        if before.is_file() and before.read_bytes() == file.read_bytes():
            shutil.copystat(before, file)
        else:
            file.touch()


def environment(python: str) -> Path:
    """The interpreter of a virtual environment of `python` that holds what the build needs."""
    version = subprocess.check_output([python, "-c", "import sys; print('%d.%d' % sys.version_info[:2])"], text=True)
    folder = FOLDER / f"python-{version.strip()}"
    inside = folder / "bin" / "python"
    if not inside.exists():
        subprocess.run([python, "-m", "venv", str(folder)], check=True)
    requirements = pyproject_file()["build-system"]["requires"]
    subprocess.run([str(inside), "-m", "pip", "install", "--quiet", *requirements], check=True)
    return inside


def without_network() -> list[str]:
    """The command before a command that cuts it off from every network; nothing where the system refuses."""
    cut = ["unshare", "--map-root-user", "--net"]
    if not shutil.which(cut[0]):
        return []
    return cut if subprocess.run([*cut, "true"], capture_output=True, check=False).returncode == 0 else []


def build_wheel(python: Path, source: Path, cut: list[str]) -> Path:
    """The wheel as the linker left it."""
    raw = FOLDER / "raw" / python.parents[1].name
    shutil.rmtree(raw, ignore_errors=True)
    settings = {
        "build-dir": FOLDER / "cmake",
        "cmake.define.ACTIVE_HANDEYE_WHEEL_DEPENDENCIES": wheel_dependencies(),
        "cmake.define.ACTIVE_HANDEYE_WERROR": "ON",
    }
    pip = [str(python), "-m", "pip", "wheel", "--quiet", "--no-index", "--no-build-isolation", "--no-deps"]
    options = [f"--config-settings={name}={value}" for name, value in settings.items()]
    subprocess.run([*cut, *pip, *options, "--wheel-dir", str(raw), str(source)], check=True)
    (wheel,) = raw.glob("*.whl")
    return wheel


def repair(wheel: Path) -> Path:
    """The wheel with the tag of the oldest systems it runs on; fails if it is not as old as OLDEST_GLIBC."""
    audit = [sys.executable, "-m", "auditwheel"]
    machine = os.uname().machine
    tag = f"manylinux_{OLDEST_GLIBC[0]}_{OLDEST_GLIBC[1]}_{machine}"
    repaired = FOLDER / "repaired"
    shutil.rmtree(repaired, ignore_errors=True)
    done = subprocess.run(
        [*audit, "repair", "--plat", tag, "--strip", "--wheel-dir", str(repaired), str(wheel)],
        capture_output=True,
        text=True,
        check=False,
    )
    if done.returncode != 0:
        show = subprocess.run([*audit, "show", str(wheel)], capture_output=True, text=True, check=False)
        sys.exit(f"{done.stderr}\n{show.stdout}")
    (made,) = repaired.glob("*.whl")
    return Path(shutil.copy(made, DIST))


def main() -> None:
    """Build everything; write what was built to BUILT."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("pythons", nargs="*", default=[sys.executable], help="interpreters to build for")
    pythons = parser.parse_args().pythons
    shutil.rmtree(DIST, ignore_errors=True)
    wheel_dependencies()
    archive = source_package()
    source, cut = unpack(archive), without_network()
    wheels = []
    for python in pythons:
        print(f"Building the wheel for {python}", flush=True)
        inside = environment(python)
        wheels.append({"python": str(inside), "wheel": str(repair(build_wheel(inside, source, cut)))})
    built = {"source": str(archive), "offline": bool(cut), "wheels": wheels}
    BUILT.write_text(json.dumps(built, indent=1), encoding="utf-8")


if __name__ == "__main__":
    main()
