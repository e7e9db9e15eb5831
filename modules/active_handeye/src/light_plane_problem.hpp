// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_ACTIVE_HANDEYE_LIGHT_PLANE_PROBLEM_HPP
#define OPENCV_ACTIVE_HANDEYE_LIGHT_PLANE_PROBLEM_HPP

#include "least_squares.hpp"
#include "stripe_lines.hpp"

namespace cv { namespace active_handeye {

//! n.X = d in the camera frame.
struct LightPlane
{
    Eigen::Vector3d n;
    double d;
};

//! One segment of a surface: its line and where the camera stood.
struct StripeView
{
    int segment, view;
    StripeLine line;
    Eigen::Vector3d rays[2];      //!< through the two ends of the line, (x, y, 1)
    Eigen::Vector3d displacement; //!< of the camera since the group's first view, camera frame
};

//! A fixed plane of the scene as seen by one group of views that differ by translations only.
struct StripeSurface
{
    int group, id;
    AlignedVector<StripeView> views;
    Eigen::Vector4d plane =
        Eigen::Vector4d::Zero(); //!< (w, e0), w.X = e0 in the camera frame of the group's first view; length 1
};

typedef AlignedVector<StripeSurface> StripeSurfaces;

//! m ~ (e0 - w.c) n - d w: normal of the plane through the camera's centre and the stripe.
Eigen::Vector3d interpretationPlane(const LightPlane& light, const Eigen::Vector4d& surface,
                                    const Eigen::Vector3d& displacement);

//! RMS distance [px] of the two ends of the line to the line predicted.
double lineError(const Eigen::Matrix3d& K, const LightPlane& light, const Eigen::Vector4d& surface,
                 const StripeView& view);

/** Maximum likelihood over n (2), d (1) and the plane of each surface (3): distance of the ends of each line to the line
predicted, in units of its sigma. Known points of the light plane add n.X - d in units of 1/1000 of their depth.
*/
class LightPlaneProblem : public LeastSquaresProblem
{
public:
    //! cauchyScale: distance [px] at which a residual's weight is one half; infinity = plain least squares.
    LightPlaneProblem(const Eigen::Matrix3d& K, const AlignedVector<Eigen::Vector3d>& knownPoints, double cauchyScale,
                      const LightPlane& start, const StripeSurfaces& surfaces);

    double linearize(Eigen::MatrixXd& JtJ, Eigen::VectorXd& Jtr) CV_OVERRIDE;
    double costAfter(const Eigen::VectorXd& step) const CV_OVERRIDE;
    void apply(const Eigen::VectorXd& step) CV_OVERRIDE;

    const LightPlane& light() const { return light_; }
    const StripeSurfaces& surfaces() const { return surfaces_; }
    int residuals() const;
    int unknowns() const { return 3 + 3 * int(surfaces_.size()); }

private:
    struct State
    {
        LightPlane light;
        AlignedVector<Eigen::Vector4d> planes;
    };
    State moved(const Eigen::VectorXd& step) const;
    double cost(const State& state) const;
    double robustCost(double residual, double sigma) const;
    double robustWeight(double residual, double sigma) const;

    Eigen::Matrix3d lineOfPlane_; //!< K^-T: interpretation plane -> line in ideal pixels
    const AlignedVector<Eigen::Vector3d>& knownPoints_;
    double cauchyScale_;
    LightPlane light_;
    StripeSurfaces surfaces_;
};

}} // namespace cv::active_handeye

#endif
