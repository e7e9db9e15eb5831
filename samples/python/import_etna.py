# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Imports one folder of the etna recording: chessboard views of a laser head, the laser line is in every image.

Example: python samples/python/import_etna.py data/etna_abb_laser/main out/etna
"""

from import_common import arguments, import_folder

from cv_active_handeye.dataset import CameraInfo, LaserInfo

if __name__ == "__main__":
    given = arguments(__doc__)
    camera = CameraInfo(width=1280, height=1024, pixel_format="mono8", name="laser triangulation head on an ABB robot")
    laser = LaserInfo(stripe="vertical", sigma_px=4.0)
    import_folder(given.source, given.dataset, camera, "openlmd/etna, etna_calib", laser)
