// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_ACTIVE_HANDEYE_TRANSLATIONS_PROBLEM_HPP
#define OPENCV_ACTIVE_HANDEYE_TRANSLATIONS_PROBLEM_HPP

#include "motion_groups.hpp"
#include "projection.hpp"
#include "track_fit.hpp"

namespace cv { namespace active_handeye {

//! Where the gripper was, seen from the first view of its group, and which directions that covers.
struct GroupTranslations
{
    GroupTranslations(const AlignedVector<Pose>& gripper2base, double toleranceDeg);

    //! Throws StsNoConv when the translations cover too few directions, naming what is missing in base coordinates.
    void requireDirections(int needed, const std::string& purpose) const;

    std::vector<MotionGroup> groups;             //!< all groups
    AlignedVector<Eigen::Vector3d> displacement; //!< per view, gripper frame, in units of `length`
    AlignedVector<Eigen::Matrix3d>
        rotation;                   //!< per view: R_group^T R_view, the rest of the orientation within the tolerance
    Eigen::MatrixXd directions;     //!< 3 x r orthonormal basis of the displacements, gripper frame
    Eigen::Matrix3d axes;           //!< directions, completed by what is missing
    Eigen::Matrix3d R_gripper2base; //!< of the largest group
    double length;                  //!< mean length of the displacements
};

//! x ~ Z_j - P b_i (doc/method/translations.md), for given displacements.
class TranslationsProblem : public TrackProblem<TranslationModel>
{
public:
    TranslationsProblem(const GroupTranslations& motion, const std::vector<Pixels>& pixels, const Normalization& T,
                        const ProjectionSolver& solver);

    Vector9d minimize(const Matrix9d& S) CV_OVERRIDE;
    bool updateImages(const Vector9d& p) CV_OVERRIDE;
    bool mirror(const Matrix9d& S, Vector9d& p) CV_OVERRIDE;
    Eigen::MatrixXd tangent() const CV_OVERRIDE { return solver_.tangent(projection); }

    Projection projection;

protected:
    const GroupTranslations& motion_;
    const ProjectionSolver& solver_;

private:
    bool orientationsDiffer_; //!< within the tolerance
};

}} // namespace cv::active_handeye

#endif
