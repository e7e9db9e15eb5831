// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// A robot that is a little off moves the whole image of that view: every view gets a small turn of the camera (Tracks::jitterMotion) with prior
// N(0, tau^2) per number, on top of the independent noise sigma of every point. A lateral error of the position looks almost the same.
#ifndef OPENCV_ACTIVE_HANDEYE_TRACK_JITTER_HPP
#define OPENCV_ACTIVE_HANDEYE_TRACK_JITTER_HPP

#include "track_elimination.hpp"

namespace cv { namespace active_handeye {

//! Normal equations of p and of the jitter of all views, every point eliminated.
template <int Q>
struct JitterForm
{
    Eigen::Matrix<double, Q, Q> pp;
    Eigen::MatrixXd jp, jj;

    //! p^T S p with the jitter eliminated under the prior; precision = (sigma / tau)^2.
    Eigen::Matrix<double, Q, Q> withoutJitter(double precision) const;

    //! Jitter of all views for given p.
    Eigen::VectorXd jitter(const Eigen::Matrix<double, Q, 1>& p, double precision) const;

    //! How many of its numbers the data determine rather than the prior; tangent: Q x n directions in which p may move.
    double determined(const Eigen::MatrixXd& tangent, double precision) const;
};

//! depth: of every observation, from the last solution; forms, without jitter, and points as in eliminateTracks().
template <class Model>
JitterForm<Model::parameters>
eliminateTracksWithJitter(const Tracks& tracks, const AlignedVector<Model>& models,
                          const AlignedVector<Eigen::Matrix3d>& toImage, const std::vector<double>& weights,
                          const std::vector<double>& depth, AlignedVector<EliminatedPoint<Model::parameters>>& points);

}} // namespace cv::active_handeye

#endif
