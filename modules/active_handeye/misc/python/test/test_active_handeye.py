#!/usr/bin/env python
'''
cv.active_handeye on a scene that is written out here with numpy alone. Millimetres, pixels.
'''
from __future__ import print_function

import numpy as np
import cv2 as cv

from tests_common import NewOpenCVTests

K = np.array([[1413., 0, 322], [0, 1409., 236], [0, 0, 1]])
T_CAM2GRIPPER = np.array([[35.], [-60.], [45.]])
LIGHT = np.array([0.05, 0.87, 0.45]) / np.linalg.norm([0.05, 0.87, 0.45])
LIGHT_DISTANCE = 250.
NO_LENS = np.zeros(5)


def rotation(x, y, z):
    '''Rotation by a rotation vector in degrees.'''
    w = np.radians([x, y, z])
    angle = np.linalg.norm(w)
    a = w / max(angle, 1e-300)
    A = np.array([[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]])
    return np.eye(3) + np.sin(angle) * A + (1 - np.cos(angle)) * A.dot(A)


R_CAM2GRIPPER = rotation(3, -4, 95)


class Scene(object):
    '''Three orientations with five stops each and four more, all looking at sixty points on the table.'''

    def __init__(self):
        turns = [(180, 0, 0)] * 5 + [(160, 20, 5)] * 5 + [(170, -20, 60)] * 5
        turns += [(165, 10, -40), (170, 5, 120), (160, -15, -100), (165, -10, 20)]
        stops = [(0, 0, 0), (50, 5, 20), (-10, 45, -25), (5, -20, 50), (-45, -30, -15)]
        rng = np.random.RandomState(7)
        self.X = rng.uniform([300, -100, -60], [500, 100, 60], (60, 3))
        self.R = [rotation(*turn) for turn in turns]
        self.t, self.imagePoints, self.stripes = [], [], []
        for view, R in enumerate(self.R):
            cam2base = R.dot(R_CAM2GRIPPER)
            camera = np.array([400, 0, 0]) - 550 * cam2base[:, 2] + np.array(stops[view % 5])
            self.t.append((camera - R.dot(T_CAM2GRIPPER[:, 0])).reshape(3, 1))
            self.imagePoints.append(self.pixels((self.X - camera).dot(cam2base)))
            for normal, offset in (((0.1, 0.05, 1), 30), ((-0.35, 0.1, 1), -140), ((0.15, 0.4, 1), 55)):
                self.stripes.append(self.stripe(np.array(normal), offset, cam2base, camera))
        self.stripeViews = np.repeat(np.arange(len(self.R)), 3).astype(np.int32)
        self.surfaceIds = np.tile(np.arange(3), len(self.R)).astype(np.int32)

    @staticmethod
    def pixels(points):
        '''Image of points of the camera frame.'''
        image = points.dot(K.T)
        return image[:, :2] / image[:, 2:]

    def stripe(self, normal, offset, cam2base, camera):
        '''Pixels where the laser meets the plane normal.X = offset of the base frame.'''
        n, d = normal.dot(cam2base), offset - normal.dot(camera)
        along = np.cross(n, LIGHT)
        along /= np.linalg.norm(along)
        origin = np.linalg.solve(np.array([n, LIGHT, along]), [d, LIGHT_DISTANCE, 0])
        origin -= along * origin[0] / along[0]
        return self.pixels(origin + np.linspace(-60, 60, 40)[:, None] * along)


def degrees_between(R1, R2):
    return np.degrees(np.linalg.norm(R1 - R2) / np.sqrt(2))


class active_handeye_test(NewOpenCVTests):

    def setUp(self):
        super(active_handeye_test, self).setUp()
        self.scene = Scene()

    def test_estimateFOE_is_the_direction_of_a_translation(self):
        s = self.scene
        count, foe, mask, covariance = cv.active_handeye.estimateFOE(s.imagePoints[0], s.imagePoints[1])
        moved = (s.R[0].dot(R_CAM2GRIPPER)).T.dot(s.t[1] - s.t[0])
        expected = K.dot(moved)
        self.assertEqual(count, 60)
        self.assertEqual(mask.sum(), 60)
        self.assertEqual(covariance.shape, (3, 3))
        self.assertLess(np.abs(foe - expected / np.linalg.norm(expected)).max(), 1e-8)

    def test_closed_forms_recover_an_exact_scene(self):
        s = self.scene
        rms, camera, R, _ = cv.active_handeye.calibrateHandEyeTranslations(s.R, s.t, s.imagePoints, None, None)
        self.assertLess(rms, 1e-5)
        self.assertLess(np.abs(camera - K).max(), 1e-4)
        self.assertLess(degrees_between(R, R_CAM2GRIPPER), 1e-6)
        rms, t, _ = cv.active_handeye.calibrateHandEyeRotation(s.R, s.t, s.imagePoints, camera, None, R)
        self.assertLess(rms, 1e-5)
        self.assertLess(np.abs(t - T_CAM2GRIPPER).max(), 1e-4)

    def test_calibrateHandEye_recovers_an_exact_transform_by_every_method(self):
        s = self.scene
        cam2base = [R.dot(R_CAM2GRIPPER) for R in s.R]
        R_target2cam = [R.T.copy() for R in cam2base]
        t_target2cam = [R.T.dot(np.array([[400.], [0], [0]]) - G.dot(T_CAM2GRIPPER) - t)
                        for R, G, t in zip(cam2base, s.R, s.t)]
        for method in range(cv.active_handeye.CALIB_HAND_EYE_REFINED + 1):
            R, t = cv.active_handeye.calibrateHandEye(s.R, s.t, R_target2cam, t_target2cam, method=method)
            self.assertLess(degrees_between(R, R_CAM2GRIPPER), 1e-6, method)
            self.assertLess(np.abs(t - T_CAM2GRIPPER).max(), 1e-5, method)

    def test_calibrateHandEye_refuses_pure_translations(self):
        s = self.scene
        poses = s.R[:5], s.t[:5], s.R[:5], s.t[:5]
        for method in range(cv.active_handeye.CALIB_HAND_EYE_REFINED + 1):
            with self.assertRaises(cv.error) as caught:
                cv.active_handeye.calibrateHandEye(*poses, method=method)
            self.assertEqual(caught.exception.code, cv.Error.StsNoConv)

    def test_calibrateLightPlane_recovers_an_exact_scene(self):
        s = self.scene
        rms, plane, covariance = cv.active_handeye.calibrateLightPlane(
            s.R, s.t, s.stripes, s.stripeViews, s.surfaceIds, K, None, R_CAM2GRIPPER)
        self.assertLess(rms, 1e-5)
        self.assertEqual(covariance.shape, (4, 4))
        self.assertLess(np.abs(plane[:3, 0] - LIGHT).max(), 1e-7)
        self.assertLess(abs(plane[3, 0] - LIGHT_DISTANCE), 1e-3)

    def test_refineHandEye_is_as_wrong_as_its_covariance_says(self):
        s = self.scene
        rng = np.random.RandomState(3)
        points = [x + rng.normal(0, 0.1, x.shape) for x in s.imagePoints]
        stripes = [x + np.column_stack([np.zeros(len(x)), rng.normal(0, 0.1, len(x))]) for x in s.stripes]
        params = cv.active_handeye.RefineParams()
        params.robotTranslationSigma = params.robotRotationSigma = 0
        _, camera, _, R, t, plane, summary = cv.active_handeye.refineHandEye(
            s.R, s.t, points, None, None, None, None, None, stripePoints=stripes, stripeViews=s.stripeViews,
            surfaceIds=s.surfaceIds, params=params)
        self.assertTrue(summary.usable)
        sigma = dict(zip(summary.parameterNames, summary.standardDeviations[:, 0]))
        errors = {'fx': camera[0, 0] - K[0, 0], 'fy': camera[1, 1] - K[1, 1], 'd': plane[3, 0] - LIGHT_DISTANCE,
                  'tx': (t - T_CAM2GRIPPER)[0, 0], 'ty': (t - T_CAM2GRIPPER)[1, 0], 'tz': (t - T_CAM2GRIPPER)[2, 0]}
        for name, error in errors.items():
            self.assertGreater(sigma[name], 0)
            self.assertLess(abs(error), 4 * sigma[name], name)
        self.assertLess(degrees_between(R, R_CAM2GRIPPER), 0.05)

    def test_reprojectStripe_puts_pixels_on_the_surface(self):
        s = self.scene
        points, _ = cv.active_handeye.reprojectStripe(
            s.stripes[4], K, NO_LENS, np.append(LIGHT, LIGHT_DISTANCE), R_cam2gripper=R_CAM2GRIPPER,
            t_cam2gripper=T_CAM2GRIPPER, R_gripper2base=s.R[1], t_gripper2base=s.t[1])
        self.assertEqual(points.shape, (40, 3))
        self.assertLess(np.abs(points.dot([-0.35, 0.1, 1]) + 140).max(), 1e-8)

    def test_detectStripe_finds_the_centre_of_every_column(self):
        y = np.arange(120)[:, None]
        centre = 60.3 - 0.01 * np.arange(160)
        image = (20 + 180 * np.exp(-0.5 * ((y - centre) / 1.5) ** 2)).astype(np.uint8)
        points, sigmas = cv.active_handeye.detectStripe(image)
        self.assertEqual((points.shape, sigmas.shape), ((160, 2), (160, 1)))
        self.assertLess(np.abs(points[:, 1] - centre).max(), 0.02)

    def test_pure_translations_are_refused(self):
        s = self.scene
        with self.assertRaises(cv.error) as caught:
            cv.active_handeye.calibrateHandEyeRotation(s.R[:5], s.t[:5], s.imagePoints[:5], K, None, R_CAM2GRIPPER)
        self.assertEqual(caught.exception.code, cv.Error.StsNoConv)
        self.assertIn('orientation', caught.exception.err)

    def test_wrong_input_is_refused_by_name(self):
        s = self.scene
        with self.assertRaises(cv.error) as caught:
            cv.active_handeye.calibrateHandEyeTranslations(s.R, s.t[:-1], s.imagePoints, None, None)
        self.assertEqual(caught.exception.code, cv.Error.StsBadSize)
        self.assertIn('t_gripper2base', caught.exception.err)

    def test_refineHandEye_leaves_its_inputs_alone(self):
        s = self.scene
        copies = [[a.copy() for a in group] for group in (s.R, s.t, s.imagePoints)]
        start = K + np.diag([5., 5., 0.])
        given = start.copy()
        result = cv.active_handeye.refineHandEye(s.R, s.t, s.imagePoints, start, None, None, None, None)
        self.assertTrue(all(np.array_equal(a, b) for group, copy in zip((s.R, s.t, s.imagePoints), copies)
                            for a, b in zip(group, copy)))
        self.assertTrue(np.array_equal(start, given))
        self.assertLess(np.abs(result[1] - K).max(), 1e-3)


if __name__ == '__main__':
    NewOpenCVTests.bootstrap()
