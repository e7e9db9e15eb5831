// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "translations_problem.hpp"

namespace cv { namespace active_handeye {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;

namespace {

std::string text(const Vector3d& v)
{
    return cv::format("(%.2f, %.2f, %.2f)", v.x(), v.y(), v.z());
}

} // namespace

GroupTranslations::GroupTranslations(const AlignedVector<Pose>& gripper2base, double toleranceDeg)
    : groups(groupByOrientation(gripper2base, toleranceDeg)), displacement(gripper2base.size(), Vector3d::Zero()),
      rotation(gripper2base.size(), Matrix3d::Identity()), R_gripper2base(Matrix3d::Identity()), length(0)
{
    requireTranslation(groups, gripper2base, toleranceDeg);
    Matrix3d scatter = Matrix3d::Zero();
    size_t largest = 0;
    int moved = 0;
    for (const MotionGroup& group : groups)
    {
        Vector3d mean = Vector3d::Zero();
        for (int view : group.views)
        {
            displacement[view] = group.displacement(gripper2base[group.views[0]], gripper2base[view]);
            rotation[view] = group.R.transpose() * gripper2base[view].R;
            mean += displacement[view] / double(group.views.size());
        }
        for (int view : group.views)
        {
            scatter += (displacement[view] - mean) * (displacement[view] - mean).transpose();
            length += (displacement[view] - mean).norm();
            moved += group.views.size() > 1;
        }
        if (group.views.size() > largest)
            largest = group.views.size(), R_gripper2base = group.R;
    }
    length /= moved;
    const Eigen::SelfAdjointEigenSolver<Matrix3d> eigen(scatter); // ascending
    axes = eigen.eigenvectors().rowwise().reverse();
    const double minimumSpread = 0.01; // of the largest: about half a degree
    int rank = 0;
    while (rank < 3 && length > 0 &&
           eigen.eigenvalues()[2 - rank] > minimumSpread * minimumSpread * eigen.eigenvalues()[2])
        ++rank;
    directions = axes.leftCols(rank);
    if (length > 0)
        for (Vector3d& b : displacement)
            b /= length;
}

void GroupTranslations::requireDirections(int needed, const std::string& purpose) const
{
    const int given = int(directions.cols());
    if (given >= needed)
        return;
    const Matrix3d base = R_gripper2base * axes;
    if (given == 0)
        CV_Error(Error::StsNoConv,
                 "t_gripper2base: the views of equal orientation are all at one place; needed translations: " +
                     purpose + ", given none");
    if (given == 1)
        CV_Error(Error::StsNoConv, "t_gripper2base: all translations are parallel; needed translations: " + purpose +
                                       ", given only along " + text(base.col(0)) +
                                       " in base coordinates: add one along " + text(base.col(1)) +
                                       (needed > 2 ? " and one along " + text(base.col(2)) : ""));
    CV_Error(Error::StsNoConv, "t_gripper2base: all translations are coplanar; needed translations: " + purpose +
                                   ", given none out of one plane: add one along " + text(base.col(2)) +
                                   " in base coordinates");
}

TranslationsProblem::TranslationsProblem(const GroupTranslations& motion, const std::vector<Pixels>& pixels,
                                         const Normalization& T, const ProjectionSolver& solver)
    : motion_(motion), solver_(solver), orientationsDiffer_(false)
{
    std::vector<Pixels> normalized = pixels;
    for (Pixels& view : normalized)
        for (Eigen::Vector2d& x : view)
            x = T.apply(x);
    for (const MotionGroup& group : motion.groups)
        tracks.add(normalized, group.views);
    models.resize(pixels.size());
    toImage.assign(pixels.size(), Matrix3d::Identity());
    const double rounding = 1e-12;
    for (size_t view = 0; view < models.size(); ++view)
    {
        models[view].b = motion.displacement[view];
        orientationsDiffer_ = orientationsDiffer_ || !motion.rotation[view].isIdentity(rounding);
    }
    pixelsPerUnit = 1 / T.scale;
    function = "calibrateHandEyeTranslations";
}

Vector9d TranslationsProblem::minimize(const Matrix9d& S)
{
    projection = solver_.minimize(S);
    const double f = std::sqrt(projection.K(0, 0) * projection.K(1, 1)) / pixelsPerUnit, shortest = 0.1;
    tracks.focalLength = f > shortest ? f : shortest; // a bad start may have none
    return solver_.vector(projection);
}

bool TranslationsProblem::updateImages(const Vector9d& p)
{
    if (!orientationsDiffer_)
        return false;
    // The orientation of a view differs from its group's by dR, within the tolerance: x ~ P dR^T P^-1 (Z - P b).
    const Matrix3d P = toMatrix(p), inverse = P.inverse();
    for (size_t view = 0; view < toImage.size(); ++view)
        toImage[view] = P * motion_.rotation[view].transpose() * inverse;
    return true;
}

bool TranslationsProblem::mirror(const Matrix9d& S, Vector9d& p)
{
    if (!solver_.mirror(projection))
        return false;
    projection = solver_.minimizeFrom(projection, S); // translations of almost one plane: almost a minimum
    p = solver_.vector(projection);
    return true;
}

}} // namespace cv::active_handeye
