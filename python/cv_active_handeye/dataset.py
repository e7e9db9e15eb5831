# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The recording of one calibration: a folder with `dataset.yaml` and `images/`, written view by view.

Lengths are metres, `R_gripper2base`, `t_gripper2base` map a point in the gripper frame into the base frame, as in
`cv::calibrateHandEye`. The description of every key is in doc/files.md.
"""

from __future__ import annotations

import hashlib
import json
from pathlib import Path
from typing import Any, cast

import cv2
import numpy as np
import yaml
from numpy.typing import NDArray

from . import files
from .dataset_format import CameraInfo, Content, LaserInfo, View
from .files import FileFormatError, FloatArray, check_schema_version, read_yaml, validate, write_atomic
from .point_files import read_board_points, read_image_points, write_board_points, write_image_points

__all__ = ["FILE_NAME", "CameraInfo", "Dataset", "Image", "LaserInfo", "View"]

SCHEMA_VERSION = 1
FILE_NAME = "dataset.yaml"
IMAGE_FOLDER = "images"
FARTHEST_VIEW = 20.0
"""Metres that no robot, or its linear axis, moves during a calibration."""

Image = NDArray[np.uint8] | NDArray[np.uint16]


# libyaml writes much faster, where PyYAML was built with it.
_Dumper: type[Any] = getattr(yaml, "CSafeDumper", yaml.SafeDumper)


class Dataset:
    """A data set on disk. `Dataset.create` starts one, `add_view` extends it, `Dataset.open` reads it."""

    def __init__(self, folder: Path, content: Content) -> None:
        self.folder = folder
        self._content = content

    @classmethod
    def create(
        cls,
        folder: str | Path,
        *,
        camera: CameraInfo,
        laser: LaserInfo | None = None,
        description: str = "",
        planned_views: int | None = None,
    ) -> Dataset:
        """Starts an empty data set; FileExistsError if `folder` holds one. `planned_views` lets `problems` count."""
        path = Path(folder)
        if (path / FILE_NAME).exists():
            raise FileExistsError(f"{path}: already holds a data set ({FILE_NAME}); choose another folder")
        (path / IMAGE_FOLDER).mkdir(parents=True, exist_ok=True)
        dataset = cls(path, Content(camera=camera, laser=laser, description=description, planned_views=planned_views))
        dataset._write(dataset._content)
        files.sync_directory(path.resolve().parent)
        return dataset

    @classmethod
    def open(cls, folder: str | Path) -> Dataset:
        """Opens a data set, complete or not (see `problems`); `FileFormatError` names what cannot be read."""
        path = Path(folder)
        if not (path / FILE_NAME).is_file():
            why = f"it holds no {FILE_NAME}" if path.is_dir() else "there is no such folder"
            raise FileFormatError(f"{path}: is not a data set: {why}")
        content = read_yaml(path / FILE_NAME, "data set")
        check_schema_version(path / FILE_NAME, content, "data set", SCHEMA_VERSION)
        return cls(path, validate(Content, content, path / FILE_NAME))

    @property
    def camera(self) -> CameraInfo:
        """What is known of the camera."""
        return self._content.camera

    @property
    def laser(self) -> LaserInfo | None:
        """What is known of the laser, None without one."""
        return self._content.laser

    @property
    def description(self) -> str:
        """Free text."""
        return self._content.description

    @property
    def views(self) -> tuple[View, ...]:
        """All stops recorded so far."""
        return self._content.views

    def __len__(self) -> int:
        return len(self.views)

    @property
    def R_gripper2base(self) -> FloatArray:
        """(V, 3, 3) rotations of the gripper in the base frame."""
        return np.array([view.R_gripper2base for view in self.views], dtype=np.float64).reshape(-1, 3, 3)

    @property
    def t_gripper2base(self) -> FloatArray:
        """(V, 3) positions of the gripper in the base frame, metres."""
        return np.array([view.t_gripper2base for view in self.views], dtype=np.float64).reshape(-1, 3)

    def add_view(
        self,
        R_gripper2base: Any,
        t_gripper2base: Any,
        *,
        image: Image | None = None,
        laser_image: Image | None = None,
        surface_id: int | None = None,
        timestamp: float | None = None,
    ) -> View:
        """Appends one stop: first its images, then `dataset.yaml`, each durable; a crash loses this view only.

        `image` is taken with the laser off, `laser_image` with the laser on, in the camera's size and pixel format.
        """
        index = len(self.views)
        view = validate(
            View,
            {
                "index": index,
                "R_gripper2base": R_gripper2base,
                "t_gripper2base": t_gripper2base,
                "image": None if image is None else f"{IMAGE_FOLDER}/{index:04d}.png",
                "laser_image": None if laser_image is None else f"{IMAGE_FOLDER}/{index:04d}_laser.png",
                "surface_id": surface_id,
                "timestamp": timestamp,
            },
            self.folder / f"view {index}",
        )
        for name, pixels in ((view.image, image), (view.laser_image, laser_image)):
            if name is not None and pixels is not None:
                self._write_image(name, pixels)
        self._write(self._content.model_copy(update={"views": (*self.views, view)}))
        return view

    def set_planned_views(self, planned_views: int) -> None:
        """Says how many views there will be, for `problems`: a capture may need fewer or more than it began with."""
        self._write(self._content.model_copy(update={"planned_views": planned_views}))

    def image(self, index: int) -> Image | None:
        """The laser-off image of a view, None where the view has none."""
        name = self.views[index].image
        return None if name is None else self._read_image(name)

    def laser_image(self, index: int) -> Image | None:
        """The laser-on image of a view, None where the view has none."""
        name = self.views[index].laser_image
        return None if name is None else self._read_image(name)

    def set_image_points(self, image_points: Any, board_points: Any = None) -> None:
        """Stores points found by other means: `image_points` (V, N, 2) px, NaN = not seen; `board_points` (N, 3) m."""
        points = np.asarray(image_points, dtype=np.float64)
        if points.ndim != 3 or points.shape[0] != len(self) or points.shape[2] != 2:
            raise ValueError(f"image_points: needs shape {len(self)}xNx2 (one block a view), given {points.shape}")
        update: dict[str, Any] = {"image_points": "image_points.csv", "board_points": None}
        write_image_points(self.folder / "image_points.csv", points)
        if board_points is not None:
            board = files.finite_array(board_points, (points.shape[1], 3))
            write_board_points(self.folder / "board_points.csv", board)
            update["board_points"] = "board_points.csv"
        self._write(self._content.model_copy(update=update))

    def image_points(self) -> FloatArray | None:
        """Stored points (V, N, 2) in pixels, NaN = not seen; None where the data set has none."""
        name = self._content.image_points
        return None if name is None else read_image_points(self.folder / name, len(self))

    def board_points(self) -> FloatArray | None:
        """Stored scene points (N, 3) in metres, NaN = unknown, row j belongs to row j of `image_points`; or None."""
        name = self._content.board_points
        return None if name is None else read_board_points(self.folder / name)

    def problems(self) -> list[str]:
        """What is missing or damaged, one sentence each; an empty list means complete."""
        found: list[str] = []
        planned = self._content.planned_views
        if planned is not None and len(self) < planned:
            found.append(
                f"{planned - len(self)} of {planned} planned views are missing (views {len(self)} to {planned - 1})"
            )
        elif not self.views:
            found.append("there are no views")
        for name in self._named_files():
            try:
                self._check_file(name)
            except (FileFormatError, OSError) as error:
                found.append(str(error))
        return found + self._strays() + self._distances()

    def sha256(self) -> str:
        """Hash of everything the data set says: the content of `dataset.yaml` and the bytes of every file it names."""
        digest = hashlib.sha256()
        digest.update(json.dumps(self._content.model_dump(), sort_keys=True).encode())
        for name in self._named_files():
            path = self.folder / name
            digest.update(hashlib.sha256(path.read_bytes()).digest() if path.is_file() else b"missing")
        return digest.hexdigest()

    def _named_files(self) -> list[str]:
        names = [name for view in self.views for name in (view.image, view.laser_image)]
        return [name for name in (*names, self._content.image_points, self._content.board_points) if name is not None]

    def _check_file(self, name: str) -> None:
        if name == self._content.image_points:
            self.image_points()
        elif name == self._content.board_points:
            self.board_points()
        else:
            self._read_image(name)

    def _strays(self) -> list[str]:
        known = set(self._named_files())
        stored = sorted(path for path in (self.folder / IMAGE_FOLDER).glob("*") if path.is_file())
        names = [name for path in stored if (name := path.relative_to(self.folder).as_posix()) not in known]
        if len(names) > 3:
            return [f"{names[0]} and {len(names) - 1} more: no view names these files (views that were not completed?)"]
        return [f"{name}: no view names this file (a view that was not completed?)" for name in names]

    def _distances(self) -> list[str]:
        if not self.views:
            return []
        farthest = float(np.linalg.norm(self.t_gripper2base - self.t_gripper2base[0], axis=1).max())
        if farthest <= FARTHEST_VIEW:
            return []
        return [f"t_gripper2base: the views are up to {farthest:.4g} m apart; needs metres, are these millimetres?"]

    def _write(self, content: Content) -> None:
        style: dict[str, Any] = {"sort_keys": False, "default_flow_style": None, "width": 200, "allow_unicode": True}
        text: str = yaml.dump(content.model_dump(), Dumper=_Dumper, **style)
        write_atomic(self.folder / FILE_NAME, text.encode())
        self._content = content

    def _write_image(self, name: str, pixels: Image) -> None:
        self._check_pixels(name, pixels)
        done, encoded = cv2.imencode(".png", np.ascontiguousarray(pixels))
        if not done:
            raise ValueError(f"{name}: the image could not be encoded as PNG")
        write_atomic(self.folder / name, encoded.tobytes())

    def _read_image(self, name: str) -> Image:
        path = self.folder / name
        if not path.is_file():
            raise FileFormatError(f"{name}: the file is missing")
        content = np.frombuffer(path.read_bytes(), np.uint8)
        pixels = cv2.imdecode(content, cv2.IMREAD_UNCHANGED) if content.size else None
        if pixels is None:
            raise FileFormatError(f"{name}: cannot be decoded as an image ({content.size} bytes)")
        try:
            self._check_pixels(name, pixels)
        except ValueError as error:
            raise FileFormatError(str(error)) from error
        return cast(Image, pixels)

    def _check_pixels(self, name: str, pixels: Any) -> None:
        camera = self.camera
        dtype = np.uint8 if camera.pixel_format.endswith("8") else np.uint16
        shape = (camera.height, camera.width) + ((3,) if camera.pixel_format.startswith("bgr") else ())
        if pixels.shape != shape or pixels.dtype != dtype:
            raise ValueError(
                f"{name}: the camera ({camera.pixel_format}) needs {np.dtype(dtype).name} of shape {shape}, "
                f"given {pixels.dtype} of shape {pixels.shape}"
            )
