// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.
#ifndef OPENCV_TEST_ACTIVE_HANDEYE_HAND_EYE_SCENE_HPP
#define OPENCV_TEST_ACTIVE_HANDEYE_HAND_EYE_SCENE_HPP

#include "point_scene.hpp"

namespace opencv_test {

struct RigidMotion
{
    Matx33d R;
    Vec3d t;

    RigidMotion operator*(const RigidMotion& first) const { return RigidMotion{R * first.R, R * first.t + t}; }
    RigidMotion inverse() const { return RigidMotion{R.t(), -(R.t() * t)}; }
};

//! Rotation vector of a turn of less than 180 degrees.
inline Vec3d rotationVector(const Matx33d& R)
{
    const Vec3d v(R(2, 1) - R(1, 2), R(0, 2) - R(2, 0), R(1, 0) - R(0, 1));
    const double length = cv::norm(v);
    return length > 0 ? v * (std::atan2(length, cv::trace(R) - 1) / length) : v;
}

//! Standard deviations of one component of rotation vector [rad] and translation.
struct PoseNoise
{
    double rotation, translation;
};

/** Poses as OpenCV's own hand-eye test draws them, metres: axes uniform in a cube, signs of the translation at random.

The camera is in the hand: gripper2base[i] cam2gripper target2cam[i] = target2base.
*/
class HandEyeScene
{
public:
    explicit HandEyeScene(uint64 seed, int views = 10, double leastTurnDeg = 5, double mostTurnDeg = 45)
        : rng(seed), cam2gripper(draw(10, 50, 0.05, 0.5)), target2base(draw(5, 85, 0.5, 3.5))
    {
        for (int i = 0; i < views; ++i)
            addView(draw(leastTurnDeg, mostTurnDeg, 0.5, 1.5));
    }

    //! A copy shares nothing with its original.
    HandEyeScene(const HandEyeScene& other)
        : rng(other.rng), cam2gripper(other.cam2gripper), target2base(other.target2base)
    {
        copyTo(other.R_gripper2base, R_gripper2base);
        copyTo(other.t_gripper2base, t_gripper2base);
        copyTo(other.R_target2cam, R_target2cam);
        copyTo(other.t_target2cam, t_target2cam);
    }

    HandEyeScene& operator=(const HandEyeScene&) = delete;

    //! A view in which the camera sees the target where it is.
    void addView(const RigidMotion& gripper2base)
    {
        add(R_gripper2base, t_gripper2base, gripper2base);
        add(R_target2cam, t_target2cam, (gripper2base * cam2gripper).inverse() * target2base);
    }

    void clearViews()
    {
        for (vector<Mat>* list : {&R_gripper2base, &t_gripper2base, &R_target2cam, &t_target2cam})
            list->clear();
    }

    void addNoise(const PoseNoise& camera, const PoseNoise& robot)
    {
        for (size_t i = 0; i < R_gripper2base.size(); ++i)
        {
            disturb(R_target2cam[i], t_target2cam[i], camera);
            disturb(R_gripper2base[i], t_gripper2base[i], robot);
        }
    }

    RigidMotion draw(double leastDeg, double mostDeg, double least, double most)
    {
        const double z = rng.uniform(-1., 1.), y = rng.uniform(-1., 1.), x = rng.uniform(-1., 1.);
        const Vec3d axis(x, y, z);
        const Matx33d R = rotation(axis * (rng.uniform(leastDeg, mostDeg) * CV_PI / 180));
        Vec3d t;
        for (int i = 0; i < 3; ++i)
            t[i] = rng.uniform(least, most) * (rng.uniform(0, 2) ? 1 : -1);
        return RigidMotion{R, t};
    }

    RNG rng;
    RigidMotion cam2gripper, target2base;
    vector<Mat> R_gripper2base, t_gripper2base, R_target2cam, t_target2cam;

private:
    static void copyTo(const vector<Mat>& from, vector<Mat>& to)
    {
        for (const Mat& m : from)
            to.push_back(m.clone());
    }

    static void add(vector<Mat>& R, vector<Mat>& t, const RigidMotion& pose)
    {
        R.push_back(Mat(pose.R));
        t.push_back(Mat(pose.t));
    }

    void disturb(Mat& R, Mat& t, const PoseNoise& noise)
    {
        Vec3d w, shift;
        for (int k = 0; k < 3; ++k)
        {
            w[k] = rng.gaussian(noise.rotation);
            shift[k] = rng.gaussian(noise.translation);
        }
        R = Mat(rotation(w) * Matx33d(R));
        t = Mat(Vec3d(t) + shift);
    }
};

} // namespace opencv_test

#endif
