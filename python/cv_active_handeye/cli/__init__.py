# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The command `cv-active-handeye`: arguments only, the work is in `workflow`."""

from __future__ import annotations

import sys
from collections.abc import Callable

__all__ = ["app"]

EXTRA = {"cv2", "jinja2", "markupsafe", "matplotlib", "plotly", "pydantic", "rich", "scipy", "typer", "yaml"}


def _missing(name: str) -> Callable[[], object]:
    def tell() -> None:
        print(f"cv-active-handeye needs {name}; pip install 'cv_active_handeye[workflow,sim]'", file=sys.stderr)
        raise SystemExit(2)

    return tell


app: Callable[[], object]
try:
    from . import application
    from . import commands as commands
    from . import emulate as emulate
    from . import emulate_camera as emulate_camera
    from . import exporting as exporting
    from . import laser as laser
    from . import live as live
    from . import planning as planning
    from . import running as running
except ModuleNotFoundError as error:
    if error.name not in EXTRA:
        raise
    app = _missing(error.name)
else:
    app = application.app
