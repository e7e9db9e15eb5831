# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Imports the circle-grid recording of industrial_calibration: 15 views of a 10 x 10 dot grid, no laser.

Example: python samples/python/import_indcal.py data/indcal_10x10 out/indcal
"""

from import_common import arguments, import_folder

from cv_active_handeye.dataset import CameraInfo

if __name__ == "__main__":
    given = arguments(__doc__)
    camera = CameraInfo(width=640, height=480, pixel_format="bgr8", name="colour camera on an industrial arm")
    import_folder(given.source, given.dataset, camera, "industrial_calibration, test_set_10x10")
