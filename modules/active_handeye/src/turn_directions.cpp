// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "turn_directions.hpp"

namespace cv { namespace active_handeye {

using Eigen::Matrix3d;

TurnDirections::TurnDirections(const AlignedVector<Pose>& gripper2base)
{
    Matrix3d mean = Matrix3d::Zero(), scatter = Matrix3d::Zero();
    for (const Pose& pose : gripper2base)
        mean += pose.R / double(gripper2base.size());
    for (const Pose& pose : gripper2base)
        scatter += (pose.R - mean).transpose() * (pose.R - mean) / double(gripper2base.size());
    const Eigen::SelfAdjointEigenSolver<Matrix3d> eigen(scatter); // ascending
    const double threshold = std::pow(smallestTurn * CV_PI / 180, 2);
    int rank = 0;
    while (rank < 3 && eigen.eigenvalues()[2 - rank] > threshold)
        ++rank;
    observed = eigen.eigenvectors().rightCols(rank);
    axis = eigen.eigenvectors().col(0);
    axisInBase = (mean * axis).normalized();
}

}} // namespace cv::active_handeye
