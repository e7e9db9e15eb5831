// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// The refinement's own linearisation, before there are data.
#include "precomp.hpp"
#include "refinement.hpp"

namespace cv { namespace active_handeye {

using Eigen::MatrixXd;

void HandEyeRefinement::assume(const AlignedVector<Eigen::Vector3d>& points,
                               const AlignedVector<Eigen::Vector4d>& surfaces, const StripeSegments& segments)
{
    problem_.state.points.clear();
    for (int column : tracks_.column)
        problem_.state.points.push_back(points[column]);
    problem_.noise =
        NoiseLevels{params_.pointSigma, params_.stripeSigma, params_.robotTranslationSigma, params_.robotRotationSigma};
    problem_.state.surfaces = surfaces;
    segments_ = segments;
    useStripes_ = !segments.empty();
    compactSurfaces();
}

//! Infinite variances of all parameters that a direction which nothing tells moves.
static void markUndetermined(const std::vector<WeakDirection>& weak, const MatrixXd& parametersByStep,
                             MatrixXd& covariance)
{
    const double nothingKnown = 1, negligible = 1e-7, infinity = std::numeric_limits<double>::infinity();
    for (const WeakDirection& direction : weak)
    {
        if (direction.deviation < nothingKnown)
            continue;
        CalibrationStep moved = direction.direction;
        for (int i = 0; i < CALIBRATION_COLUMNS; ++i)
            moved(i) = std::abs(moved(i)) > negligible * direction.direction.norm() ? moved(i) : 0;
        const Eigen::VectorXd parameters = parametersByStep * moved;
        for (int i = 0; i < parameters.size(); ++i)
            for (int j = 0; j < parameters.size(); ++j)
                if (parameters(i) * parameters(j) != 0)
                    covariance(i, j) = std::copysign(infinity, parameters(i) * parameters(j));
    }
}

void HandEyeRefinement::predict(RefineSummary& summary)
{
    const bool allFixed[] = {true, true, true, true};
    const double noFloors[] = {0, 0, 0, 0};
    problem_.linearizeData();
    components_.reset(new VarianceComponents(problem_, allFixed, noFloors));
    const std::vector<WeakDirection> weak = weakDirectionsOf(*components_);
    for (const WeakDirection& direction : weak)
        summary.weakDirections.push_back(direction.text);
    if (!observesTranslation())
        summary.weakDirections.push_back(unobservedTranslation(turns_.axis, turns_));
    summarizeParameters(summary);
    MatrixXd covariance =
        Eigen::Map<const Eigen::Matrix<double, 20, 20, Eigen::RowMajor>>(summary.covariance.ptr<double>());
    markUndetermined(weak, parametersByStep(calibration()), covariance);
    writeMatrix(covariance, summary.covariance);
}

}} // namespace cv::active_handeye
