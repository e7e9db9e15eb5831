# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Exports, each read with the program it is made for where there is one in the registries, else by its schema."""

from __future__ import annotations

import json
import math
import re
import shlex
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
import yaml
from pydantic import ValidationError
from scipy.spatial.transform import Rotation
from support import calibrations
from support.command_line import run
from urdf_parser_py.urdf import URDF

from cv_active_handeye.calibration import Calibration
from cv_active_handeye.cli.exporting import Form
from cv_active_handeye.export import FORMATS, FramePose, Frames, NotUsableError, export

GOLDEN = Path(__file__).parents[1] / "golden" / "export"
NUMBER = re.compile(r"-?\d+\.\d+(?:e[+-]?\d+)?|-?\d+e[+-]?\d+")
IN_HAND = Frames()
ON_BASE = Frames(mounting="eye-on-base", parent="world", child="ceiling_camera")


def calibration(**changes: Any) -> Calibration:
    """A refined result with rounded numbers, so that the golden files read well."""
    R = Rotation.from_euler("ZYX", [100, -35, 178], degrees=True).as_matrix()
    values = {
        "camera_matrix": [[1413.5, 0, 316.75], [0, 1414.25, 243.5], [0, 0, 1]],
        "distortion_coefficients": [-0.125, 0.0625, 0.0005, -0.00025, 0.0],
        "R_cam2gripper": R,
        "t_cam2gripper": [-0.005, 0.103, 1e-5],
    }
    return calibrations.refined(**(values | {"light_plane": [0.0, 0.6, 0.8, 0.3]} | changes))


def matrix_of(quaternion: list[float]) -> np.ndarray[Any, Any]:
    """R of a unit quaternion (x, y, z, w), written out."""
    x, y, z, w = quaternion
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


def fixed_axes(roll: float, pitch: float, yaw: float) -> np.ndarray[Any, Any]:
    """Rz(yaw) Ry(pitch) Rx(roll), as URDF and tf2's setRPY define it."""
    cr, sr, cp, sp, cy, sy = (f(angle) for angle in (roll, pitch, yaw) for f in (math.cos, math.sin))
    Rx = np.array([[1, 0, 0], [0, cr, -sr], [0, sr, cr]])
    Ry = np.array([[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]])
    Rz = np.array([[cy, -sy, 0], [sy, cy, 0], [0, 0, 1]])
    return np.asarray(Rz @ Ry @ Rx)


@pytest.mark.parametrize("angles", [(0.3, -1.2, 2.9), (3.1, 0.2, -3.1), (0.4, math.pi / 2, 0), (-1, -math.pi / 2, 0.5)])
def test_pose_of_frames_turns_by_quaternion_and_by_roll_pitch_yaw(angles: tuple[float, float, float]) -> None:
    R = fixed_axes(*angles)
    pose = FramePose.of(calibration(R_cam2gripper=R))
    np.testing.assert_allclose(matrix_of(list(pose.quaternion)), R, atol=1e-12)
    np.testing.assert_allclose(fixed_axes(*pose.rpy), R, atol=1e-9)
    assert pose.quaternion[3] >= 0
    assert pose.xyz == (-0.005, 0.103, 1e-5)


def test_opencv_is_read_by_file_storage_to_the_last_bit(tmp_path: Path) -> None:
    result = calibration()
    for frames, place in ((IN_HAND, "gripper"), (ON_BASE, "base")):
        file = tmp_path / f"{place}.yaml"
        file.write_text(export(result, "opencv", frames))
        storage = cv2.FileStorage(str(file), cv2.FILE_STORAGE_READ)
        assert (storage.getNode("image_width").real(), storage.getNode("image_height").real()) == (640, 480)
        keys = ("camera_matrix", "distortion_coefficients", f"R_cam2{place}", f"t_cam2{place}", "light_plane")
        read = {key: storage.getNode(key).mat() for key in keys}
        np.testing.assert_array_equal(read["camera_matrix"], result.camera_matrix)
        np.testing.assert_array_equal(read["distortion_coefficients"].ravel(), result.distortion_coefficients)
        np.testing.assert_array_equal(read[f"R_cam2{place}"], result.R_cam2gripper)
        np.testing.assert_array_equal(read[f"t_cam2{place}"].ravel(), result.t_cam2gripper)
        np.testing.assert_array_equal(read["light_plane"].ravel(), [0.0, 0.6, 0.8, 0.3])


def test_opencv_without_laser_has_no_light_plane() -> None:
    assert "light_plane" not in yaml.safe_load(export(calibration(light_plane=None), "opencv", IN_HAND))


def test_json_says_everything_and_null_for_what_is_not_known() -> None:
    covariance = calibration().covariance.copy()
    covariance[19, 19] = math.inf  # d of the light plane
    content = json.loads(export(calibration(covariance=covariance), "json", IN_HAND, name="wrist"))
    T = np.array(content["camera_to_parent"]["matrix"])
    np.testing.assert_array_equal(T[:3, :3], calibration().R_cam2gripper)
    np.testing.assert_array_equal(T[:, 3], [-0.005, 0.103, 1e-5, 1])
    np.testing.assert_allclose(matrix_of(content["camera_to_parent"]["quaternion_xyzw"]), T[:3, :3], atol=1e-12)
    np.testing.assert_allclose(fixed_axes(*content["camera_to_parent"]["rpy_fixed_axes"]), T[:3, :3], atol=1e-12)
    assert content["light_plane"] == {"normal": [0.0, 0.6, 0.8], "distance": 0.3}
    sigmas = content["standard_deviations"]
    assert sigmas["d"] is None
    assert sigmas["fx"] == calibration().standard_deviation("fx")
    assert (content["parent_frame"], content["child_frame"]) == ("tool0", "camera_optical_frame")


def test_ros1_command_has_nine_values_in_their_order() -> None:
    words = shlex.split(export(calibration(), "ros1", IN_HAND))
    assert words[:3] == ["rosrun", "tf2_ros", "static_transform_publisher"]
    assert len(words) == 3 + 9
    assert [float(word) for word in words[3:6]] == [-0.005, 0.103, 1e-5]
    np.testing.assert_allclose(matrix_of([float(w) for w in words[6:10]]), calibration().R_cam2gripper, atol=1e-12)
    assert words[10:] == ["tool0", "camera_optical_frame"]


def test_ros2_command_has_the_options_of_humble_and_later() -> None:
    words = shlex.split(export(calibration(), "ros2", ON_BASE))
    assert words[:4] == ["ros2", "run", "tf2_ros", "static_transform_publisher"]
    options = dict(zip(words[4::2], words[5::2], strict=True))
    assert set(options) == {f"--{key}" for key in ("x", "y", "z", "qx", "qy", "qz", "qw", "frame-id", "child-frame-id")}
    assert [float(options[f"--{axis}"]) for axis in "xyz"] == [-0.005, 0.103, 1e-5]
    quaternion = [float(options[f"--q{axis}"]) for axis in "xyzw"]
    np.testing.assert_allclose(matrix_of(quaternion), calibration().R_cam2gripper, atol=1e-12)
    assert (options["--frame-id"], options["--child-frame-id"]) == ("world", "ceiling_camera")


@pytest.mark.parametrize(
    ("frames", "type_", "base", "effector", "camera"),
    [
        (IN_HAND, "eye_in_hand", "base", "tool0", "camera_optical_frame"),
        (ON_BASE, "eye_on_base", "world", "tool0", "ceiling_camera"),
        (Frames(parent="flange", other="robot1_base"), "eye_in_hand", "robot1_base", "flange", "camera_optical_frame"),
    ],
)
def test_easy_handeye2_has_the_fields_of_its_messages(
    frames: Frames, type_: str, base: str, effector: str, camera: str
) -> None:
    """The fields and types of HandeyeCalibration.msg, HandeyeCalibrationParameters.msg and geometry_msgs/Transform."""
    content = yaml.full_load(export(calibration(), "easy-handeye2", frames, name="wrist"))
    assert set(content) == {"parameters", "transform"}
    strings = ["name", "calibration_type", "robot_base_frame", "robot_effector_frame", "tracking_base_frame"]
    strings += ["tracking_marker_frame", "move_group_namespace", "move_group"]
    parameters = content["parameters"]
    assert {key: type(value) for key, value in parameters.items()} == {
        **dict.fromkeys(strings, str),
        "freehand_robot_movement": bool,
    }
    assert [parameters[key] for key in strings[:5]] == ["wrist", type_, base, effector, camera]
    assert {key: list(value) for key, value in content["transform"].items()} == {
        "translation": list("xyz"),
        "rotation": list("xyzw"),
    }
    assert list(content["transform"]["translation"].values()) == [-0.005, 0.103, 1e-5]
    quaternion = [content["transform"]["rotation"][axis] for axis in "xyzw"]
    np.testing.assert_allclose(matrix_of(quaternion), calibration().R_cam2gripper, atol=1e-12)


def test_camera_info_has_what_camera_calibration_parsers_reads() -> None:
    content = yaml.safe_load(export(calibration(), "camera-info", IN_HAND, name="wrist"))
    sizes = {"camera_matrix": (3, 3), "distortion_coefficients": (1, 5), "rectification_matrix": (3, 3)}
    sizes["projection_matrix"] = (3, 4)
    read = {}
    for key, (rows, cols) in sizes.items():
        assert (content[key]["rows"], content[key]["cols"]) == (rows, cols)
        assert all(type(value) is float for value in content[key]["data"])
        read[key] = np.array(content[key]["data"]).reshape(rows, cols)
    assert (content["image_width"], content["image_height"], content["camera_name"]) == (640, 480, "wrist")
    assert content["distortion_model"] == "plumb_bob"
    K = calibration().camera_matrix
    np.testing.assert_array_equal(read["camera_matrix"], K)
    np.testing.assert_array_equal(read["distortion_coefficients"][0], calibration().distortion_coefficients)
    np.testing.assert_array_equal(read["rectification_matrix"], np.eye(3))
    np.testing.assert_array_equal(read["projection_matrix"], np.column_stack([K, np.zeros(3)]))


@pytest.mark.parametrize(("given", "written", "model"), [(4, 5, "plumb_bob"), (8, 8, "rational_polynomial")])
def test_camera_info_names_the_lens_model(given: int, written: int, model: str) -> None:
    text = export(calibration(distortion_coefficients=[0.01] * given), "camera-info", IN_HAND)
    content = yaml.safe_load(text)
    assert content["distortion_model"] == model
    assert content["distortion_coefficients"]["data"] == [0.01] * given + [0.0] * (written - given)


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"camera_matrix": [[1413.5, 0.25, 317], [0, 1414, 243], [0, 0, 1]]}, r"ROS ignores skew, .* has 0\.25 px"),
        ({"distortion_coefficients": [0.0] * 12}, r"ROS knows 4, 5 or 8 distortion coefficients, .* has 12"),
    ],
)
def test_camera_info_refuses_what_ros_cannot_hold(changes: dict[str, Any], told: str) -> None:
    with pytest.raises(ValueError, match=told):
        export(calibration(**changes), "camera-info", IN_HAND, force=True)


def test_urdf_is_read_by_the_parser_of_ros() -> None:
    snippet = export(calibration(), "urdf", Frames(parent="flange"))
    robot = URDF.from_xml_string(f'<robot name="r"><link name="flange"/>{snippet}</robot>')
    (joint,) = robot.joints
    assert (joint.type, joint.parent, joint.child) == ("fixed", "flange", "camera_optical_frame")
    assert {link.name for link in robot.links} == {"flange", "camera_optical_frame"}
    assert joint.origin.xyz == [-0.005, 0.103, 1e-5]
    np.testing.assert_allclose(fixed_axes(*joint.origin.rpy), calibration().R_cam2gripper, atol=1e-12)
    assert robot.get_chain("flange", "camera_optical_frame", joints=False) == ["flange", "camera_optical_frame"]


@pytest.mark.parametrize("form", FORMATS)
def test_export_gives_what_it_always_gave(form: str) -> None:
    """Golden files: whoever changes one changes what other people's programs read."""
    given = export(calibration(software_version="0.1.0"), form, IN_HAND, name="wrist")
    golden = (GOLDEN / f"{form}.txt").read_text()
    assert NUMBER.sub("#", given) == NUMBER.sub("#", golden)
    values, expected = ([float(text) for text in NUMBER.findall(whole)] for whole in (given, golden))
    np.testing.assert_allclose(values, expected, rtol=1e-9, atol=1e-15)


def test_closed_form_unusable_and_partial_results_are_refused() -> None:
    verdict = calibration().verdict
    assert verdict is not None
    bad = verdict.model_copy(update={"usable": False, "message": "the poses contradict the images"})
    covariance = calibration().covariance.copy()
    covariance[13, 13] = math.inf  # tx
    weak = verdict.model_copy(update={"weak_directions": ("t along the axis of the turns",)})
    cases = {
        r"closed form, which nothing has checked": calibrations.closed_form(),
        r"its verdict is: the poses contradict the images": calibration(verdict=bad),
        r"do not determine tx \(t along the axis of the turns\)": calibration(verdict=weak, covariance=covariance),
    }
    for told, result in cases.items():
        with pytest.raises(NotUsableError, match=told):
            export(result, "ros2", IN_HAND)
        assert export(result, "ros2", IN_HAND, force=True).startswith("ros2 run")


@pytest.mark.parametrize("name", ["/tool0", "", "tool 0", "tool;reboot", "0tool", "tool0\n"])
def test_frame_names_that_tools_do_not_take_are_refused(name: str) -> None:
    for key in ("parent", "child", "other"):
        with pytest.raises(ValidationError, match=key):
            Frames.model_validate({key: name})


def test_command_offers_every_format() -> None:
    assert [form.value for form in Form] == list(FORMATS)


def test_command_writes_a_file_or_to_the_terminal(tmp_path: Path) -> None:
    file = tmp_path / "calibration.yaml"
    calibration().save(file)
    shown = run("export", file, "--format", "ros2", "--parent", "flange", "--child", "wrist_camera")
    assert shown.exit_code == 0
    assert shown.output == export(calibration(), "ros2", Frames(parent="flange", child="wrist_camera"))
    output = tmp_path / "new" / "camera.yaml"
    written = run("export", file, "--format", "camera-info", "--name", "wrist", "-o", output)
    assert written.exit_code == 0
    assert output.read_text() == export(calibration(), "camera-info", IN_HAND, name="wrist")


def test_command_refuses_with_a_status_of_its_own_unless_forced(tmp_path: Path) -> None:
    file = tmp_path / "calibration.yaml"
    calibrations.closed_form().save(file)
    refused = run("export", file, "--format", "urdf", "-o", tmp_path / "camera.xacro")
    assert refused.exit_code == 5
    assert "not exported: it is a closed form" in refused.output
    assert not (tmp_path / "camera.xacro").exists()
    forced = run("export", file, "--format", "urdf", "-o", tmp_path / "camera.xacro", "--force")
    assert forced.exit_code == 0
    assert (tmp_path / "camera.xacro").exists()


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (("--format", "ros3"), "'ros3' is not one of"),
        (("--format", "ros2", "--parent", "/tool0"), "--parent"),
        (("--format", "ros2", "--other-frame", "a b"), "--other-frame"),
    ],
)
def test_command_tells_wrong_usage(tmp_path: Path, arguments: tuple[str, ...], told: str) -> None:
    file = tmp_path / "calibration.yaml"
    calibration().save(file)
    outcome = run("export", file, *arguments)
    assert outcome.exit_code == 2
    assert told in outcome.output
