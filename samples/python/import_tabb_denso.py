# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Imports the DENSO recording of A. Tabb (RWHEC data set 1): 88 views of a chessboard in a laboratory, no laser.

Example: python samples/python/import_tabb_denso.py data/tabb_denso_dataset1 out/tabb
"""

from import_common import arguments, import_folder

from cv_active_handeye.dataset import CameraInfo

if __name__ == "__main__":
    given = arguments(__doc__)
    camera = CameraInfo(width=640, height=480, pixel_format="bgr8", name="Sony XCD on a DENSO VS-6577GM-B")
    import_folder(given.source, given.dataset, camera, "A. Tabb, RWHEC data set 1, USDA-ARS")
