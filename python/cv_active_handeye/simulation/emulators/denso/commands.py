# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""What Robot_Execute, Controller_Execute and the variables of the emulated controller do."""

from __future__ import annotations

import re
from collections.abc import Callable

import numpy as np

from ....robots.base import Array, RobotError
from ....robots.bcap_codes import Result, result_meaning
from ....robots.bcap_packets import Value
from ....robots.denso_pose import numbers, p_from_matrix, t_from_matrix
from .controller import DensoController
from .errors import DESCRIPTIONS, OUT_OF_RANGE, Refusal, invalid
from .targets import Kind, Target

LOGGED = frozenset(("takearm", "givearm", "motor", "extspeed", "clearerror"))
"""Commands that change something; the others are asked a hundred times a second."""

_FIGURE = 5.0  # which elbow and wrist: not modelled
_OUT = 63  # bits of all six axes
_IO = re.compile(r"IO\[(\d{1,6})\]", re.IGNORECASE)


def robot_execute(controller: DensoController, client: object, command: str, parameter: Value) -> Value:
    """A command of the robot object; Refusal where there is none of this name, or it is refused."""
    name = command.lower()
    if name in controller.profile.missing or name not in _ROBOT:
        raise Refusal(Result.E_NOTIMPL)
    return _ROBOT[name](controller, client, parameter)


def controller_execute(controller: DensoController, command: str, parameter: Value) -> Value:
    """A command of the controller object."""
    name = command.lower()
    if name == "clearerror":
        controller.clear_errors()
        return None
    if name == "getcurerrorcount":
        return int(controller.error_code != 0)
    if name == "geterrordescription":
        code = int(_numbers(parameter, 1)[0]) & 0xFFFFFFFF
        return DESCRIPTIONS.get(code) or result_meaning(code) or f"error {code:08X}"
    raise Refusal(Result.E_NOTIMPL)


def variable(controller: DensoController, of_robot: bool, name: str) -> Value:
    """The value of a variable of the robot or controller object; Refusal where there is none."""
    io = _IO.fullmatch(name)
    if io and not of_robot:
        return controller.arm.outputs[_pin(controller, io)]
    values: dict[str, Callable[[], Value]] = {
        "@SERVO_ON": lambda: controller.motor,
        "@BUSY_STATUS": lambda: controller.arm.moving or not controller.arm.steady(),
        "@CURRENT_POSITION": lambda: _cur_pos(controller, None, None),
        "@CURRENT_ANGLE": lambda: _cur_jnt(controller, None, None),
    }
    if not of_robot:
        values = {
            "@MODE": lambda: controller.mode,
            "@ERROR_CODE": lambda: controller.error_code,
            "@EMERGENCY_STOP": lambda: controller.arm.stop_condition == "emergency stop",
            "@BUSY_STATUS": lambda: controller.arm.moving,
            "@VERSION": lambda: "2.0.0",
        }
    if name.upper() not in values:
        raise invalid(f"variable {name!r:.40} does not exist")
    return values[name.upper()]()


def put_variable(controller: DensoController, name: str, value: Value) -> None:
    """Sets a digital output, the only variable that can be set here."""
    io = _IO.fullmatch(name)
    if io is None or not isinstance(value, (bool, int)):
        raise invalid(f"variable {name!r:.40} cannot be set to {value!r:.40}")
    controller.arm.set_output(_pin(controller, io), bool(value))


def _pin(controller: DensoController, io: re.Match[str]) -> int:
    pin = int(io[1])
    if pin not in controller.arm.outputs:
        raise invalid(f"IO[{pin}] does not exist")
    return pin


def _numbers(parameter: Value, least: int) -> Array:
    """The numbers of a parameter that is a list or a single number."""
    try:
        values = list(parameter) if isinstance(parameter, (list, tuple)) else [parameter]
        return numbers(values, least, "parameter")
    except RobotError as error:
        raise invalid(str(error)) from error


def _take_arm(controller: DensoController, client: object, parameter: Value) -> Value:
    given = _numbers(parameter, 2) if parameter is not None else np.zeros(2)
    controller.take_arm(client, keep=bool(given[1]))
    return None


def _give_arm(controller: DensoController, client: object, parameter: Value) -> Value:
    controller.give_arm(client)
    return None


def _motor(controller: DensoController, client: object, parameter: Value) -> Value:
    controller.set_motor(client, bool(_numbers(parameter, 1)[0]))
    return None


def _ext_speed(controller: DensoController, client: object, parameter: Value) -> Value:
    values = _numbers(parameter, 1)
    acceleration = values[1] if len(values) > 1 else values[0] ** 2 / 100
    controller.set_external(client, float(values[0]), float(acceleration))
    return None


def _cur_pos(controller: DensoController, client: object, parameter: Value) -> Value:
    return p_from_matrix(controller.reading()[1], _FIGURE)


def _cur_trn(controller: DensoController, client: object, parameter: Value) -> Value:
    return t_from_matrix(controller.reading()[1], _FIGURE)


def _cur_jnt(controller: DensoController, client: object, parameter: Value) -> Value:
    return _joint_values(controller.reading()[2])


def _high_cur_pos(controller: DensoController, client: object, parameter: Value) -> Value:
    clock, pose, _ = controller.reading()
    return [float(round(1000 * clock)), *p_from_matrix(pose, _FIGURE)]


def _high_cur_jnt(controller: DensoController, client: object, parameter: Value) -> Value:
    clock, _, joints = controller.reading()
    return [float(round(1000 * clock)), *_joint_values(joints)]


def _joint_values(joints: Array) -> list[Value]:
    return [*map(float, np.degrees(joints)), 0.0, 0.0]


def _converted(source: Kind, wanted: Kind) -> Callable[[DensoController, object, Value], Value]:
    """The controller's own conversion of pose data, bare values or [values, ...]."""

    def convert(controller: DensoController, client: object, parameter: Value) -> Value:
        values = parameter
        if isinstance(parameter, (list, tuple)) and parameter and isinstance(parameter[0], (list, tuple)):
            values = parameter[0]
        target = Target.parse([values, source])
        if wanted == "J":
            return _joint_values(controller.joints_of(target))
        pose = (
            controller.arm.arm.forward(np.radians(target.values[:6]))
            if source == "J"
            else target.matrix(controller.convention)
        )
        return p_from_matrix(pose, _FIGURE) if wanted == "P" else t_from_matrix(pose, _FIGURE)

    return convert


def _out_range(controller: DensoController, client: object, parameter: Value) -> Value:
    if not isinstance(parameter, (list, tuple)) or len(parameter) != 3:
        raise invalid("OutRange: needs [[values, type], tool, work]")
    target = Target.parse(parameter[0])
    if controller.arm.faults.take("unreachable"):
        return _OUT
    try:
        controller.joints_of(target)
    except Refusal as refusal:
        if refusal.code != OUT_OF_RANGE:
            raise
        return _OUT
    return 0


_ROBOT: dict[str, Callable[[DensoController, object, Value], Value]] = {
    "takearm": _take_arm,
    "givearm": _give_arm,
    "motor": _motor,
    "extspeed": _ext_speed,
    "curpos": _cur_pos,
    "curjnt": _cur_jnt,
    "curtrn": _cur_trn,
    "highcurposex": _high_cur_pos,
    "highcurjntex": _high_cur_jnt,
    "curtool": lambda controller, client, parameter: controller.tool,
    "curwork": lambda controller, client, parameter: controller.work,
    "getrobottypename": lambda controller, client, parameter: controller.arm.arm.name,
    "p2t": _converted("P", "T"),
    "t2p": _converted("T", "P"),
    "j2p": _converted("J", "P"),
    "p2j": _converted("P", "J"),
    "j2t": _converted("J", "T"),
    "t2j": _converted("T", "J"),
    "outrange": _out_range,
}
