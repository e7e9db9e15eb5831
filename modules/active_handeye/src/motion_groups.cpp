// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "input.hpp"
#include "motion_groups.hpp"

namespace cv { namespace active_handeye {

using Eigen::Matrix3d;

double angleBetween(const Matrix3d& R1, const Matrix3d& R2)
{
    return logRotation(R1.transpose() * R2).norm() * (180 / CV_PI);
}

static Matrix3d meanRotation(const std::vector<int>& views, const AlignedVector<Pose>& gripper2base)
{
    const Matrix3d& first = gripper2base[views[0]].R;
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (int view : views)
        mean += logRotation(first.transpose() * gripper2base[view].R) / double(views.size());
    return first * expRotation(mean);
}

std::vector<MotionGroup> groupByOrientation(const AlignedVector<Pose>& gripper2base, double toleranceDeg)
{
    std::vector<MotionGroup> groups;
    for (int view = 0; view < int(gripper2base.size()); ++view)
    {
        const auto sameOrientation = [&](const MotionGroup& group)
        { return angleBetween(gripper2base[group.views[0]].R, gripper2base[view].R) <= toleranceDeg; };
        auto group = std::find_if(groups.begin(), groups.end(), sameOrientation);
        if (group == groups.end())
            group = groups.insert(groups.end(), MotionGroup());
        group->views.push_back(view);
    }
    for (MotionGroup& group : groups)
        group.R = meanRotation(group.views, gripper2base);
    return groups;
}

void requireTranslation(const std::vector<MotionGroup>& groups, const AlignedVector<Pose>& gripper2base,
                        double toleranceDeg)
{
    if (std::any_of(groups.begin(), groups.end(), [](const MotionGroup& g) { return g.views.size() > 1; }))
        return;
    int nearest[2] = {0, 0};
    double smallest = std::numeric_limits<double>::infinity();
    for (int i = 0; i < int(gripper2base.size()); ++i)
        for (int j = i + 1; j < int(gripper2base.size()); ++j)
        {
            const double angle = angleBetween(gripper2base[i].R, gripper2base[j].R);
            if (angle < smallest)
                smallest = angle, nearest[0] = i, nearest[1] = j;
        }
    CV_Error(
        Error::StsNoConv,
        cv::format(
            "R_gripper2base: no two views have equal orientation; needed at least two views whose orientations differ by at "
            "most orientationTolerance = %g deg, given %d views of which views %d and %d come nearest with %.3f deg",
            toleranceDeg, int(gripper2base.size()), nearest[0], nearest[1], smallest));
}

void groupViews(InputArrayOfArrays R_gripper2base, OutputArray groupIds, double orientationTolerance)
{
    CV_TRACE_FUNCTION();
    const double tolerance = readPositive(orientationTolerance, "orientationTolerance");
    AlignedVector<Pose> poses;
    for (const Matrix3d& R : readRotations(R_gripper2base, "R_gripper2base"))
        poses.push_back(Pose{R, Eigen::Vector3d::Zero()});
    groupIds.create(int(poses.size()), 1, CV_32S);
    Mat ids = groupIds.getMat();
    const std::vector<MotionGroup> groups = groupByOrientation(poses, tolerance);
    for (int g = 0; g < int(groups.size()); ++g)
        for (int view : groups[g].views)
            ids.at<int>(view) = g;
}

}} // namespace cv::active_handeye
