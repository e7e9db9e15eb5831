// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.
#ifndef OPENCV_TEST_ACTIVE_HANDEYE_STRIPE_SCENE_HPP
#define OPENCV_TEST_ACTIVE_HANDEYE_STRIPE_SCENE_HPP

#include "point_scene.hpp"

namespace opencv_test {

inline Matx33d rotationAbout(const Vec3d& axis, double degrees)
{
    return rotation(axis * (degrees * CV_PI / 180 / cv::norm(axis)));
}

struct SceneSurface
{
    Vec3d normal; //!< base frame, normal.X = offset
    double offset;
    double firstColumn, lastColumn; //!< of the ideal image, where the stripe meets it
    int id;
};

//! A robot with camera and laser over planes; metres. Everything by formulas of its own, nothing of the module.
struct StripeScene
{
    Matx33d K, R_cam2gripper;
    Vec3d t_cam2gripper;
    std::vector<double> D; // k1, k2, p1, p2, k3
    Vec3d n;               // light plane in the camera frame
    double d;
    std::vector<Mat> R, t; // poses
    std::vector<SceneSurface> surfaces;
    double columnStep;

    std::vector<Mat> points;
    std::vector<int> views, ids;

    StripeScene()
        : K(1413, 0, 322, 0, 1409, 243, 0, 0, 1), R_cam2gripper(rotationAbout(Vec3d(0.3, -0.2, 1), 35)),
          t_cam2gripper(0.04, -0.03, 0.09), D({-0.11, 0.08, 0.0007, -0.0004, 0.01}), columnStep(1)
    {
        const Vec3d normal = Vec3d(0.05, -0.5, 0.13);
        n = normal / cv::norm(normal);
        d = n.dot(Vec3d(0, 0, 0.5));
    }

    //! The camera looks down from (x, y, 0.5); `tilt` turns it about an axis of the base frame.
    void addGroup(const Vec3d& axis, double degrees, const std::vector<Vec3d>& positions)
    {
        const Matx33d cam2base = rotationAbout(axis, degrees) * Matx33d(1, 0, 0, 0, -1, 0, 0, 0, -1);
        const Matx33d gripper2base = cam2base * R_cam2gripper.t();
        for (const Vec3d& position : positions)
        {
            R.push_back(Mat(gripper2base).clone());
            t.push_back(Mat(Vec3d(position - gripper2base * t_cam2gripper)).clone());
        }
    }

    static std::vector<Vec3d> star(double size)
    {
        const Vec3d centre(0.02, -0.01, 0.5);
        return {centre, centre + Vec3d(size, 0, 0), centre + Vec3d(0, size, 0), centre + Vec3d(0, 0, size),
                centre + Vec3d(-size, 0.6 * size, -0.7 * size)};
    }

    void addSurface(const Vec3d& normal, double offset, double firstColumn, double lastColumn)
    {
        surfaces.push_back(SceneSurface{normal / cv::norm(normal), offset, firstColumn, lastColumn,
                                        int(surfaces.size())});
    }

    //! Table, a plate tilted about x, a plate tilted about y; two groups of five views.
    static StripeScene standard()
    {
        StripeScene scene;
        scene.addGroup(Vec3d(1, 0, 0), 0, star(0.05));
        scene.addGroup(Vec3d(0.6, 1, 0.3), 20, star(0.05));
        scene.addSurface(Vec3d(0, 0, 1), 0, 40, 220);
        scene.addSurface(Vec3d(0.1, -0.35, 1), 0.02, 240, 400);
        scene.addSurface(Vec3d(-0.4, 0.1, 1), 0.01, 420, 600);
        return scene;
    }

    Vec2d distort(const Vec2d& ideal) const
    {
        const double x = (ideal[0] - K(0, 2)) / K(0, 0), y = (ideal[1] - K(1, 2)) / K(1, 1), r2 = x * x + y * y;
        const double radial = 1 + D[0] * r2 + D[1] * r2 * r2 + D[4] * r2 * r2 * r2;
        const double u = x * radial + 2 * D[2] * x * y + D[3] * (r2 + 2 * x * x);
        const double v = y * radial + D[2] * (r2 + 2 * y * y) + 2 * D[3] * x * y;
        return Vec2d(K(0, 0) * u + K(0, 2), K(1, 1) * v + K(1, 2));
    }

    Matx33d cam2base(int view) const { return Matx33d(R[view]) * R_cam2gripper; }
    Vec3d cameraPosition(int view) const
    {
        const Matx33d rotation(R[view]);
        return rotation * t_cam2gripper + Vec3d(t[view]);
    }

    //! Ideal row of the stripe on a surface at an ideal column.
    double stripeRow(int view, const SceneSurface& surface, double column, const Vec3d& light, double offset) const
    {
        const Vec3d w = cam2base(view).t() * surface.normal;
        const double e0 = surface.offset - surface.normal.dot(cameraPosition(view));
        const Vec3d line = K.inv().t() * (e0 * light - offset * w);
        return -(line[0] * column + line[2]) / line[1];
    }

    //! All stripes, with Gaussian noise across them.
    void shine(double noise = 0, uint64 seed = 1)
    {
        RNG rng(seed);
        points.clear();
        views.clear();
        ids.clear();
        for (int view = 0; view < int(R.size()); ++view)
            for (const SceneSurface& surface : surfaces)
            {
                std::vector<Vec2d> stripe;
                for (double column = surface.firstColumn; column <= surface.lastColumn; column += columnStep)
                {
                    const double row = stripeRow(view, surface, column, n, d);
                    stripe.push_back(distort(Vec2d(column, row)) + Vec2d(0, rng.gaussian(noise)));
                }
                points.push_back(Mat(stripe).reshape(1, int(stripe.size())).clone());
                views.push_back(view);
                ids.push_back(surface.id);
            }
    }

    //! Shares no data with this one.
    StripeScene copy() const
    {
        StripeScene scene = *this;
        for (std::vector<Mat>* list : {&scene.R, &scene.t, &scene.points})
            for (Mat& item : *list)
                item = item.clone();
        return scene;
    }

    double calibrate(Vec4d& plane, Mat covariance = Mat(), InputArray knownPoints = noArray()) const
    {
        Mat light;
        const double rms =
            calibrateLightPlane(R, t, points, views, ids, K, D, R_cam2gripper, light, covariance, knownPoints);
        plane = Vec4d(light.ptr<double>());
        return rms;
    }

    double normalError(const Vec4d& plane) const // degrees
    {
        const Vec3d found(plane[0], plane[1], plane[2]);
        return std::atan2(cv::norm(found.cross(n)), found.dot(n)) * 180 / CV_PI;
    }
};

} // namespace opencv_test

#endif
