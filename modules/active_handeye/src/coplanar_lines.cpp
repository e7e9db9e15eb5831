// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "coplanar_lines.hpp"

#include <set>

namespace cv { namespace active_handeye {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::Vector4d;

CoplanarLines::CoplanarLines(const SceneLines& lines, const LightPlane& light, const Matrix3d& K,
                             const AlignedVector<Pose>& cam2base, double tolerancePx)
    : tolerance(tolerancePx), lines_(lines), light_(light), K_(K), cam2base_(cam2base), pointTolerance_(2 * tolerancePx)
{}

double CoplanarLines::error(const Vector4d& plane, int line) const
{
    const Pose& pose = cam2base_[lines_[line].view.view];
    Vector4d inCamera;
    inCamera << pose.R.transpose() * plane.head<3>(), plane(3) - plane.head<3>().dot(pose.t);
    const double error = lineError(K_, light_, inCamera, lines_[line].view);
    return std::isfinite(error) ? error : std::numeric_limits<double>::infinity();
}

Support CoplanarLines::support(const Vector4d& plane, int line) const
{
    const size_t fewestPoints = 4;
    const AlignedVector<Vector3d>& beside = lines_[line].beside;
    if (beside.size() < fewestPoints)
        return UNDECIDED;
    const double focal = std::sqrt(K_(0, 0) * K_(1, 1));
    const Vector3d& camera = cam2base_[lines_[line].view.view].t;
    size_t near = 0;
    for (const Vector3d& X : beside)
        near += std::abs(plane.head<3>().dot(X) - plane(3)) * focal <= pointTolerance_ * (X - camera).norm();
    return 2 * near >= beside.size() ? CONFIRMED : CONTRADICTED;
}

bool CoplanarLines::fits(const Vector4d& plane, int line, Support least) const
{
    return error(plane, line) <= tolerance && support(plane, line) >= least;
}

size_t CoplanarLines::views(const std::vector<int>& lines) const
{
    std::set<int> views;
    for (int line : lines)
        views.insert(lines_[line].view.view);
    return views.size();
}

bool CoplanarLines::isIsolated(int line, const std::vector<int>& others) const
{
    const double farthest = 4; // times the RMS distance of the others' ends from their middle
    Vector3d mean = Vector3d::Zero();
    for (int i : others)
        mean += (lines_[i].ends[0] + lines_[i].ends[1]) / (2. * double(others.size()));
    double squares = 0;
    for (int i : others)
        for (const Vector3d& X : lines_[i].ends)
            squares += (X - mean).squaredNorm() / (2. * double(others.size()));
    const Vector3d middle = 0.5 * (lines_[line].ends[0] + lines_[line].ends[1]);
    return (middle - mean).squaredNorm() > farthest * farthest * squares;
}

ScenePlane CoplanarLines::fit(const std::vector<int>& lines) const
{
    ScenePlane result;
    result.lines = lines;
    Vector3d mean = Vector3d::Zero();
    for (int i : lines)
        mean += (lines_[i].ends[0] + lines_[i].ends[1]) / (2. * double(lines.size()));
    Matrix3d scatter = Matrix3d::Zero();
    for (int i : lines)
        for (const Vector3d& X : lines_[i].ends)
            scatter += (X - mean) * (X - mean).transpose();
    const Eigen::SelfAdjointEigenSolver<Matrix3d> eigen(scatter);
    const Vector3d w = eigen.eigenvectors().col(0);
    result.plane << w, w.dot(mean);
    result.planarity = std::sqrt(std::max(0., eigen.eigenvalues()(1)) / eigen.eigenvalues()(2));
    return result;
}

std::vector<int> CoplanarLines::linesOn(const Vector4d& plane, const std::vector<int>& candidates, Support least) const
{
    std::vector<int> on;
    for (int line : candidates)
        if (fits(plane, line, least))
            on.push_back(line);
    return on;
}

double CoplanarLines::agreement(const Vector4d& plane, const std::vector<int>& lines) const
{
    double sum = 0;
    for (int line : lines)
        sum += 1 - std::pow(error(plane, line) / tolerance, 2);
    return sum;
}

}} // namespace cv::active_handeye
