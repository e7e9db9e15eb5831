// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_ACTIVE_HANDEYE_COPLANAR_LINES_HPP
#define OPENCV_ACTIVE_HANDEYE_COPLANAR_LINES_HPP

#include "light_plane_problem.hpp"
#include "pose.hpp"

namespace cv { namespace active_handeye {

//! A segment with its ends on the light plane, in the base frame.
struct SceneLine
{
    StripeView view; //!< displacement 0: surfaces are given in the camera frame of its view
    int group;
    Eigen::Vector3d ends[2];
    bool inFront;
    AlignedVector<Eigen::Vector3d> beside; //!< scene points that its view shows beside the segment
};

typedef AlignedVector<SceneLine> SceneLines;

struct ScenePlane
{
    Eigen::Vector4d plane; //!< (w, e0), w.X = e0 in the base frame, |w| = 1
    std::vector<int> lines;
    double
        planarity; //!< RMS extent of the lines' ends across their longest direction, relative to that; 0 = they are all on one line
};

typedef AlignedVector<ScenePlane> ScenePlanes;

//! What the scene points beside a segment say about a plane through it.
enum Support
{
    CONTRADICTED,
    UNDECIDED, //!< too few points
    CONFIRMED
};

//! Which lines lie on one plane, for a known light plane and known poses. Lines are numbered as given.
class CoplanarLines
{
public:
    //! Scene points may miss a plane by twice the tolerance: their depths are less precise than the stripes'.
    CoplanarLines(const SceneLines& lines, const LightPlane& light, const Eigen::Matrix3d& K,
                  const AlignedVector<Pose>& cam2base, double tolerancePx);

    const SceneLine& operator[](int line) const { return lines_[line]; }
    int count() const { return int(lines_.size()); }

    //! RMS distance [px] of both ends to the stripe predicted; infinite where there is none.
    double error(const Eigen::Vector4d& plane, int line) const;

    //! CONFIRMED: half of the points beside the line, four or more, are near the plane.
    Support support(const Eigen::Vector4d& plane, int line) const;

    //! Within the tolerance, with this support or more.
    bool fits(const Eigen::Vector4d& plane, int line, Support least = UNDECIDED) const;

    //! Those of the candidates that fit.
    std::vector<int> linesOn(const Eigen::Vector4d& plane, const std::vector<int>& candidates, Support least) const;

    //! How well lines agree with a plane: 1 for each without error, 0 at the tolerance.
    double agreement(const Eigen::Vector4d& plane, const std::vector<int>& lines) const;

    //! How many views saw them.
    size_t views(const std::vector<int>& lines) const;

    //! Whether a line is farther from the middle of the others than some times their extent.
    bool isIsolated(int line, const std::vector<int>& others) const;

    //! Plane nearest to the ends of the lines.
    ScenePlane fit(const std::vector<int>& lines) const;

    double tolerance; //!< px

private:
    const SceneLines& lines_;
    const LightPlane& light_;
    const Eigen::Matrix3d& K_;
    const AlignedVector<Pose>& cam2base_;
    const double pointTolerance_; //!< px
};

}} // namespace cv::active_handeye

#endif
