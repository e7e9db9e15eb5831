// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_ACTIVE_HANDEYE_LIGHT_PLANE_CALIBRATION_HPP
#define OPENCV_ACTIVE_HANDEYE_LIGHT_PLANE_CALIBRATION_HPP

#include "light_plane_diagnosis.hpp"
#include "motion_groups.hpp"

namespace cv { namespace active_handeye {

struct Contradiction
{
    std::string text;
    double error; //!< px
};

//! A light plane that may explain the stripes, with the surfaces that go with it.
struct LightPlaneExplanation
{
    LightPlane light;
    StripeSurfaces surfaces;
    double cost; //!< sum of squared residuals
};

/** The calibration as a list of steps over its state, in the order of the public functions.

Lengths are in units of `unit` inside, so that all numbers are about one.
*/
class LightPlaneCalibration
{
public:
    Camera camera;
    AlignedVector<Eigen::Vector3d> knownPoints;
    GroupOrientations cam2base;
    double unit = 1;
    StripeSurfaces surfaces;

    //! All steps. Throws StsNoConv where the stripes do not determine the light plane.
    void calibrate(const AlignedVector<Pose>& gripper2base, const Eigen::Matrix3d& cam2gripper,
                   const std::vector<Pixels>& stripes, const std::vector<int>& views, const std::vector<int>& ids,
                   double orientationTolerance);

    LightPlane light() const { return LightPlane{light_.n, light_.d * unit}; }
    Eigen::Matrix4d covariance() const;
    double rms() const;
    void warn() const; //!< names the segments left out

private:
    //! Segments with a surface id, as lines, by group and surface.
    void readSurfaces(const AlignedVector<Pose>& gripper2base, const std::vector<MotionGroup>& groups,
                      const Eigen::Matrix3d& cam2gripper, const std::vector<Pixels>& stripes,
                      const std::vector<int>& views, const std::vector<int>& ids);
    void requireViews();   //!< keeps surfaces seen in three views
    void findDirections(); //!< vanishing directions; a surface whose lines meet nowhere is mislabelled and dropped
    void start();          //!< closed form
    void refine();         //!< maximum likelihood, robust first; drops segments that contradict
    void requireOneExplanation(); //!< where the answer is weak: no other light plane explains the stripes as well
    void requireAnswer() const;   //!< throws when the answer is weak or rests on too few of the segments
    LeastSquaresSummary solve(double cauchyScale);
    void updateCovariance(const LeastSquaresSummary& summary);
    double normalDeviation() const; //!< rad
    AlignedVector<LightPlaneExplanation> explanations() const;
    bool dropContradictions();
    void dropThinSurfaces();
    void drop(StripeSurface& surface, size_t view, double error);
    std::string contradictionList() const;
    CV_NORETURN void failContradiction() const;

    std::vector<VanishingDirection> directions_;
    LightPlane light_;
    LeastSquaresSummary solution_;
    Eigen::Matrix3d covariance_; //!< tangent of n (2), d in units
    double misfit_ = 1;          //!< variance of the residuals, in units of what the pixels' scatter says
    bool observable_ = false;
    std::vector<Contradiction> contradictions_;
    size_t given_ = 0;
};

}} // namespace cv::active_handeye

#endif
