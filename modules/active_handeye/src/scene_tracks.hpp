// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// Image points of a joint refinement, sorted by scene point, and where the scene points are.
#ifndef OPENCV_ACTIVE_HANDEYE_SCENE_TRACKS_HPP
#define OPENCV_ACTIVE_HANDEYE_SCENE_TRACKS_HPP

#include "calibration_state.hpp"
#include "input.hpp"

namespace cv { namespace active_handeye {

struct PointObservation
{
    int view;
    Eigen::Vector2d pixel;
    double inverseSigma; //!< relative to the common noise level
    bool used;
};

//! Observations of track j: observations[first[j]] .. observations[first[j + 1] - 1], by view.
struct SceneTracks
{
    //! Points that two views see, or one where objectPoints knows them. pointSigmas, objectPoints: empty = none.
    SceneTracks(const std::vector<Pixels>& imagePoints, const std::vector<std::vector<double>>& pointSigmas,
                const AlignedVector<Eigen::Vector3d>& objectPoints);

    int count() const { return int(column.size()); }
    int usedIn(int track) const;
    bool isUsed(int track) const { return usedIn(track) >= (isKnown(track) ? 1 : 2); }
    bool isKnown(int track) const { return !known.empty() && known[track].allFinite(); }
    bool anyKnown() const;

    AlignedVector<PointObservation> observations;
    std::vector<int> first = std::vector<int>(1, 0);
    std::vector<int> column; //!< of imagePoints
    AlignedVector<Eigen::Vector3d>
        known; //!< coordinates in the object's frame, NaN = unknown; empty without objectPoints
};

/** Puts every scene point where its rays say, for the present calibration and poses.

A track with contradicting rays gets the point that most of them agree on. Points that are not determined are NaN.
`tolerance`: pixels within which rays agree.
*/
void triangulate(const SceneTracks& tracks, double tolerance, CalibrationState& state);

//! Puts the frame of the known points where the triangulated points say, and the known points with it. Needs 3 of them.
void placeObject(const SceneTracks& tracks, CalibrationState& state);

//! Distance of every observation from its prediction in its own sigmas; infinite behind the camera or without a point.
std::vector<double> normalizedErrors(const SceneTracks& tracks, const CalibrationState& state);

}} // namespace cv::active_handeye

#endif
