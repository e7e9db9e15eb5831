// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "observability.hpp"
#include "residuals.hpp"
#include "view_choice.hpp"

#include "opencv2/core/utility.hpp"

namespace cv { namespace active_handeye {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

//! Numbers of points that are far from each other, the first one nearest to the middle.
static std::vector<int> spreadOut(const AlignedVector<Vector3d>& points, int count)
{
    Vector3d middle = Vector3d::Zero();
    for (const Vector3d& X : points)
        middle += X / double(points.size());
    std::vector<int> chosen;
    std::vector<double> distance;
    for (const Vector3d& X : points)
        distance.push_back((X - middle).norm());
    int next = int(std::min_element(distance.begin(), distance.end()) - distance.begin());
    distance.assign(points.size(), std::numeric_limits<double>::infinity());
    while (int(chosen.size()) < std::min(count, int(points.size())))
    {
        chosen.push_back(next);
        for (size_t j = 0; j < points.size(); ++j)
            distance[j] = std::min(distance[j], (points[j] - points[next]).norm());
        next = int(std::max_element(distance.begin(), distance.end()) - distance.begin());
    }
    return chosen;
}

ViewInformation::ViewInformation(const RefineProblem& problem, const AssumedScene& scene, int pointLimit)
    : problem_(problem), scene_(scene), points_(spreadOut(scene.points, pointLimit)),
      pointSigma_(problem.noise.point * std::sqrt(double(points_.size()) / double(scene.points.size()))),
      translations_(
          int(problem.unknowns.calibration.middleRows<3>(COLUMN_TRANSLATION).cwiseAbs().colwise().any().count())),
      information_(problem.reported.size())
{
    parallel_for_(Range(0, int(information_.size())),
                  [&](const Range& range)
                  {
                      for (int view = range.start; view < range.end; ++view)
                          information_[view] = informationOf(view);
                  });
}

MatrixXd ViewInformation::informationOf(int view) const
{
    const MatrixXd& B = problem_.unknowns.calibration;
    const int points = 3 * int(points_.size()), n = points + int(B.cols());
    const CameraView camera = scene_.view(problem_.reported[view]);
    MatrixXd information = MatrixXd::Zero(n, n), byPose = MatrixXd::Zero(n, 6);
    Eigen::Matrix<double, 6, 6> pose = Eigen::Matrix<double, 6, 6>::Zero();
    for (int k = 0; k < int(points_.size()); ++k)
    {
        const Vector3d& X = scene_.points[points_[k]];
        Eigen::Vector2d pixel;
        PointResidual residual;
        if (!scene_.project(camera, X, pixel) || !residual.linearize(scene_.calibration.camera, camera, X, pixel))
            continue;
        MatrixXd J = MatrixXd::Zero(2, n);
        J.middleCols<3>(3 * k) = residual.byPoint / pointSigma_;
        J.rightCols(B.cols()) = residual.byCalibration * B.topRows<POINT_COLUMNS>() / pointSigma_;
        const Eigen::Matrix<double, 2, 6> poseJ = residual.byPose(camera, X) / pointSigma_;
        information.noalias() += J.transpose() * J;
        byPose.noalias() += J.transpose() * poseJ;
        pose.noalias() += poseJ.transpose() * poseJ;
    }
    if (problem_.unknowns.poses[view] == POSE_EXACT)
        return information;
    Vector6d precision;
    precision << Vector3d::Constant(std::pow(problem_.noise.rotation, -2)),
        Vector3d::Constant(std::pow(problem_.noise.translation, -2));
    pose.diagonal() += precision;
    return information - byPose * pose.llt().solve(byPose.transpose());
}

MatrixXd ViewInformation::prior(double workingDistance, double imageRadius) const
{
    const double share = 0.1; // of what would mean that nothing is known
    const MatrixXd& B = problem_.unknowns.calibration;
    const int points = 3 * int(points_.size());
    VectorXd sigmas(points + B.cols());
    sigmas << VectorXd::Constant(points, share * workingDistance),
        share * unitsOf(B, naturalUnits(scene_.calibration, workingDistance, imageRadius));
    return sigmas.cwiseAbs2().cwiseInverse().asDiagonal();
}

double ViewInformation::variance(MatrixXd& information) const
{
    const Eigen::LLT<Eigen::Ref<MatrixXd>> llt(information);
    if (llt.info() != Eigen::Success)
        return std::numeric_limits<double>::infinity();
    // The unknowns of t_cam2gripper stand last: their covariance is (L L^T)^-1 of the last rows alone.
    const MatrixXd L = information.bottomRightCorner(translations_, translations_).triangularView<Eigen::Lower>();
    return L.triangularView<Eigen::Lower>().solve(MatrixXd::Identity(translations_, translations_)).squaredNorm();
}

}} // namespace cv::active_handeye
