# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Random trials of refineHandEye: bound reached, intervals that hold the truth, nothing silently wrong.

Few trials with wide limits; `refine.py`, `degenerate.py`, `robust.py`, `opencv_boards.py` in `benchmark` do thousands.
"""

from __future__ import annotations

import re

import numpy as np
import pytest

import cv_active_handeye as cah
from benchmark import degenerate, lens_models, opencv_boards, protocols, robust
from benchmark.degenerate_sets import KINDS, Kind, few_points, tiny_translations
from benchmark.protocol_sets import koide_set, visp_set
from benchmark.refine import QUANTITIES
from benchmark.refine_trials import Case, Outcomes, trial
from benchmark.stops import STOPS_12
from benchmark.world import NAMES, Noise

SEED = 21
CASES = (
    Case("24 stops"),
    Case("12 stops, k1 k2", stops=STOPS_12, distorted=True),
    Case("24 stops, 0.5 px, robot 0.1 mm / 0.03 deg", Noise(0.5, 0.1, 0.03)),
    Case("24 stops, stripes", stripes=True),
)


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_the_bound_is_reached_and_intervals_are_honest(case: Case) -> None:
    """30 trials know an RMS to 13 %, the coverage of a dozen intervals each, not independent, to about 3 %."""
    trials = 30
    pairs = [trial(case, SEED, number) for number in range(trials)]
    for found in (Outcomes(column) for column in zip(*pairs, strict=True)):
        assert not found.problems
        assert found.unusable <= 1
        for what, names in QUANTITIES.items():
            if names[0] in case.free or (case.stripes and names[0] in ("nx", "d")):
                at = [NAMES.index(name) for name in names]
                assert found.ratio(at) == pytest.approx(1, abs=0.45), what
                assert found.stated(at) == pytest.approx(1, abs=0.1), what
        assert np.mean(found.covered[:, [NAMES.index(name) for name in case.free]]) > 0.87


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.__name__)
def test_degenerate_sets_end_in_an_error_or_in_honest_intervals(kind: Kind) -> None:
    answers = [degenerate.trial(kind, SEED, number) for number in range(6)]
    assert all(answer.refused or np.isfinite(answer.misses).all() for answer in answers)
    assert degenerate.gross([answer for answer in answers if answer.usable]) == 0


def test_a_badly_determined_lens_that_holds_the_other_parameters_is_refused() -> None:
    """Five points: the best fit has k2 = 20 instead of 0.08, and the rotation 9 of its standard deviations off."""
    answer = degenerate.trial(few_points, 5001, 184)
    assert answer.refused
    assert "lens distortion: badly determined" in answer.text
    assert "hang on it" in answer.text


def test_a_scale_that_only_the_errors_of_the_robot_give_is_refused() -> None:
    """Groups of one reported place: the fit shrinks the scene to 6 mm and takes the robot for exact to 0.5 um."""
    answer = degenerate.trial(tiny_translations, 2001, 166)
    assert answer.refused
    assert re.search("t_cam2gripper along gripper .*(badly determined|not observed)", answer.text)


@pytest.mark.parametrize("name", robust.SPOILERS)
def test_what_is_wrong_is_named_and_does_not_spoil_the_result(name: str) -> None:
    found = [robust.trial(robust.SPOILERS[name], SEED, number) for number in range(3)]
    clean, spoiled = (np.array([one[i] for one in found]) for i in (0, 1))
    assert np.isfinite(spoiled).all()
    bounds = np.sqrt(np.mean(clean**2, axis=0))
    assert np.sqrt(np.mean(spoiled**2, axis=0))[bounds > 0] == pytest.approx(bounds[bounds > 0], abs=3 * bounds.max())
    assert np.mean([share for _, _, share, _ in found]) > 0.9


def test_a_group_with_the_orientation_of_another_does_not_place_the_scene() -> None:
    """Ten of 24 views count as one group, half of them with a wrong pose: the scene must come from the others alone."""
    _, spoiled, share, blamed = robust.trial(robust.SPOILERS["one group mislabelled"], 1, 124)
    assert np.isfinite(spoiled).all()
    assert (share, blamed) == (1.0, 0)


def test_a_lens_without_distortion_is_seen_as_such() -> None:
    case, lens = Case("24 stops"), lens_models.LENSES[0]
    chosen = [lens_models.trial(case, lens, SEED, number)[0].lens_model for number in range(12)]
    assert chosen.count(cah.LENS_FIXED) >= 9


def test_without_a_target_it_is_better_than_opencv_with_a_board() -> None:
    found = opencv_boards.Comparison([opencv_boards.trial(12, False, SEED, number) for number in range(8)])
    assert not any(found.failed.values())
    assert (found.rmse[opencv_boards.OURS[0]] < 0.5 * found.best).all()


def test_exact_data_of_a_board_give_the_exact_transform() -> None:
    exact = visp_set()
    assert protocols.our_errors(exact, exact.target2cam).max() < 1e-6


def test_a_noisy_robot_before_a_board_is_no_worse_than_by_opencv() -> None:
    errors = [
        protocols.images_trial(lambda rng: koide_set(rng, 0.1, 0.01, 0.01), SEED, number)[0] for number in range(10)
    ]
    rmse = np.sqrt(np.mean(np.square(errors), axis=0))
    assert (rmse[-1] <= 1.1 * rmse[:-1].min(axis=0)).all()


def test_refineHandEye_that_is_stuck_before_the_minimum_gives_no_answer() -> None:
    # The levels of an exact robot fall to their floor, and the corrections of the poses stay thirty times larger.
    answer = degenerate.trial(tiny_translations, 2001, 40)
    assert answer.refused
    assert "no convergence" in answer.text
