# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Print what pyproject.toml asks for, one requirement a line: to build, to run, and the extras named as arguments.

pip can install the requirements of an extra only together with a build of the package. The Makefile installs them
first, and then builds in the same environment, so that a second build has nothing to fetch.
"""

import re
import sys
from pathlib import Path
from typing import Any

if sys.version_info >= (3, 11):
    import tomllib
else:
    from pip._vendor import tomli as tomllib


def extra_requirements(project: dict[str, Any], extra: str) -> list[str]:
    """Requirements of an extra, with those of the extras of this project that it names."""
    requirements = []
    for requirement in project["optional-dependencies"][extra]:
        own = re.fullmatch(rf"{project['name']}\[(.*)\]", requirement)
        if own:
            for name in own[1].split(","):
                requirements += extra_requirements(project, name.strip())
        else:
            requirements.append(requirement)
    return requirements


def pyproject_file() -> dict[str, Any]:
    """The content of pyproject.toml."""
    return tomllib.loads(Path(__file__).parents[1].joinpath("pyproject.toml").read_text(encoding="utf-8"))


def main(extras: list[str]) -> None:
    """Print the requirements of the project and of the extras."""
    pyproject = pyproject_file()
    requirements = pyproject["build-system"]["requires"] + pyproject["project"]["dependencies"]
    for extra in extras:
        requirements += extra_requirements(pyproject["project"], extra)
    print("\n".join(dict.fromkeys(requirements)))


if __name__ == "__main__":
    main(sys.argv[1:])
