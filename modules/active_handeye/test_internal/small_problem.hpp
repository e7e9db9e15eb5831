// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// A small joint refinement with everything in it: points that are free, known and missing, stripes, poses of all kinds. Metres.
#ifndef OPENCV_TEST_ACTIVE_HANDEYE_SMALL_PROBLEM_HPP
#define OPENCV_TEST_ACTIVE_HANDEYE_SMALL_PROBLEM_HPP

#include "../src/precomp.hpp"
#include "../src/refine_problem.hpp"
#include "../src/residuals.hpp"

#include <gtest/gtest.h>

namespace opencv_test {

using namespace cv::active_handeye;
using cv::RNG;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::Vector4d;
using Eigen::VectorXd;

//! What a small problem is made of.
struct Contents
{
    int views = 6, freePoints = 12, knownPoints = 0, surfaces = 0;
    bool sameSigmas = true; //!< of the image points and segments
    double pixelNoise = 0.1, translationNoise = 1e-4, rotationNoise = 1e-4, stripeNoise = 0.05;
    double huberThreshold = 1e9;
};

Vector3d randomVector(RNG& rng, double half);

Vector3d gaussianVector(RNG& rng, double sigma);

HandEyeCalibration someCalibration();

//! A pose from which the camera looks at the scene around (0.3, 0, 0).
Pose somePose(RNG& rng, const Pose& cam2gripper);

//! Pixel, at this ideal x, of the stripe on a surface (w, e).
Vector2d stripePixel(const HandEyeCalibration& calibration, const CameraView& view, const Vector4d& surface, double x);

//! Owns what a RefineProblem refers to. Its state is the truth; its measurements have noise.
class SmallProblem
{
public:
    explicit SmallProblem(const Contents& contents = Contents(), uint64 seed = 5);

    SceneTracks& tracks() { return tracks_; }
    StripeSegments& segments() { return segments_; }

private:
    SmallProblem(const SmallProblem&);
    SmallProblem& operator=(const SmallProblem&);

    int points() const { return contents_.freePoints + contents_.knownPoints; }

    //! Free points first, then the known ones.
    CalibrationState makeTruth();
    AlignedVector<Pose> makeReports();
    //! Every fifth view of a free point is missing, so that tracks differ in length.
    std::vector<Pixels> makeImages();

    std::vector<std::vector<double>> makeSigmas();
    AlignedVector<Vector3d> objectPoints() const;
    StripeSegments makeSegments();

    const Contents contents_;
    RNG rng_;
    const CalibrationState truth_;
    const AlignedVector<Pose> reported_;
    const std::vector<Pixels> imagePoints_;
    SceneTracks tracks_;
    StripeSegments segments_;

public:
    RefineProblem problem;
};

} // namespace opencv_test

#endif
