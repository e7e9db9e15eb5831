// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// Many image points of unknown scene points, few parameters p that all of them share. A point Z of the scene has in view i the
// homogeneous image Y = G_i Z + D_i p; its residual is (x - Y_xy / Y_z), made linear by multiplying with the depth Y_z. Every Z is eliminated; what
// remains is a quadratic form p^T S p. Which problem it is, is data: (G, D) of every view.
#ifndef OPENCV_ACTIVE_HANDEYE_TRACK_ELIMINATION_HPP
#define OPENCV_ACTIVE_HANDEYE_TRACK_ELIMINATION_HPP

#include "input.hpp"

namespace cv { namespace active_handeye {

struct Observation
{
    int view;            //!< view of the caller
    int point;           //!< column of imagePoints
    Eigen::Vector2d x;   //!< image point in the coordinates of Y_xy / Y_z
};

//! Observations sorted by track: track j is observations[first[j]] .. observations[first[j + 1] - 1].
struct Tracks
{
    AlignedVector<Observation> observations;
    std::vector<int> first = std::vector<int>(1, 0);

    int count() const { return int(first.size()) - 1; }

    //! Ends the present track: keeps it when it has two or more observations, drops it otherwise.
    void closeTrack();
};

//! Adds one track for every point that two or more of the `views` see.
void addTracks(const std::vector<Pixels>& pixels, const std::vector<int>& views, Tracks& tracks);

//! Median over the tracks of the largest distance between two image points of a track.
double medianParallax(const Tracks& tracks);

template <int Q>
struct ViewModel
{
    Eigen::Matrix3d G;
    Eigen::Matrix<double, 3, Q> D;
    EIGEN_MAKE_ALIGNED_OPERATOR_NEW
};

//! Residuals of all observations for one p: eliminated points put back.
struct TrackResiduals
{
    Pixels residual;             //!< x - Y_xy / Y_z
    std::vector<double> depth;   //!< Y_z
};

/** Weighted normal equations of the observations x, p given the model: sum of w |(x Y_z - Y_xy)|^2 with Z eliminated.

Observations of weight 0 do not count; tracks with fewer than two others, or without parallax, are passed over.
*/
template <int Q>
Eigen::Matrix<double, Q, Q> eliminateTracks(const Tracks& tracks, const AlignedVector<ViewModel<Q> >& models,
                                            const std::vector<double>& weights);

template <int Q>
TrackResiduals trackResiduals(const Tracks& tracks, const AlignedVector<ViewModel<Q> >& models, const std::vector<double>& weights,
                              const Eigen::Matrix<double, Q, 1>& p);

}} // namespace cv::active_handeye

#endif
