# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Plans a motion, lets the arm make it, and calibrates, step by step: what `cv-active-handeye run` does.

Without a robot, the arm of the simulated cell in this process:

  python samples/python/06_plan_capture_calibrate.py out/sample --live

An emulated controller in another process (cv-active-handeye emulate ur, or emulate denso), spoken to as a real one:

  python samples/python/06_plan_capture_calibrate.py out/sample --robot ur --host 127.0.0.1 --live

A real station: --station station.yaml (doc/tutorials/first_calibration.md). Without --live nothing moves: the plan is
made, every way is checked, and the moves are printed. With it, a word has to be typed. Needs the extras workflow and
sim, and [ur] for a UR arm.
"""

import argparse
from pathlib import Path

from cv_active_handeye.robots.guard import GuardedRobot
from cv_active_handeye.robots.registry import open_robot
from cv_active_handeye.station import load_station
from cv_active_handeye.workflow import calibrate
from cv_active_handeye.workflow.dry_run import check_plan
from cv_active_handeye.workflow.event_log import EventLog
from cv_active_handeye.workflow.plan import make_plan
from cv_active_handeye.workflow.plan_views import start_of
from cv_active_handeye.workflow.planned_station import planning_of
from cv_active_handeye.workflow.reporter import Silent
from cv_active_handeye.workflow.run import record
from cv_active_handeye.workflow.stand import open_station

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("folder", nargs="?", type=Path, default=Path("out/sample"), help="a new folder for the data set")
parser.add_argument("--station", type=Path, help="station.yaml of a real station")
parser.add_argument("--robot", choices=["sim", "ur", "denso"], help="without a station file (default sim)")
parser.add_argument("--host", default="127.0.0.1", help="address of the emulated controller")
parser.add_argument("--stops", type=int, default=14, help="number of stops (default 14)")
parser.add_argument("--live", action="store_true", help="let the robot move, after a typed confirmation")
options = parser.parse_args()

said: dict[str, dict[str, object]] = {}
if options.station is None:
    said = {"camera": {"type": "sim"}, "laser": {"type": "camera_line"}, "robot": {"type": "sim", "speedup": 20}}
    if options.robot in ("ur", "denso"):
        model = "ur5e" if options.robot == "ur" else "denso_vp6242"
        said["robot"] = {"type": options.robot, "host": options.host, "model": model}
        said["camera"] = {"type": "sim", "host": options.host}
station = load_station(options.station, said)

# 1. From where the arm stands: the camera looks at the scene, about the stand-off of the settings away.
with open_robot(station.robot, live=False) as robot:
    settings = planning_of(station, robot, {"stops": options.stops, "target_sigma_mm": None})
    plan = make_plan(start_of(robot), settings, Silent())
    print(f"{robot.name}: {len(plan.stops)} stops")
    last = plan.predictions[-1]
    print(f"predicted standard deviations: position {last.t_cam2gripper_mm:.3f} mm, fx {last.fx_percent:.4f} %")

    # 2. Every way, from where the arm stands through all stops, before the first one is made.
    guard = GuardedRobot(robot, plan.workspace, station.speed, lambda kind, **told: None)
    for move in check_plan(guard, plan):
        print(f"stop {move.stop:2}: {1000 * move.length:5.0f} mm, {move.angle:5.1f} deg, {move.seconds:4.1f} s")

if not options.live:
    raise SystemExit("Nothing was moved. --live lets the robot do it.")
if input("Stand clear, emergency stop in reach. Type move to let it move: ").strip() != "move":
    raise SystemExit("Nothing was moved.")

# 3. Each view is on disk before the next move; leaving the block switches the laser off and gives the arm back.
options.folder.mkdir(parents=True, exist_ok=True)
with (
    EventLog(options.folder / "events.jsonl") as log,
    open_station(station, plan.workspace, live=True, event=log, ask=input, reporter=Silent()) as opened,
):
    dataset = record(options.folder, plan, opened, station.capture, log, Silent())

# 4. From the images and poses alone.
result = calibrate(dataset, station.calibration)
result.save(options.folder / "calibration.yaml")
print(result.verdict.message if result.verdict else "")
for name in result.parameter_names:
    ends = result.interval(name)
    print(f"{name:5} {'not estimated' if ends is None else f'{ends[0]:12.6g} to {ends[1]:12.6g}'}")
