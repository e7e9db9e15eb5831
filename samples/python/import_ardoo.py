# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Imports the ChArUco recording of ArdooTala: 7 views on a UR robot, corners and poses only.

Example: python samples/python/import_ardoo.py data/ardoo_ur_charuco out/ardoo
"""

from import_common import arguments, import_folder

from cv_active_handeye.dataset import CameraInfo

if __name__ == "__main__":
    given = arguments(__doc__)
    camera = CameraInfo(width=1280, height=720, pixel_format="bgr8", name="colour camera on a UR robot")
    import_folder(given.source, given.dataset, camera, "ArdooTala, Hand-Eye-Calibration")
