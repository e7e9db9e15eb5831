# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The command `emulate`: a robot's controller to practise with, without the robot."""

from __future__ import annotations

import ipaddress
import signal
import time
from collections.abc import Callable
from contextlib import AbstractContextManager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from .application import Settings, app, print_line, print_lines
from .console import told_errors
from .helping import command_of
from .settings import cell_config

if TYPE_CHECKING:
    from ..simulation.emulators import EmulatedArm, ListenError
    from ..simulation.emulators.log import Event

emulators = typer.Typer(no_args_is_help=True, rich_markup_mode="rich")
app.add_typer(
    emulators,
    name="emulate",
    help="Acts as a robot's controller on this machine, to practise without a robot. Ctrl-C ends it.",
)
command = command_of(emulators)

_END_S = 0.05  # between looks whether somebody has ended the emulator

Host = Annotated[str, typer.Option(help="Address to listen on: 127.0.0.1, or 127.0.0.2, ... for several emulators.")]
Seed = Annotated[int, typer.Option(min=0, help="Seed of the simulated cell and of the arm's errors.")]
Speedup = Annotated[
    float, typer.Option(min=0.1, max=1000, help="How much faster than a real arm it moves and settles.")
]
ControlPortNumber = Annotated[
    int, typer.Option("--control-port", min=0, max=65535, help="Port for faults and for the simulated camera; 0 = any.")
]
Fault = Annotated[
    list[str] | None,
    typer.Option(
        help="What goes wrong: NAME[=VALUE], at once, after SECONDS (@SECONDS), when the arm stands for the Nth time "
        "(@stopN) or in its Nth motion (@moveN). Several times for several faults."
    ),
]
LogFile = Annotated[Path | None, typer.Option(help="File for every event, one JSON object a line.")]
ListFaults = Annotated[bool, typer.Option("--list-faults", help="List the faults with their default values.")]
AllowNetwork = Annotated[bool, typer.Option("--allow-network", help="Listen on an address that others can reach.")]


@command(
    "emulate ur",
    "emulate ur --version 5.23 --fault protective_stop@move3 --log events.jsonl",
    "emulate ur --fault slow_settling=2 --fault drop_link@30",
)
def ur(
    host: Host = "127.0.0.1",
    robot: Annotated[str, typer.Option(help="The arm: ur5e.")] = "ur5e",
    seed: Seed = 0,
    version: Annotated[str, typer.Option(help="PolyScope: 3.15, 5.4, 5.11, 5.23 or 10.11 (PolyScope X).")] = "5.11",
    speedup: Speedup = 1.0,
    control_port: ControlPortNumber = 30020,
    fault: Fault = None,
    log: LogFile = None,
    list_faults: ListFaults = False,
    allow_network: AllowNetwork = False,
) -> None:
    """Acts as a UR controller: RTDE (port 30004), programs (30003) and dashboard (29999), for ur_rtde as it is.

    The arm stands over the same workbench as that of simulate, with the same errors; the simulated camera sees what it
    would see there. Faults can be given here, or set at run time on the control port, where `clear` is the person at
    the pendant. Nothing here was compared with a real controller.
    """
    with told_errors(Settings.debug):
        from ..simulation.emulators.ur import VERSIONS, UrEmulator

        if list_faults:
            print_faults()
            return
        check_host(host, allow_network)
        if robot != "ur5e":
            raise typer.BadParameter(f"needs ur5e, given {robot}", param_hint="--robot")
        if version not in VERSIONS:
            raise typer.BadParameter(f"needs one of {', '.join(VERSIONS)}, given {version}", param_hint="--version")
        arm = emulated_arm(robot, seed, speedup, log, fault or [])
        serve(arm, lambda: UrEmulator(arm, host, version), host, control_port, f"UR controller {version}")


@command(
    "emulate denso",
    "emulate denso --controller rc9 --fault emergency_stop@move2 --log events.jsonl",
    "emulate denso --fault frozen_timestamp@30",
)
def denso(
    host: Host = "127.0.0.1",
    port: Annotated[int, typer.Option(min=0, max=65535, help="Port of b-CAP; 0 = any.")] = 5007,
    robot: Annotated[str, typer.Option(help="The arm: denso_vp6242.")] = "denso_vp6242",
    seed: Seed = 0,
    controller: Annotated[str, typer.Option(help="rc8, rc9, or rc7 (fewer commands).")] = "rc8",
    speedup: Speedup = 1.0,
    control_port: ControlPortNumber = 30020,
    fault: Fault = None,
    log: LogFile = None,
    list_faults: ListFaults = False,
    allow_network: AllowNetwork = False,
) -> None:
    """Acts as a DENSO controller: b-CAP (port 5007).

    The arm stands over the same workbench as that of simulate, with the same errors; the simulated camera sees what it
    would see there. Faults can be given here, or set at run time on the control port, where `clear` is the person at
    the pendant. Nothing here was compared with a real controller.
    """
    with told_errors(Settings.debug):
        from ..simulation.emulators import ListenError
        from ..simulation.emulators.denso import DENSO_FAULTS, PROFILES, DensoEmulator

        if list_faults:
            print_faults(DENSO_FAULTS)
            return
        check_host(host, allow_network)
        profile = next((profile for profile in PROFILES.values() if profile.name == controller), None)
        if profile is None:
            text = f"needs one of {', '.join(PROFILES)}, given {controller}"
            raise typer.BadParameter(text, param_hint="--controller")
        arm = emulated_arm(robot, seed, speedup, log, fault or [], DENSO_FAULTS)
        try:
            emulator = DensoEmulator(arm, host=host, port=port, controller=profile.name)
        except ListenError as error:
            arm.close()
            raise cannot_listen(error) from error
        serve(arm, lambda: emulator, host, control_port, f"DENSO controller {controller}, port {emulator.port},")


def emulated_arm(
    robot: str, seed: int, speedup: float, log: Path | None, faults: list[str], known: frozenset[str] | None = None
) -> EmulatedArm:
    """The arm of the options, whose events are printed as they happen; `known`: the device's faults, None = all."""
    from ..simulation.emulators import FAULTS, EmulatedArm, EventLog, FaultPlan, Faults

    try:
        events = EventLog(log, _print_event)
    except OSError as error:
        raise typer.BadParameter(f"{log}: cannot be written: {error.strerror}", param_hint="--log") from error
    device = Faults(events, frozenset(FAULTS) if known is None else known)
    arm = EmulatedArm(cell_config(robot=robot, seed=seed), speedup=speedup, log=events, faults=device)
    try:
        for text in faults:
            arm.faults.plan(FaultPlan.parse(text))
    except ValueError as error:
        raise typer.BadParameter(str(error), param_hint="--fault") from error
    return arm


def check_host(host: str, allow_network: bool) -> None:
    """Refuses an address that others can reach, unless that is wanted."""
    try:
        address = ipaddress.ip_address(host)
    except ValueError as error:
        raise typer.BadParameter(f"needs an address such as 127.0.0.1, given {host!r}", param_hint="--host") from error
    if not address.is_loopback and not allow_network:
        text = f"{host} can be reached by others, who would take it for a robot; --allow-network permits it"
        raise typer.BadParameter(text, param_hint="--host")


def print_faults(known: frozenset[str] | None = None) -> None:
    """The names for --fault; `known`: the device's, None = all."""
    from ..simulation.emulators import FAULTS

    shown = [name for name in FAULTS if known is None or name in known]
    print_lines(*(f"{name}={FAULTS[name][0]:g}  {FAULTS[name][1]}" for name in shown))


def cannot_listen(error: ListenError) -> typer.BadParameter:
    """What to say of a port that cannot be listened on, with the option that helps."""
    option, cure = {
        "control": ("--control-port", "--control-port 0 chooses a free one"),
        "b-CAP": ("--port", "--port 0 chooses a free one"),
    }.get(error.service, ("--host", "its number is fixed; give another --host, 127.0.0.2 for example"))
    end = "end what listens there, or " if error.taken else ""
    return typer.BadParameter(f"{error}: {end}{cure}", param_hint=option)


def serve(
    arm: EmulatedArm,
    open_ports: Callable[[], AbstractContextManager[object]],
    host: str,
    control_port: int,
    name: str,
) -> None:
    """Opens a controller's ports (`open_ports()`, a context manager) and the control port, until somebody ends it."""
    from ..simulation.emulators import ControlPort, ListenError

    ended: list[bool] = []  # no lock: a second signal may come while the first is being handled
    previous = {n: signal.signal(n, lambda *_: ended.append(True)) for n in (signal.SIGINT, signal.SIGTERM)}
    try:
        with open_ports():
            control = ControlPort(arm, host, control_port, lambda: ended.append(True))
            print_line(f"ready {name} on {host}, {arm.arm.name}, control {host}:{control.port}")
            while not ended:
                time.sleep(_END_S)
            control.close()
    except ListenError as error:
        raise cannot_listen(error) from error
    finally:
        arm.close()
        arm.log.close()
        for number, handler in previous.items():
            signal.signal(number, handler)
    print_lines("ended")


def _print_event(event: Event) -> None:
    """A line for what a person at the pendant would see, or should know."""
    kind = event["kind"]
    texts: dict[str, Callable[[], str]] = {
        "connect": lambda: f"{event['service']}: client {event['peer']} connected",
        "disconnect": lambda: f"{event['service']}: client {event['peer']} left",
        "command": lambda: f"command {event['name']} {' '.join(_short(x) for x in event['args'])}",
        "motion_end": lambda: f"motion {event['motion']} {'arrived' if event['arrived'] else 'stopped'}",
        "fault": lambda: f"fault {event['name']} {'ended' if not event['value'] else _short(event['value'])}",
        "stop_condition": lambda: f"STOP: {event['reason']}",
        "cleared": lambda: "cleared by the person at the pendant",
        "output": lambda: f"output {event['pin']} {'on' if event['on'] else 'off'}",
        "violation": lambda: f"VIOLATION: {event['text']}",
    }
    question = kind == "command" and event["name"].startswith(("is", "get"))
    if kind in texts and not question and event.get("service") != "control":
        print_lines(texts[kind]())


def _short(value: object) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)
