# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The extension as a guest in the process: what it shows, imports, holds and says about itself."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest

import cv_active_handeye as cah
from cv_active_handeye import _core

ROOT = Path(__file__).parents[2]


def test_one_symbol_is_exported() -> None:
    nm = shutil.which("nm")
    if nm is None:
        pytest.skip("nm (binutils) is not installed")
    listing = subprocess.run([nm, "-D", "--defined-only", _core.__file__], capture_output=True, text=True, check=True)
    assert [line.split()[-1] for line in listing.stdout.splitlines()] == ["PyInit__core"]


def test_importing_the_package_imports_numpy_only() -> None:
    script = "import sys; import cv_active_handeye; print(*{m.split('.')[0] for m in sys.modules})"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    loaded = set(done.stdout.split())
    assert "cv_active_handeye" in loaded
    assert not loaded & {"cv2", "pydantic", "scipy", "typer", "rich", "matplotlib", "trimesh", "yaml"}


@pytest.mark.parametrize("order", ["import cv2, cv_active_handeye as cah", "import cv_active_handeye as cah, cv2"])
def test_it_works_beside_cv2_in_both_orders_of_import(order: str) -> None:
    script = f"""{order}
import numpy as np
try:
    cah.estimateFOE([[0, 0]], [[1, 1]])
except cah.error as e:
    print(e.code)
try:
    cv2.Rodrigues(np.zeros((2, 2)))
except cv2.error as e:
    print(e.code < 0, isinstance(e, cah.error))
"""
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["-7", "True", "False"]


def test_other_threads_run_during_a_call() -> None:
    rng = np.random.default_rng(0)
    image = rng.integers(0, 255, (8000, 8000), dtype=np.uint16)  # bytes would be too fast
    finished: list[float] = []

    def call() -> None:
        cah.detectStripe(image)
        finished.append(time.perf_counter())

    thread = threading.Thread(target=call)
    ticks = [time.perf_counter()]
    thread.start()
    while thread.is_alive():
        time.sleep(0.001)
        ticks.append(time.perf_counter())
    thread.join()
    duration = finished[0] - ticks[0]
    assert duration > 0.05, "the call is too short to tell"
    assert np.diff(ticks).max() < 0.5 * duration


def test_the_version_is_that_of_the_project() -> None:
    project = re.search(r"project\(active_handeye VERSION ([0-9.]+)", (ROOT / "CMakeLists.txt").read_text("utf-8"))
    assert project
    assert cah.__version__ == project[1]


def test_constants_are_ints_and_flags_combine() -> None:
    assert (cah.FOE_LEAST_SQUARES, cah.FOE_RANSAC) == (0, 1)
    assert cah.TRANSLATIONS_FIX_K | cah.TRANSLATIONS_ZERO_SKEW | cah.TRANSLATIONS_SQUARE_PIXELS == 7
    assert all(type(getattr(cah, name)) is int for name in dir(cah) if name.isupper() and not name.startswith("_"))


def test_every_public_function_says_shapes_results_and_errors() -> None:
    functions = [getattr(cah, name) for name in cah.__all__ if callable(getattr(cah, name)) and name[0].islower()]
    functions.remove(cah.error)
    assert len(functions) == 18
    for function in functions:
        assert function.__doc__ is not None
        for section in ("Args:", "Returns:", "Raises:"):
            assert section in function.__doc__, f"{function.__name__}: {section}"


def test_stripe_params_have_documented_defaults_and_can_be_set() -> None:
    params = cah.StripeParams()
    documented = re.findall(r"(\w+): .*default ([0-9.]+)\.$", cah.StripeParams.__doc__ or "", re.MULTILINE)
    assert len(documented) == 5
    for name, value in documented:
        assert getattr(params, name) == float(value)
    assert params.orientation == cah.STRIPE_HORIZONTAL
    assert params.saturation == 0
    params.sigma = 3.0
    assert params.sigma == 3.0
    assert params.roi == (0, 0, 0, 0)
    params.roi = 10, 20, 300, 200
    assert params.roi == (10, 20, 300, 200)
