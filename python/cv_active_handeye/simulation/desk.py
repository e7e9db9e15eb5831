# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The desk of the paper's experiment: a printed sheet, five blocks with a letter each, and things around them.

The paper measured ten characteristic points of a text in one plane, S1 to S10, in three lines of four, three and three,
and five points at 2 to 47 mm above it, S11 to S15.
"""

from __future__ import annotations

import dataclasses

import numpy as np

from .bench import bolts, casting, near, numbered
from .lettering import Mark, letter, letter_width, letters, mark
from .parts import Array, Lettering, Patch, box, extrusion, plate, polygon_patch, pose

ROWS = ("LIFT", "PIT", "TIP")
BLOCK_LETTERS = "TLFIP"
BLOCK_HEIGHTS = (0.0467, 0.0334, 0.0232, 0.0120, 0.0019)
"""Above the sheet, metres: the paper's S11 to S15."""

_SHEET = (0.084, 0.118, 0.0120)  # on a board, so that its stripe does not run on in that of the desk
_SIZE, _STROKE, _PITCH, _LINE = 0.014, 0.0015, 0.0150, 0.0194  # of the text: height, stroke, next letter, next line
_SMALL, _SMALL_STROKE = 0.0032, 0.00045
_BLOCK = (0.030, 0.0172)
_ON_STEM = 0.27  # of the letter's height: below the bars of F and P, above those of L and I
_DESK_SIZE = (0.60, 0.54)


def desk(rng: np.random.Generator) -> tuple[list[Patch], list[Mark]]:
    """Return all patches, planar ones numbered by surface_id, and the marks S1 to S15; `rng` shifts the parts."""
    x, y = _DESK_SIZE
    corners = np.array([[-x, -y, 0], [x, -y, 0], [x, y, 0], [-x, y, 0]]) / 2
    sheet, marks = _sheet(near(-0.016, 0.000, 0.0, (0, 0, 1), rng), rng)
    blocks, more = _blocks(near(0.052, 0.000, 0.0, (0, 0, -1), rng))
    parts = [polygon_patch("desk", "bench", corners), *sheet, *blocks, *_around(rng)]
    return numbered(parts), marks + more


def _sheet(where: Array, rng: np.random.Generator) -> tuple[list[Patch], list[Mark]]:
    """A sheet with three lines of large letters, a mark on the stem of each, between small print."""
    top = where @ pose(0, 0, _SHEET[2])
    strokes: list[tuple[Array, float]] = []
    marks: list[Mark] = []
    for row, text in enumerate(ROWS):
        for column, which in enumerate(text):
            at = top @ pose((column - 1.5) * _PITCH - letter_width(_SIZE) / 2, (0.7 - row) * _LINE - _SIZE / 2, 0)
            drawn = letter(which, _SIZE, at)
            marks.append(mark(f"S{len(marks) + 1}", drawn[0], _ON_STEM, at))
            strokes += [(stroke, _STROKE) for stroke in drawn]
    for y in (0.0500, 0.0445, 0.0390, -0.0445, -0.0500, -0.0555):
        strokes += [(stroke, _SMALL_STROKE) for stroke in _small_print(top @ pose(-0.036, y, 0), 0.072, rng)]
    return _printed(box("sheet", "paper", _SHEET, where), strokes), marks


def _small_print(where: Array, length: float, rng: np.random.Generator) -> list[Array]:
    """Strokes (2, 3) of a line of words that start at the origin of `where`."""
    pitch = 1.5 * letter_width(_SMALL)
    used = rng.choice(list(letters()), int(length / pitch))
    gaps = rng.random(len(used)) < 0.18
    return [
        stroke
        for k, (which, gap) in enumerate(zip(used, gaps, strict=True))
        if not gap
        for stroke in letter(which, _SMALL, where @ pose(k * pitch, 0, 0))
    ]


def _blocks(where: Array) -> tuple[list[Patch], list[Mark]]:
    """Five blocks beside each other, the highest on the side that is farthest from the laser, with a letter on top."""
    patches: list[Patch] = []
    marks: list[Mark] = []
    for k, (height, which) in enumerate(zip(BLOCK_HEIGHTS, BLOCK_LETTERS, strict=True)):
        foot = where @ pose(0, (k - 2) * (_BLOCK[1] + 0.0006), 0)
        at = foot @ pose(-letter_width(_SIZE) / 2, -_SIZE / 2, _SHEET[2] + height)
        drawn = letter(which, _SIZE, at)
        marks.append(mark(f"S{len(ROWS[0] + ROWS[1] + ROWS[2]) + k + 1}", drawn[0], _ON_STEM, at))
        block = box(f"block {k + 1}", "paper", (*_BLOCK, _SHEET[2] + height), foot)
        patches += _printed(block, [(stroke, _STROKE) for stroke in drawn])
    return patches, marks


def _printed(faces: list[Patch], strokes: list[tuple[Array, float]]) -> list[Patch]:
    """The faces of a box with strokes (2, 3) of a width on the topmost."""
    top = max(range(len(faces)), key=lambda i: float(faces[i].vertices[:, 2].mean()))
    lettering = Lettering(np.array([ends for ends, _ in strokes]), np.array([width for _, width in strokes]))
    return [dataclasses.replace(f, lettering=lettering) if i == top else f for i, f in enumerate(faces)]


def _around(rng: np.random.Generator) -> list[Patch]:
    """Boards that lean on something, boxes, labels, a pencil, nuts and a stone."""
    parts = plate("board left", "rust", (0.060, 0.175, 0.006), near(-0.100, 0.006, 0.034, (4, 21, -5), rng))
    parts += plate("board right", "paint", (0.064, 0.150, 0.006), near(0.112, -0.022, 0.030, (-5, -17, 4), rng))
    parts += plate("ramp", "stone", (0.110, 0.080, 0.006), near(-0.005, 0.146, 0.032, (19, 3, 10), rng))
    parts += box("box tall", "card", (0.046, 0.040, 0.058), near(0.128, 0.104, 0.0, (0, 0, 24), rng))
    parts += box("box flat", "card", (0.070, 0.052, 0.022), near(-0.118, 0.142, 0.0, (0, 0, -13), rng))
    parts += box("stone", "stone", (0.064, 0.046, 0.030), near(-0.030, -0.152, 0.0, (0, 0, 17), rng))
    for x, y, turn in ((-0.055, 0.094, 12), (0.052, -0.150, 80), (-0.150, -0.118, -20), (0.165, 0.040, -75)):
        parts += box("label", "label", (0.042, 0.024, 0.0003), near(x, y, 0.0, (0, 0, turn), rng))
    parts += _pencil(near(0.158, -0.060, 0.0, (0, 0, 8), rng))
    parts += bolts(rng)
    return [*parts, casting(near(0.100, -0.148, 0.004, (0, 0, 8), rng), rng)[0]]


def _pencil(where: Array) -> list[Patch]:
    angle = np.radians(60 * np.arange(6) + 30)
    profile = 0.0038 * np.stack([np.cos(angle), np.sin(angle) + np.cos(np.radians(30))], axis=1)
    return extrusion("pencil", "paint", profile, 0.130, where)
