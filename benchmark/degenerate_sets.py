# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Recordings that do not, or hardly, determine the calibration: motions and scenes with something missing.

Every kind has a severity, drawn log-uniformly, that runs from exactly degenerate to nearly well: some of the sets can
be answered, and have to be answered honestly.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from scipy.spatial.transform import Rotation

from .scene import CENTRE, FAR, FOCAL, HEIGHT, NEAR, TETRAHEDRON, WIDTH, Array
from .stops import DOWN, TURNS_DEG
from .world import DISTORTED, Noise, World, fill, mount


@dataclass
class Draft:
    """What a set is made of, well conditioned to begin with; kinds spoil it.

    `turns` (G, 3) degrees and `moves`, G arrays (n, 3) of displacements in the camera frame, metres; the points are
    `count` in a box with half edges `half`, turned by `turn`.
    """

    turns: Array
    moves: list[Array]
    noise: Noise
    half: Array = field(default_factory=lambda: np.array([0.2, 0.2, 0.5 * (FAR - NEAR)]))
    turn: Array = field(default_factory=lambda: np.eye(3))
    count: int = 60
    distorted: bool = False

    def world(self, rng: np.random.Generator) -> World:
        """The simulation of it."""
        R = (DOWN * Rotation.from_euler("xyz", self.turns, degrees=True)).as_matrix()
        rotations = np.concatenate(
            [np.repeat(r[None], len(moves), axis=0) for r, moves in zip(R, self.moves, strict=True)]
        )
        middle = CENTRE - 0.5 * (NEAR + FAR) * rotations[:, :, 2]
        positions = middle + np.einsum("vij,vj->vi", rotations, np.concatenate(self.moves))
        K = np.array([[FOCAL, 0, WIDTH / 2], [0, FOCAL, HEIGHT / 2], [0, 0, 1]])
        world = mount(rng, (rotations, positions), K, DISTORTED if self.distorted else np.zeros(5))
        return fill(rng, world, self.count, self.half, self.turn, min(3, len(rotations)))


def draft(rng: np.random.Generator) -> Draft:
    """A good set: 2 to 4 orientations of five positions and 2 to 4 more, noise of every size."""
    groups, singles = rng.integers(2, 5, 2)
    turns = TURNS_DEG[rng.permutation(len(TURNS_DEG))[: groups + singles]] + rng.uniform(-3, 3, (groups + singles, 3))
    moves = []
    for group in range(groups + singles):
        corners = 0.06 * TETRAHEDRON @ Rotation.random(random_state=rng).as_matrix()
        moves.append(np.vstack([np.zeros(3), corners]) if group < groups else np.zeros((1, 3)))
    robot = rng.choice([0, 1]) * 10 ** rng.uniform(-2.3, -0.7)
    noise = Noise(10 ** rng.uniform(-1.7, 0), robot, 0.3 * robot)
    return Draft(turns, moves, noise, count=int(rng.integers(20, 80)), distorted=bool(rng.random() < 0.3))


def severity(rng: np.random.Generator, low: float, high: float) -> float:
    """Log-uniform in [low, high]; exactly 0 in one of five."""
    return 0.0 if rng.random() < 0.2 else float(10 ** rng.uniform(np.log10(low), np.log10(high)))


def flatten_moves(rng: np.random.Generator, made: Draft, dimensions: int) -> None:
    """Translations of every group on one line (1) or plane (2), up to a share of them; the same one for all groups."""
    share = severity(rng, 1e-6, 0.3)
    frame = Rotation.random(random_state=rng).as_matrix()
    kept = frame @ np.diag([1.0, dimensions - 1 or share, share]) @ frame.T
    in_camera = (DOWN * Rotation.from_euler("xyz", made.turns, degrees=True)).as_matrix()
    made.moves = [moves @ R.T @ kept @ R for moves, R in zip(made.moves, in_camera, strict=True)]


def parallel_translations(rng: np.random.Generator, made: Draft) -> None:
    """All translations nearly along one direction of the base frame."""
    flatten_moves(rng, made, 1)


def coplanar_translations(rng: np.random.Generator, made: Draft) -> None:
    """All translations nearly in one plane of the base frame."""
    flatten_moves(rng, made, 2)


def tiny_translations(rng: np.random.Generator, made: Draft) -> None:
    """The camera hardly leaves the middle of a group."""
    share = severity(rng, 1e-5, 0.2)
    made.moves = [share * moves for moves in made.moves]


def one_axis(rng: np.random.Generator, made: Draft) -> None:
    """All changes of orientation nearly about one axis of the camera."""
    axis = rng.normal(size=3) if rng.random() < 0.5 else np.eye(3)[rng.integers(3)]
    axis /= np.linalg.norm(axis)
    largest = 90 if abs(axis[2]) > 0.9 else 25
    wobble = severity(rng, 1e-4, 5) * rng.normal(size=(len(made.turns), 3))
    vectors = rng.uniform(-largest, largest, (len(made.turns), 1)) * axis + wobble
    made.turns = Rotation.from_rotvec(vectors, degrees=True).as_euler("xyz", degrees=True)


def tiny_turns(rng: np.random.Generator, made: Draft) -> None:
    """All orientations nearly the same."""
    vectors = severity(rng, 1e-3, 5) * rng.normal(size=(len(made.turns), 3))
    made.turns = Rotation.from_rotvec(vectors, degrees=True).as_euler("xyz", degrees=True)


def few_points(rng: np.random.Generator, made: Draft) -> None:
    """One to seven points."""
    made.count = int(rng.integers(1, 8))


def few_views(rng: np.random.Generator, made: Draft) -> None:
    """One or two groups of two to four views, none to two single ones."""
    groups, singles = int(rng.integers(1, 3)), int(rng.integers(0, 3))
    made.turns = made.turns[: groups + singles]
    made.moves = [made.moves[0][: rng.integers(2, 5)] for _ in range(groups)] + [np.zeros((1, 3))] * singles


def planar_scene(rng: np.random.Generator, made: Draft) -> None:
    """All points nearly on one plane, of any slope up to 30 degrees."""
    made.half = np.array([0.2, 0.2, 0.1 * severity(rng, 1e-5, 1)])
    made.turn = Rotation.from_euler("xyz", rng.uniform(-30, 30, 3), degrees=True).as_matrix()


def narrow_area(rng: np.random.Generator, made: Draft) -> None:
    """All points in a small part of the images."""
    size = severity(rng, 1e-4, 0.03) + 1e-6
    made.half = np.array([size, size, 0.05 if rng.random() < 0.5 else size])


def little_parallax(rng: np.random.Generator, made: Draft) -> None:
    """Small turns, small moves and a flat scene at once."""
    share = severity(rng, 1e-3, 0.5)
    made.moves = [share * moves for moves in made.moves]
    made.half = made.half * [1, 1, share]
    made.turns = share * made.turns


def exotic_mixture(rng: np.random.Generator, made: Draft) -> None:
    """Two of the others."""
    for index in rng.permutation(len(SINGLE_KINDS))[:2]:
        SINGLE_KINDS[index](rng, made)


Kind = Callable[[np.random.Generator, Draft], None]
SINGLE_KINDS: tuple[Kind, ...] = (
    parallel_translations,
    coplanar_translations,
    tiny_translations,
    one_axis,
    tiny_turns,
    few_points,
    few_views,
    planar_scene,
    narrow_area,
    little_parallax,
)
KINDS: tuple[Kind, ...] = (*SINGLE_KINDS, exotic_mixture)


def degenerate_set(rng: np.random.Generator, kind: Kind) -> tuple[World, Noise]:
    """A world of this kind and the noise of its recording."""
    made = draft(rng)
    kind(rng, made)
    return made.world(rng), made.noise
