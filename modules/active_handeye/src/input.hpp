// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// cv arrays -> Eigen, with every check of the input. Nothing else in the module reads a cv::Mat of the caller.
// Each function names the argument in its error (StsBadArg: wrong kind or value; StsBadSize: wrong shape; StsOutOfRange).
#ifndef OPENCV_ACTIVE_HANDEYE_INPUT_HPP
#define OPENCV_ACTIVE_HANDEYE_INPUT_HPP

#include "camera.hpp"
#include "pose.hpp"

namespace cv { namespace active_handeye {

typedef AlignedVector<Eigen::Vector2d> Pixels;

double readPositive(double value, const char* name);

//! One 3x3 rotation or rotation vector; at most 1e-6 from orthonormal, det +1.
Eigen::Matrix3d readRotation(InputArray R, const char* name);

//! One vector of 3 finite numbers.
Eigen::Vector3d readVector3(InputArray v, const char* name);

//! V rotations (3x3) or rotation vectors.
std::vector<Eigen::Matrix3d> readRotations(InputArrayOfArrays R, const char* name);

//! V poses, `least` or more. Refuses views whose translation looks like another unit of length (mm against m).
AlignedVector<Pose> readPoses(InputArrayOfArrays R, InputArrayOfArrays t, const char* R_name, const char* t_name,
                              size_t least);

//! The same for R_gripper2base, t_gripper2base.
AlignedVector<Pose> readRobotPoses(InputArrayOfArrays R_gripper2base, InputArrayOfArrays t_gripper2base,
                                   size_t least = 2);

//! N points of 2 coordinates, all finite.
Pixels readPixels(InputArray points, const char* name);

//! M points of 3 coordinates, all finite; empty is allowed.
AlignedVector<Eigen::Vector3d> readPoints3D(InputArray points, const char* name);

//! `views` arrays of N pixels each; (NaN, NaN) = not seen, as Pixels with NaN.
std::vector<Pixels> readImagePoints(InputArrayOfArrays imagePoints, size_t views);

//! S arrays of pixels of any length, all finite.
std::vector<Pixels> readPixelLists(InputArrayOfArrays points, const char* name);

//! One positive number for each of `count` points.
std::vector<double> readSigmas(InputArray sigmas, const char* name, size_t count);

//! S whole numbers.
std::vector<int> readIntegers(InputArray values, const char* name);

//! cameraMatrix and distCoeffs (k1, k2, p1, p2[, k3] or empty).
Camera readCamera(InputArray cameraMatrix, InputArray distCoeffs);

//! distCoeffs alone, into a camera whose K is not known yet.
void readDistortion(InputArray distCoeffs, Camera& camera);

//! The pixels that the points would have without lens distortion; NaN stays NaN.
std::vector<Pixels> idealPixels(std::vector<Pixels> recorded, const Camera& camera);

//! Output helper: an Eigen matrix of doubles as CV_64F.
template <typename Derived>
void writeMatrix(const Eigen::MatrixBase<Derived>& matrix, OutputArray out)
{
    out.create(int(matrix.rows()), int(matrix.cols()), CV_64F);
    Mat m = out.getMat();
    for (int i = 0; i < int(matrix.rows()); ++i)
        for (int j = 0; j < int(matrix.cols()); ++j)
            m.ptr<double>()[i * int(matrix.cols()) + j] = matrix(i, j);
}

//! The same for an array that was also an input: where the caller holds its values, they stay.
template <typename Derived>
void writeNewMatrix(const Eigen::MatrixBase<Derived>& matrix, InputOutputArray out)
{
    if (!out.fixedSize())
        out.release();
    writeMatrix(matrix, out);
}

}} // namespace cv::active_handeye

#endif
