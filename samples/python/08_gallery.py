# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The pictures of doc/gallery.md: what the software does, drawn from a simulated recording.

motion.png       where the robot stopped, and what the camera looked at
foe.png          all displacements of one translation meet in the focus of expansion
stripe.png       a laser stripe with its straight pieces, and how far it is from the calibrated plane's prediction
ellipsoids.png   where the camera is in the gripper, and where a point of the scene is, with 95 % ellipsoids
stops.png        accuracy against the number of stops, from the tables of doc/accuracy.md
frames.png       the frames and their names

Run: python samples/python/08_gallery.py out/gallery          (about a minute; needs the extras workflow and sim)
"""

import argparse
import re
from pathlib import Path

import cv2
import numpy as np
from matplotlib.figure import Figure

import cv_active_handeye as cah
from cv_active_handeye.report.pictures import GROUP_COLOURS, save_figure
from cv_active_handeye.simulation import CellConfig
from cv_active_handeye.workflow import calibrate_with_evidence
from cv_active_handeye.workflow.pictures import draw_pictures
from cv_active_handeye.workflow.simulate import simulate

ROOT = Path(__file__).parents[2]
AXIS_COLOURS = ("#d62728", "#2ca02c", "#1f77b4")
CHI2_95 = 7.815  # three degrees of freedom


def draw_foe(path, dataset, evidence, first, second):
    """Displacements of the points from view `first` to view `second`, and the lines that meet in the FOE."""
    seen = np.isfinite(evidence.image_points[[first, second]]).all(axis=(0, 2))
    start, end = evidence.image_points[[first, second]][:, seen]
    _, foe, mask, covariance = cah.estimateFOE(start, end)
    centre = foe[:2, 0] / foe[2, 0]
    to_pixel = np.column_stack([np.eye(2), -centre]) / foe[2, 0]
    sigma = np.sqrt(np.diag(to_pixel @ covariance @ to_pixel.T))
    figure = Figure(figsize=(8, 8.4), layout="constrained")
    axes = figure.add_subplot()
    image = dataset.image(first)
    axes.imshow(image, cmap="gray")
    for x1, x2, inlier in zip(start, end, mask[:, 0], strict=True):
        colour = GROUP_COLOURS[0] if inlier else GROUP_COLOURS[1]
        if inlier:
            axes.plot(*np.array([centre, x1]).T, color=colour, linewidth=0.4, alpha=0.35)
        axes.annotate("", x2, x1, arrowprops={"arrowstyle": "->", "color": colour, "linewidth": 1.3})
    axes.plot(*centre, "*", color="#ffe14d", markersize=20, markeredgecolor="black")
    height, width = image.shape[:2]
    axes.set(xlim=(min(0, centre[0] - 20), max(width, centre[0] + 20)), xlabel="u [px]", ylabel="v [px]")
    axes.set_ylim(max(height, centre[1] + 20), min(0, centre[1] - 20))
    axes.set_title(
        f"Views {first} and {second}: {mask.sum()} displacements meet in the focus of expansion\n"
        f"({centre[0]:.2f} ± {sigma[0]:.2f}, {centre[1]:.2f} ± {sigma[1]:.2f}) px",
        loc="left",
    )
    save_figure(figure, path)


def draw_stripe_residuals(path, dataset, evidence):
    """The stripe of the view with most pieces, and the distances of its pieces' ends from their predictions."""
    residuals = evidence.summary.stripeResiduals
    used = np.isfinite(residuals).all(axis=1)
    counts = np.bincount([s.view for s, kept in zip(evidence.segments, used, strict=True) if kept])
    view = int(counts.argmax())
    figure = Figure(figsize=(9, 8.6), layout="constrained")
    above, below = figure.subplots(2, 1, height_ratios=(3, 1.2))
    above.imshow(dataset.laser_image(view), cmap="gray")
    for number, segment in enumerate(evidence.segments):
        ends = segment.points[[0, -1], 0]
        colour = GROUP_COLOURS[segment.surface % len(GROUP_COLOURS)] if segment.surface >= 0 else "#b0b0b0"
        if segment.view == view:
            above.plot(*segment.points.T, color=colour, linewidth=3)
        if used[number]:
            below.plot(ends, residuals[number], color=colour, linewidth=0.9, alpha=1 if segment.view == view else 0.35)
    rms = np.sqrt(np.mean(residuals[used] ** 2))
    above.set(xlabel="u [px]", ylabel="v [px]", title=f"Laser stripe of view {view}, one colour a surface")
    below.axhline(0, color="0.3", linewidth=0.8)
    below.set(xlim=above.get_xlim(), xlabel="u [px]", ylabel="residual [px]")
    below.set_title(f"All views: ends of the straight pieces from their predictions, RMS {rms:.3f} px", loc="left")
    save_figure(figure, path)


def ellipsoid(covariance):
    """Surface of the 95 % ellipsoid, (40, 40, 3)."""
    u, v = np.meshgrid(np.linspace(0, 2 * np.pi, 40), np.linspace(0, np.pi, 40))
    sphere = np.stack([np.cos(u) * np.sin(v), np.sin(u) * np.sin(v), np.cos(v)], axis=-1)
    values, vectors = np.linalg.eigh(covariance)
    return np.sqrt(CHI2_95) * sphere * np.sqrt(values) @ vectors.T


def draw_ellipsoids(path, summary, error_mm):
    """95 % ellipsoids of t_cam2gripper, with its true error, and of a point at the working distance, mm."""
    covariance = summary.covariance[13:16, 13:16] * 1e6
    panels = (
        (covariance, "t_cam2gripper; the cross is the truth"),
        (summary.toolCovariance * 1e6, f"a point of the scene, {1000 * summary.workingDistance:.0f} mm away"),
    )
    figure = Figure(figsize=(11, 5.6), layout="constrained")
    for number, (matrix, title) in enumerate(panels):
        axes = figure.add_subplot(1, 2, number + 1, projection="3d")
        surface = ellipsoid(matrix)
        axes.plot_surface(*np.moveaxis(surface, -1, 0), color=GROUP_COLOURS[2 * number], alpha=0.35, linewidth=0)
        reach = 1.05 * max(np.abs(surface).max(), np.abs(error_mm).max() if number == 0 else 0)
        axes.set(xlim=(-reach, reach), ylim=(-reach, reach), zlim=(-reach, reach), title=title)
        axes.set(xlabel="x [mm]", ylabel="y [mm]", zlabel="z [mm]")
        if number == 0:
            axes.scatter(*error_mm, color="black", marker="x", s=70)
        axes.locator_params(nbins=5)
        axes.set_box_aspect((1, 1, 1))
    figure.suptitle("95 % ellipsoids in the gripper frame")
    save_figure(figure, path)


def accuracy_rows(robot):
    """(stops, way, RMSE of t in mm, motor time in s) of "Accuracy against number of stops"."""
    text = (ROOT / "doc/accuracy.md").read_text(encoding="utf-8").partition("### Accuracy against number of stops")[2]
    rows = [[cell.strip() for cell in line.split("|")[1:-1]] for line in re.findall(rf"^\| {robot} .*", text, re.M)]
    return [(int(row[1]), row[2], float(row[4]), float(row[7])) for row in rows]


def draw_stops(path, robot="ur5e"):
    """RMSE of t_cam2gripper over stops and over motor time."""
    rows = accuracy_rows(robot)
    figure = Figure(figsize=(10, 4.8), layout="constrained")
    columns = (0, "stops"), (3, "motor time [s]")
    for axes, (column, label) in zip(figure.subplots(1, 2, sharey=True), columns, strict=True):
        for colour, way in zip(GROUP_COLOURS, dict.fromkeys(row[1] for row in rows), strict=False):
            line = sorted((row[column], row[2]) for row in rows if row[1] == way)
            axes.plot(*np.array(line).T, "o-", color=colour, label=way)
        axes.set(xlabel=label, yscale="log")
        axes.grid(visible=True, which="both", alpha=0.3)
    figure.axes[0].set_ylabel("RMSE of t_cam2gripper [mm]")
    figure.axes[0].legend()
    figure.suptitle(f"What a stop brings ({robot}, 0.1 px, robot 0.02 mm / 0.005 deg)")
    save_figure(figure, path)


def draw_frame(axes, name, origin, R, size, label):
    """Three arrows, and a name beside them."""
    for k, colour in enumerate(AXIS_COLOURS):
        axes.quiver(*origin, *(size * R[:, k]), color=colour, linewidth=2, arrow_length_ratio=0.15)
    axes.text(*np.add(origin, label), name, fontsize=12, weight="bold")


def draw_frames(path):
    """Base, gripper and camera, the light plane and a point of the scene."""
    down = np.diag([1.0, -1.0, -1.0])
    cos, sin = np.cos(np.radians(18)), np.sin(np.radians(18))
    camera_R = np.array([[cos, 0, sin], [0, 1, 0], [-sin, 0, cos]]) @ down
    gripper, camera, point = np.array([0.4, 0, 0.75]), np.array([0.8, 0, 0.66]), np.array([0.6, 0.05, 0.02])
    figure = Figure(figsize=(8, 6.2), layout="constrained")
    axes = figure.add_subplot(projection="3d")
    draw_frame(axes, "base", np.zeros(3), np.eye(3), 0.16, (-0.02, 0, -0.08))
    draw_frame(axes, "gripper", gripper, down, 0.14, (-0.05, 0, 0.05))
    draw_frame(axes, "cam", camera, camera_R, 0.13, (0.03, 0, 0.05))
    for a, b, text, offset in (
        (np.zeros(3), gripper, "R_gripper2base\nt_gripper2base", (-0.3, 0, 0.04)),
        (gripper, camera, "R_cam2gripper\nt_cam2gripper", (-0.03, 0, 0.06)),
    ):
        axes.plot(*np.array([a, b]).T, color="0.5", linestyle="--")
        axes.text(*((a + b) / 2 + offset), text, fontsize=10, color="0.25")
    axes.plot(*np.array([camera, point]).T, color=GROUP_COLOURS[4], linewidth=1.2)
    axes.scatter(*point, color="black", s=25)
    axes.text(*np.add(point, [-0.02, 0, 0.04]), "X", fontsize=12)
    fan = np.array([np.add(camera, [0.1, 0, 0]), [0.6, -0.25, 0.02], [0.6, 0.25, 0.02]])
    axes.plot_trisurf(*fan.T, triangles=[[0, 1, 2]], color=GROUP_COLOURS[1], alpha=0.2)
    axes.plot(*fan[1:].T, color=GROUP_COLOURS[1], linewidth=2.5)
    axes.text(0.82, 0.1, 0.3, "light plane\nn·X = d", fontsize=10, color=GROUP_COLOURS[1])
    axes.set(xlim=(0, 0.9), ylim=(-0.3, 0.3), zlim=(0, 0.8))
    axes.set_box_aspect((0.9, 0.6, 0.8), zoom=1.35)
    axes.view_init(elev=14, azim=-66)
    axes.set_axis_off()
    save_figure(figure, path)


def towards_the_scene(dataset, calibration):
    """Two views of one orientation, moved as much along the optical axis as any: the FOE is near the image."""
    groups = cah.groupViews(dataset.R_gripper2base)[:, 0]
    axes = dataset.R_gripper2base @ calibration.R_cam2gripper[:, 2]
    pairs = [(i, j) for i in range(len(groups)) for j in range(len(groups)) if i != j and groups[i] == groups[j]]

    def along(pair):
        moved = dataset.t_gripper2base[pair[1]] - dataset.t_gripper2base[pair[0]]
        return moved @ axes[pair[0]] / np.linalg.norm(moved)

    return max(pairs, key=along)


def draw_all(folder):
    """Draw everything into the folder."""
    draw_frames(folder / "frames.png")
    draw_stops(folder / "stops.png")
    dataset, truth = simulate(folder / "dataset", folder / "truth.yaml", CellConfig(seed=1, robot="ur5e"))
    calibration, evidence = calibrate_with_evidence(dataset)
    draw_pictures(folder, dataset, calibration, evidence)
    draw_foe(folder / "foe.png", dataset, evidence, *towards_the_scene(dataset, calibration))
    draw_stripe_residuals(folder / "stripe.png", dataset, evidence)
    error_mm = 1000 * (truth.t_cam2gripper - calibration.t_cam2gripper)
    draw_ellipsoids(folder / "ellipsoids.png", evidence.summary, error_mm)
    print(*sorted(folder.glob("*.png")), sep="\n")


def write_into_documentation(folder):
    """Small copies for doc/gallery.md and for the pages of the C++ module."""
    for name in ("motion", "foe", "stripe", "ellipsoids", "stops"):
        picture = cv2.imread(str(folder / f"{name}.png"))
        cv2.imwrite(str(ROOT / f"doc/pictures/gallery/{name}.jpg"), picture, [cv2.IMWRITE_JPEG_QUALITY, 85])
    frames = ROOT / "modules/active_handeye/doc/pics/active_handeye_frames.png"
    cv2.imwrite(str(frames), cv2.imread(str(folder / "frames.png")))


def main():
    """Draw; with --write also into the documentation."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, nargs="?", default=Path("out/gallery"))
    parser.add_argument("--write", action="store_true", help="copy them into the documentation of this repository")
    options = parser.parse_args()
    draw_all(options.folder)
    if options.write:
        write_into_documentation(options.folder)


if __name__ == "__main__":
    main()
