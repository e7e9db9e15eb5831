#!/usr/bin/env python
'''
Calibrates a camera in the hand of a robot from what it saw of an ordinary scene: camera matrix, lens and hand-eye transform with 95 % intervals.

Usage: target_free_hand_eye.py RECORDING.npz
RECORDING.npz holds R_gripper2base (V, 3, 3), t_gripper2base (V, 3) and imagePoints (V, N, 2): pixels, row j is the same point in every view,
NaN = not seen.
'''
import sys

import cv2 as cv
import numpy as np


def main():
    if len(sys.argv) != 2:
        print(__doc__)
        return 2
    recording = np.load(sys.argv[1])
    try:
        rms, K, D, R, t, _, summary = cv.active_handeye.refineHandEye(
            list(recording['R_gripper2base']), list(recording['t_gripper2base']), list(recording['imagePoints']),
            None, None, None, None, None)
    except cv.error as e:  # says which argument, or which motion is missing
        print(e.err)
        return 2
    print(summary.message)
    print('reprojection error %.3f px' % rms)
    print('cameraMatrix\n%s\nR_cam2gripper\n%s\nt_cam2gripper %s' % (K, R, t.ravel()))
    for name, sigma, interval in zip(summary.parameterNames, summary.standardDeviations, summary.intervals95):
        if sigma > 0:
            print('%5s  %12.5f to %12.5f' % (name, interval[0], interval[1]))
    return 0 if summary.usable else 1


if __name__ == '__main__':
    sys.exit(main())
