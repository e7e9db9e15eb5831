# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""A station file says which robot, camera and laser there are; what the command line says comes on top."""

from __future__ import annotations

from pathlib import Path

import pytest

from cv_active_handeye.files import FileFormatError
from cv_active_handeye.robots.denso_config import DensoConfig
from cv_active_handeye.robots.ur import UrConfig
from cv_active_handeye.station import load_station, merged

TEXT = """\
schema_version: 1
robot: {type: ur, host: 192.0.2.7, freshness_s: 0.3}
camera: {type: opencv, source: 2}
laser: {type: robot_output, pin: 3}
speed: {metres_per_second: 0.1}
"""


def written(folder: Path, text: str = TEXT) -> Path:
    file = folder / "station.yaml"
    file.write_text(text)
    return file


def test_command_line_comes_on_top_of_the_file_key_by_key(tmp_path: Path) -> None:
    station = load_station(written(tmp_path), {"robot": {"host": "192.0.2.8"}, "laser": {"type": "none"}})
    assert isinstance(station.robot, UrConfig)
    assert (station.robot.host, station.robot.freshness_s) == ("192.0.2.8", 0.3)
    assert station.laser.type == "none"
    assert station.speed.metres_per_second == 0.1


def test_another_kind_of_robot_keeps_nothing_of_the_one_in_the_file(tmp_path: Path) -> None:
    station = load_station(written(tmp_path), {"robot": {"type": "denso", "host": "192.0.2.9"}})
    assert isinstance(station.robot, DensoConfig)
    assert merged({"a": {"type": "x", "n": 1}}, {"a": {"type": "x", "m": 2}}) == {"a": {"type": "x", "n": 1, "m": 2}}
    assert merged({"a": {"type": "x", "n": 1}}, {"a": {"type": "y"}}) == {"a": {"type": "y"}}


@pytest.mark.parametrize(
    ("old", "new", "text"),
    [
        ("freshness_s", "freshnes_s", r"key 'robot\.freshnes_s' is unknown \(did you mean 'freshness_s'\?\)"),
        ("freshness_s: 0.3", "freshness_s: 9", r"key 'robot\.freshness_s': .*less than or equal to 1, given 9$"),
        ("freshness_s", "colour", r"key 'robot\.colour' is unknown$"),
        ("speed: {metres_per_second: 0.1}", "speed: {metres_per_second: 0.5}", "speed.metres_per_second"),
        ("type: ur", "type: abb", "robot"),
        ("schema_version: 1", "schema_version: 9", "reads version 1 of the station file, the file says 9"),
        ("camera: {type: opencv, source: 2}\n", "", "'camera' is missing"),
        ("laser:", "lazer:", "'lazer' is unknown"),
    ],
)
def test_wrong_keys_and_values_are_refused_by_name(tmp_path: Path, old: str, new: str, text: str) -> None:
    assert old in TEXT
    with pytest.raises(FileFormatError, match=text):
        load_station(written(tmp_path, TEXT.replace(old, new)), {})
