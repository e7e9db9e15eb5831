// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "hand_eye_motions.hpp"
#include "decompositions.hpp"
#include "hand_eye_closed_forms.hpp"
#include "numbers.hpp"
#include "turn_directions.hpp"

namespace cv { namespace active_handeye {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;

Pose inverse(const Pose& pose)
{
    return Pose{pose.R.transpose(), -(pose.R.transpose() * pose.t)};
}

Pose operator*(const Pose& second, const Pose& first)
{
    return Pose{second.R * first.R, second.R * first.t + second.t};
}

HandEyeMotions motionsOf(const HandEyeViews& views)
{
    HandEyeMotions motions;
    for (int i = 0; i < views.count(); ++i)
        for (int j = i + 1; j < views.count(); ++j)
            motions.push_back(HandEyeMotion{inverse(views.gripper2base[j]) * views.gripper2base[i],
                                            views.target2cam[j] * inverse(views.target2cam[i])});
    return motions;
}

namespace {

AlignedVector<Pose> inverses(const AlignedVector<Pose>& poses)
{
    AlignedVector<Pose> result;
    for (const Pose& pose : poses)
        result.push_back(inverse(pose));
    return result;
}

double largestTurn(const AlignedVector<Pose>& poses)
{
    double largest = 0;
    for (const Pose& pose : poses)
        largest = std::max(largest, logRotation(poses[0].R.transpose() * pose.R).norm());
    return largest * 180 / CV_PI;
}

bool anyTranslation(const AlignedVector<Pose>& poses)
{
    double farthest = 0, length = 0;
    for (const Pose& pose : poses)
    {
        farthest = std::max(farthest, (pose.t - poses[0].t).norm());
        length = std::max(length, pose.t.norm());
    }
    return farthest > 1e-9 * length;
}

void requireTurnsOf(const AlignedVector<Pose>& poses, const char* name, const char* moving)
{
    const TurnDirections turns(poses);
    if (turns.observed.cols() == 3)
        return;
    const char* const needed = "needed turns of more than %g deg about two axes that are not parallel, given ";
    const std::string start = std::string(name) + ": " + cv::format(needed, smallestTurn);
    if (turns.observed.cols() == 0)
        CV_Error(Error::StsNoConv,
                 start + (anyTranslation(poses)
                              ? cv::format("translations alone (turns of at most %.3f deg)", largestTurn(poses))
                              : std::string("no motion at all")));
    const Vector3d a = turns.axis, across = a.unitOrthogonal();
    CV_Error(
        Error::StsNoConv,
        start +
            cv::format(
                "turns about one axis, (%.2f, %.2f, %.2f) in the %s frame: the turn of the camera about this axis and its "
                "position along it are not observed; add a turn about an axis across it, such as (%.2f, %.2f, %.2f)",
                a.x(), a.y(), a.z(), moving, across.x(), across.y(), across.z()));
}

//! How far the views are from agreeing on the target, against what the gripper's motion would do to it.
struct Disagreement
{
    double angle, turn;    //!< median and what it is measured by, rad
    double distance, path; //!< the same of the position

    double ratio() const { return std::max(angle / turn, distance / path); }
};

Disagreement disagreement(const HandEyeViews& views, const Pose& cam2gripper)
{
    const int n = views.count();
    Matrix3d gripperSum = Matrix3d::Zero(), targetSum = Matrix3d::Zero();
    std::vector<double> coordinates[3], angles, distances;
    Vector3d gripper = Vector3d::Zero(), arm = Vector3d::Zero();
    for (int view = 0; view < n; ++view)
    {
        const Pose target = views.target2base(view, cam2gripper);
        gripperSum += views.gripper2base[view].R;
        targetSum += target.R;
        gripper += views.gripper2base[view].t / n;
        arm += (target.t - views.gripper2base[view].t) / n;
        for (int axis = 0; axis < 3; ++axis)
            coordinates[axis].push_back(target.t[axis]);
    }
    const Matrix3d orientation = nearestRotation(gripperSum), targetOrientation = nearestRotation(targetSum);
    const Vector3d place(median(coordinates[0]), median(coordinates[1]), median(coordinates[2]));
    double turns = 0, paths = 0;
    for (int view = 0; view < n; ++view)
    {
        const Pose target = views.target2base(view, cam2gripper);
        const Pose& pose = views.gripper2base[view];
        angles.push_back(logRotation(targetOrientation.transpose() * target.R).norm());
        distances.push_back((target.t - place).norm());
        turns += logRotation(orientation.transpose() * pose.R).squaredNorm() / n;
        paths += ((pose.t - gripper).squaredNorm() + (target.t - pose.t - arm).squaredNorm()) / n;
    }
    return Disagreement{median(angles), std::sqrt(turns), median(distances), std::sqrt(paths) + 1e-300};
}

//! A hint when the views agree with one kind of poses inverted; it cannot be told which kind.
std::string hintOfInversion(const HandEyeViews& views)
{
    HandEyeViews inverted = views;
    inverted.gripper2base = inverses(views.gripper2base);
    const HandEyeMotions motions = motionsOf(inverted);
    const Matrix3d R = rotationFromLogarithms(motions);
    if (disagreement(inverted, Pose{R, translationOf(motions, R)}).ratio() > 0.1)
        return "";
    return "; they agree when the poses of either the robot or the target are inverted: R_gripper2base, t_gripper2base map "
           "from gripper to base (the other way round with a camera beside the robot), R_target2cam, t_target2cam from "
           "target to camera";
}

} // namespace

void requireTurns(const HandEyeViews& views)
{
    requireTurnsOf(views.gripper2base, "R_gripper2base", "gripper");
    requireTurnsOf(inverses(views.target2cam), "R_target2cam", "camera");
}

void requireSameUnit(const HandEyeMotions& motions)
{
    const Matrix3d R = rotationFromLogarithms(motions);
    MatrixXd A(3 * motions.size(), 4);
    Eigen::VectorXd b(3 * motions.size());
    for (int k = 0; k < int(motions.size()); ++k)
    {
        A.middleRows<3>(3 * k) << motions[k].gripper.R - Matrix3d::Identity(), -R * motions[k].camera.t;
        b.segment<3>(3 * k) = -motions[k].gripper.t;
    }
    const Eigen::Vector4d x = leastSquaresSolution(A, b);
    const double unit = std::max(x(3), 1 / x(3)), misfit = (A * x - b).norm();
    const double misfitAsGiven = (A.leftCols<3>() * translationOf(motions, R) + A.col(3) - b).norm();
    if (x(3) > 0 && unit > 300 && unit < 3000 && misfit < 0.1 * misfitAsGiven)
        CV_Error(Error::StsBadArg,
                 cv::format("t_target2cam: millimetres and metres seem to be mixed; needed the unit of length of "
                            "t_gripper2base, given translations that fit those when multiplied by %.4g",
                            x(3)));
}

void requireAgreement(const HandEyeViews& views, const Pose& cam2gripper)
{
    const double largestRatio = 0.3;
    const Disagreement found = disagreement(views, cam2gripper);
    if (found.ratio() <= largestRatio)
        return;
    const std::string hint = hintOfInversion(views);
    const double degrees = 180 / CV_PI;
    if (found.angle / found.turn > largestRatio)
        CV_Error(
            Error::StsNoConv,
            cv::format(
                "R_gripper2base, R_target2cam: the orientations contradict each other; needed views that agree on the "
                "target, given turns of %.3g deg (RMS) after which it differs by %.3g deg (median)",
                found.turn * degrees, found.angle * degrees) +
                hint);
    CV_Error(
        Error::StsNoConv,
        cv::format(
            "t_gripper2base, t_target2cam: the positions contradict each other; needed views that agree on the target, "
            "given motions of %.3g (RMS) after which it differs by %.3g (median)",
            found.path, found.distance) +
            hint);
}

void requireMostViews(const HandEyeViews& views, int agreeing)
{
    if (3 * agreeing < 2 * views.count())
        CV_Error(
            Error::StsNoConv,
            cv::format(
                "R_gripper2base, R_target2cam: the views contradict each other; needed two thirds of them to agree, "
                "given %d of %d",
                agreeing, views.count()) +
                hintOfInversion(views));
}

}} // namespace cv::active_handeye
