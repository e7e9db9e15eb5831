// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.
#ifndef OPENCV_TEST_ACTIVE_HANDEYE_POINT_SCENE_HPP
#define OPENCV_TEST_ACTIVE_HANDEYE_POINT_SCENE_HPP

#include "test_precomp.hpp"

namespace opencv_test {

//! Rotation of |w| radians about w.
inline Matx33d rotation(const Vec3d& w)
{
    const double angle = cv::norm(w);
    if (angle == 0)
        return Matx33d::eye();
    const Vec3d a = w / angle;
    const Matx33d A(0, -a[2], a[1], a[2], 0, -a[0], -a[1], a[0], 0);
    return Matx33d::eye() + A * std::sin(angle) + A * A * (1 - std::cos(angle));
}

inline double angleDeg(const Matx33d& R1, const Matx33d& R2)
{
    const Matx33d D = R1.t() * R2;
    const Vec3d v(D(2, 1) - D(1, 2), D(0, 2) - D(2, 0), D(1, 0) - D(0, 1));
    return std::atan2(cv::norm(v), D(0, 0) + D(1, 1) + D(2, 2) - 1) * (180 / CV_PI);
}

/** A robot that moves a camera over scattered points: groups of translations at several orientations, the paper's camera. Millimetres.

The image of a base point X is written out here from the definition, independent of the module.
*/
class PointScene
{
public:
    explicit PointScene(uint64 seed = 1, int points = 30) : rng(seed), K(1413, 0.5, 316, 0, 1420, 243, 0, 0, 1)
    {
        R_cam2gripper = rotation(Vec3d(0.05, -0.03, 1.5));
        t_cam2gripper = Vec3d(-5, 103, 104);
        for (int j = 0; j < points; ++j)
        {
            // Compilers may evaluate arguments in any order; so all of them draw the same scene.
            const double z = rng.uniform(-60., 60.), y = rng.uniform(-70., 70.), x = 300 + rng.uniform(-90., 90.);
            X.push_back(Vec3d(x, y, z));
        }
    }

    //! A copy shares nothing with its original.
    PointScene(const PointScene& other)
        : rng(other.rng), K(other.K), R_cam2gripper(other.R_cam2gripper), t_cam2gripper(other.t_cam2gripper), X(other.X)
    {
        std::copy(other.D, other.D + 5, D);
        copyTo(other.R, R);
        copyTo(other.t, t);
        copyTo(other.imagePoints, imagePoints);
    }

    PointScene& operator=(const PointScene& other)
    {
        PointScene copy(other);
        rng = copy.rng;
        K = copy.K;
        std::copy(copy.D, copy.D + 5, D);
        R_cam2gripper = copy.R_cam2gripper;
        t_cam2gripper = copy.t_cam2gripper;
        X.swap(copy.X);
        R.swap(copy.R);
        t.swap(copy.t);
        imagePoints.swap(copy.imagePoints);
        return *this;
    }

    //! Views of one orientation, the camera displaced by `offsets` from where it looks at the middle of the points from 550 mm.
    void addGroup(const Vec3d& turn, const vector<Vec3d>& offsets)
    {
        const Matx33d gripperToBase = rotation(turn) * rotation(Vec3d(3.1, 0.1, 0.05));
        const Matx33d cameraToBase = gripperToBase * R_cam2gripper;
        for (const Vec3d& offset : offsets)
        {
            const Vec3d camera = Vec3d(300, 0, 0) - cameraToBase * Vec3d(0, 0, 550) + cameraToBase * offset;
            R.push_back(Mat(gripperToBase));
            t.push_back(Mat(Vec3d(camera - gripperToBase * t_cam2gripper)));
        }
    }

    static vector<Vec3d> fourTranslations()
    {
        return vector<Vec3d>{Vec3d(0, 0, 0), Vec3d(50, 5, 20), Vec3d(-10, 45, -25), Vec3d(5, -20, 50),
                             Vec3d(-45, -30, -15)};
    }

    //! Two groups of four translations and two more orientations.
    static PointScene complete(uint64 seed = 1, int points = 30)
    {
        PointScene scene(seed, points);
        scene.addGroup(Vec3d(0, 0, 0), fourTranslations());
        scene.addGroup(Vec3d(0.35, 0, 0), fourTranslations());
        scene.addGroup(Vec3d(0, 0.3, 0.4), vector<Vec3d>(1, Vec3d()));
        scene.addGroup(Vec3d(-0.2, -0.2, -0.8), vector<Vec3d>(1, Vec3d()));
        scene.project();
        return scene;
    }

    Vec2d project(const Vec3d& point, int view) const
    {
        const Matx33d Rv = R[view];
        const Vec3d gripper = Rv.t() * (point - Vec3d(t[view]));
        const Vec3d camera = R_cam2gripper.t() * (gripper - t_cam2gripper);
        const double x = camera[0] / camera[2], y = camera[1] / camera[2], r2 = x * x + y * y;
        const double radial = 1 + D[0] * r2 + D[1] * r2 * r2 + D[4] * r2 * r2 * r2;
        const Vec3d image = K * Vec3d(x * radial + 2 * D[2] * x * y + D[3] * (r2 + 2 * x * x),
                                      y * radial + D[2] * (r2 + 2 * y * y) + 2 * D[3] * x * y, 1);
        return Vec2d(image[0], image[1]);
    }

    //! Fills imagePoints, with Gaussian noise per axis.
    void project(double noise = 0)
    {
        imagePoints.clear();
        for (size_t view = 0; view < R.size(); ++view)
        {
            Mat pixels(int(X.size()), 2, CV_64F);
            for (size_t j = 0; j < X.size(); ++j)
            {
                const Vec2d x = project(X[j], int(view));
                pixels.at<double>(int(j), 0) = x[0] + (noise > 0 ? rng.gaussian(noise) : 0);
                pixels.at<double>(int(j), 1) = x[1] + (noise > 0 ? rng.gaussian(noise) : 0);
            }
            imagePoints.push_back(pixels);
        }
    }

    Mat dist() const { return Mat(1, 5, CV_64F, const_cast<double*>(D)).clone(); }

    RNG rng;
    Matx33d K;
    double D[5] = {0, 0, 0, 0, 0};
    Matx33d R_cam2gripper;
    Vec3d t_cam2gripper;
    vector<Vec3d> X;
    vector<Mat> R, t, imagePoints;

private:
    static void copyTo(const vector<Mat>& from, vector<Mat>& to)
    {
        for (const Mat& m : from)
            to.push_back(m.clone());
    }
};

//! Runs the call, expects a cv::Exception of this code whose text holds all of these parts.
template <typename Call>
void expectError(Call call, int code, const vector<string>& parts)
{
    try
    {
        call();
        ADD_FAILURE() << "no error; expected one that says: " << parts[0];
    }
    catch (const cv::Exception& e)
    {
        EXPECT_EQ(code, int(e.code)) << e.what();
        for (const string& part : parts)
            EXPECT_NE(string::npos, string(e.what()).find(part)) << "missing: " << part << "\nin: " << e.what();
    }
}

} // namespace opencv_test

#endif
