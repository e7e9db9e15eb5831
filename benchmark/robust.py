# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""refineHandEye on recordings in which something is wrong: tracks, a pose, a group of poses.

Every trial is calibrated clean and spoiled, with the same noise; the RMS errors over the trials are compared. The
culprit counts as named when the summary leaves it out or lists it.
"""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

import cv_active_handeye as cah

from . import cluster
from .refine_trials import Case, Estimate, calibrate, settings
from .report import Cell, Measure, Report, Table
from .scene import HEIGHT, WIDTH, Array
from .stops import STOPS_24
from .world import ROTATION, TRANSLATION, Noise, Recording

LIMIT, NAMED, MAX_REFUSED = 1.5, 95.0, 1.0
CASE = Case("24 stops", Noise(0.1, 0.02, 0.005), STOPS_24, points=100)
WRONG_SHARE, SLIP, TWIST_DEG = 0.2, 0.0005, 1.0
CAMERA = [0, 1, 2, 3]


@dataclass(frozen=True)
class Spoiled:
    """A recording with something wrong; which tracks and which views."""

    recording: Recording
    tracks: tuple[int, ...] = ()
    views: tuple[int, ...] = ()


def scattered_tracks(rng: np.random.Generator, recording: Recording) -> Spoiled:
    """20 % of the tracks: half of their observations are anywhere in the image."""
    seen = recording.image_points.copy()
    tracks = _choose_tracks(rng, seen)
    for track in tracks:
        views = _half_of_its_views(rng, seen, track)
        seen[views, track] = rng.uniform((0, 0), (WIDTH, HEIGHT), (len(views), 2))
    return Spoiled(replace(recording, image_points=seen), tracks)


def jumping_tracks(rng: np.random.Generator, recording: Recording) -> Spoiled:
    """20 % of the tracks: in half of their views they follow another scene point."""
    original = recording.image_points
    seen = original.copy()
    changed = []
    for track in _choose_tracks(rng, seen):
        other = (track + int(rng.integers(1, seen.shape[1]))) % seen.shape[1]
        views = _half_of_its_views(rng, original, track)
        views = views[np.isfinite(original[views, other, 0])]
        seen[views, track] = original[views, other]
        changed += [track] if len(views) else []
    return Spoiled(replace(recording, image_points=seen), tuple(changed))


def swapped_pose(rng: np.random.Generator, recording: Recording) -> Spoiled:
    """The poses of two views of different orientation are exchanged."""
    groups = view_groups(STOPS_24)
    first, second = rng.permutation(len(groups))[:2]
    views = int(rng.choice(groups[first])), int(rng.choice(groups[second]))
    order = np.arange(len(recording.R_gripper2base))
    order[list(views)] = views[::-1]
    return Spoiled(_with_poses(recording, recording.R_gripper2base[order], recording.t_gripper2base[order]), (), views)


def slipped_robot(rng: np.random.Generator, recording: Recording) -> Spoiled:
    """In one view the robot stands 0.5 mm beside its report."""
    view = int(rng.integers(len(recording.R_gripper2base)))
    way = rng.normal(size=3)
    t = recording.t_gripper2base.copy()
    t[view] += SLIP * way / np.linalg.norm(way)
    return Spoiled(_with_poses(recording, recording.R_gripper2base, t), (), (view,))


def twisted_group(rng: np.random.Generator, recording: Recording) -> Spoiled:
    """All views of one group report an orientation that is 1 degree off."""
    views = view_groups(STOPS_24)[rng.integers(4)]
    axis = rng.normal(size=3)
    twist = Rotation.from_rotvec(np.radians(TWIST_DEG) * axis / np.linalg.norm(axis)).as_matrix()
    R = recording.R_gripper2base.copy()
    R[views] = twist @ R[views]
    return Spoiled(_with_poses(recording, R, recording.t_gripper2base), (), tuple(views))


def mislabelled_group(rng: np.random.Generator, recording: Recording) -> Spoiled:
    """All views of one group report the orientation of another group."""
    groups = view_groups(STOPS_24)
    first, second = rng.permutation(4)[:2]
    R = recording.R_gripper2base.copy()
    R[groups[first]] = R[groups[second][0]]
    return Spoiled(_with_poses(recording, R, recording.t_gripper2base), (), tuple(groups[first]))


Spoiler = Callable[[np.random.Generator, Recording], Spoiled]
SPOILERS: dict[str, Spoiler] = {
    "20 % wrong tracks, scattered": scattered_tracks,
    "20 % wrong tracks, jumping": jumping_tracks,
    "two poses swapped": swapped_pose,
    "one view slipped by 0.5 mm": slipped_robot,
    "one group twisted by 1 degree": twisted_group,
    "one group mislabelled": mislabelled_group,
}


def view_groups(stops: Sequence[int]) -> list[list[int]]:
    """Views of every orientation."""
    firsts = np.cumsum([0, *stops])
    return [list(range(first, first + count)) for first, count in zip(firsts, stops, strict=False)]


def _with_poses(recording: Recording, R: Array, t: Array) -> Recording:
    return replace(recording, R_gripper2base=R, t_gripper2base=t)


def _choose_tracks(rng: np.random.Generator, seen: Array) -> tuple[int, ...]:
    return tuple(rng.permutation(seen.shape[1])[: int(WRONG_SHARE * seen.shape[1])].tolist())


def _half_of_its_views(rng: np.random.Generator, seen: Array, track: int) -> NDArray[np.int64]:
    views = np.flatnonzero(np.isfinite(seen[:, track, 0]))
    return rng.permutation(views)[: len(views) // 2]


def named(spoiled: Spoiled, found: Estimate) -> float:
    """Share of the culprits that the summary leaves out, or names in its sentences."""
    summary = found.summary
    if spoiled.tracks:
        left_out = np.asarray(summary.rejectedObservations)[:, list(spoiled.tracks)]
        return float(np.mean(left_out.any(axis=0)))
    lists = re.findall(r"views? (\d+(?:(?:, | and |, and )\d+)*)", " ".join(summary.culprits))
    views = set(summary.rejectedViews) & {int(number) for text in lists for number in re.findall(r"\d+", text)}
    return float(np.mean([view in views for view in spoiled.views]))


def trial(spoil: Spoiler, seed: int, number: int) -> tuple[Array, Array, float, int]:
    """Errors (20) clean and spoiled (NaN = refused or not usable), share of culprits named, innocent views blamed."""
    rng = np.random.default_rng([seed, number])
    world = CASE.world(rng)
    recording = world.record(rng, CASE.noise)
    clean = calibrate(world, recording, settings(CASE.lens_model)).error
    spoiled = spoil(rng, recording)
    try:
        found = calibrate(world, spoiled.recording, settings(CASE.lens_model))
    except cah.error:
        return clean, np.full_like(clean, np.nan), 0.0, 0
    error = found.error if found.summary.usable else np.full_like(clean, np.nan)
    return clean, error, named(spoiled, found), len(set(found.summary.rejectedViews) - set(spoiled.views))


def measure(workers: cluster.Workers, spoilers: Sequence[str], trials: int = 200, seed: int = 1) -> Report:
    """Every way of spoiling."""
    rows: list[list[Cell]] = []
    measures = []
    parts = {"camera [px]": (CAMERA, 1.0), "R [deg]": (ROTATION, np.degrees(1)), "t [mm]": (TRANSLATION, 1000.0)}
    for name in spoilers:
        found = workers.run(partial(trial, SPOILERS[name], seed), trials, name)
        clean, spoiled = (np.array([one[i] for one in found]) for i in (0, 1))
        refused = np.isnan(spoiled[:, 0])
        share, blamed = 100 * float(np.mean([one[2] for one in found])), float(np.mean([one[3] for one in found]))
        cells: list[Cell] = [name, 100 * float(refused.mean()), share, blamed]
        worst = 0.0
        for at, unit in parts.values():
            good, bad = (_rms(errors[~refused][:, at]) for errors in (clean, spoiled))
            cells += [unit * good, unit * bad, bad / good]
            worst = max(worst, bad / good) if bad == bad else np.inf
        rows.append(cells)
        measures.append(Measure(f"{name}: refused or not usable [%]", 100 * float(refused.mean()), MAX_REFUSED))
        measures.append(Measure(f"{name}: error / clean error, largest", worst, LIMIT))
        measures.append(Measure(f"{name}: culprits named [%]", share, NAMED, at_least=True))
    heads = [f"{what}, {how}" for what in parts for how in ("clean", "spoiled", "ratio")]
    columns = (
        "what is wrong",
        "refused or not usable [%]",
        "culprits named [%]",
        "innocent views blamed, mean",
        *heads,
    )
    setup = (
        f"{trials} trials, seed {seed}; 24 stops, {CASE.points} tracks, {CASE.noise.point_px} px, robot "
        f"{CASE.noise.robot_mm} mm / {CASE.noise.robot_deg} deg, noise levels estimated. RMS errors over the trials; "
        "camera: fx, fy, cx, cy together."
    )
    return Report("Wrong tracks and wrong poses", setup, [Table("Errors, clean and spoiled", columns, rows)], measures)


def _rms(errors: Array) -> float:
    return float(np.sqrt(np.mean(np.sum(errors**2, axis=1))))


def main(arguments: Sequence[str] | None = None) -> int:
    """Command line."""

    def run(workers: cluster.Workers, options: argparse.Namespace) -> Report:
        names = [name for name in SPOILERS if (options.only or "") in name]
        return measure(workers, names, options.trials, options.seed)

    return cluster.main(__doc__, run, 200, "trials each", arguments, has_names=True)


if __name__ == "__main__":
    sys.exit(main())
