// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// Whether the data determine an answer, and what they lack.
#include "precomp.hpp"
#include "observability.hpp"
#include "decompositions.hpp"
#include "refinement.hpp"

namespace cv { namespace active_handeye {

using Eigen::MatrixXd;

// Of what would mean that nothing is known. Known points leave hardly more than a linear problem, whose intervals hold farther.
static const double weakLimit = 0.005, refusedLimit = 0.02, refusedLimitWithKnownPoints = 0.2;

//! Noise levels that the data cannot tell apart make a covariance of nothing.
void HandEyeRefinement::requireRedundancy() const
{
    const double smallestRedundancy = 20;
    const double largestInflation = 1e11;
    const double inflation = components_->varianceInflation(int(problem_.unknowns.calibration.cols()));
    if (inflation > largestInflation)
        CV_Error(
            Error::StsNoConv,
            cv::format(
                "refineHandEye: the data do not determine the result (variance inflation %.2g); needed more views, in other "
                "orientations and at other places",
                inflation));
    const double redundancy = components_->effectiveRedundancy(NOISE_POINT);
    if (components_->isEstimated(NOISE_POINT) && redundancy < smallestRedundancy)
        CV_Error(
            Error::StsNoConv,
            cv::format(
                "imagePoints: too few to tell image noise from the robot's; needed a redundancy of %g, given %.1f: add "
                "points or views, or give params.pointSigma",
                smallestRedundancy, redundancy));
}

std::vector<WeakDirection> HandEyeRefinement::weakDirectionsOf(const VarianceComponents& components) const
{
    const MatrixXd& B = problem_.unknowns.calibration;
    const MatrixXd covariance = components.covariance().topLeftCorner(B.cols(), B.cols());
    double imageRadius = 1e-3;
    const Camera& camera = problem_.state.calibration.camera;
    for (const PointObservation& o : tracks_.observations)
        if (o.used)
            imageRadius = std::max(imageRadius, camera.ray(o.pixel).head<2>().norm());
    return findWeakDirections(inverseOfSymmetric(covariance), B, calibration(), workingDistance(), imageRadius, turns_,
                              weakLimit);
}

static bool isLens(const WeakDirection& weak)
{
    return weak.direction.segment<5>(COLUMN_DISTORTION).squaredNorm() > 0.5 * weak.direction.squaredNorm();
}

static std::string refusalOf(const std::vector<WeakDirection>& weak, double limit)
{
    std::string refused;
    for (const WeakDirection& direction : weak)
        if (direction.deviation > limit && !isLens(direction))
            refused += (refused.empty() ? "" : "; ") + direction.text;
    return refused;
}

/** Largest ratio of the parameters' standard deviations with the distortion of the start to those with the distortion found.

Strong distortion, real or not, holds the principal point and the rotation. Where the distortion is badly determined this must not matter.
*/
double HandEyeRefinement::deviationsHeldByLens()
{
    const bool allFixed[] = {true, true, true, true};
    const double noFloors[] = {0, 0, 0, 0};
    double found[5];
    double (&D)[5] = problem_.state.calibration.camera.D;
    std::copy(D, D + 5, found);
    std::copy(start_.camera.D, start_.camera.D + 5, D);
    problem_.linearizeData();
    const VarianceComponents atStart(problem_, allFixed, noFloors);
    std::copy(found, found + 5, D);
    problem_.linearizeData();
    const Eigen::Index f = problem_.unknowns.calibration.cols();
    return std::sqrt(
        atStart.covariance().diagonal().head(f).cwiseQuotient(components_->covariance().diagonal().head(f)).maxCoeff());
}

/** As weakDirectionsOf(), with the motion that was reported instead of the one found.

What is known from the corrections of the poses alone is noise taken for motion: where the reported motion does not determine the scale, a
smaller scene needs smaller corrections, a more precise robot explains them, and so on until the scene is a point.
*/
std::vector<WeakDirection> HandEyeRefinement::weakDirectionsOfReportedMotion() const
{
    const bool allFixed[] = {true, true, true, true};
    const double noFloors[] = {0, 0, 0, 0};
    RefineProblem reported = problem_;
    for (size_t view = 0; view < reported.reported.size(); ++view)
        if (reported.unknowns.poses[view] == POSE_PRIOR)
            reported.state.gripper2base[view] = reported.reported[view];
    reported.linearizeData();
    return weakDirectionsOf(VarianceComponents(reported, allFixed, noFloors));
}

static void refuse(const std::string& weak)
{
    CV_Error(Error::StsNoConv, "refineHandEye: the data do not determine the result: " + weak);
}

//! Where the iterations did not end, the motion is to blame if it leaves something open, else the poses or the start are.
void HandEyeRefinement::requireConvergence(double limit) const
{
    if (converged_)
        return;
    const std::string open = refusalOf(weakDirectionsOfReportedMotion(), limit);
    if (!open.empty())
        refuse(open);
    CV_Error(Error::StsNoConv,
             cv::format("refineHandEye: no convergence after params.maxIterations = %d; needed poses that belong to "
                        "the images, or a better start",
                        params_.maxIterations));
}

void HandEyeRefinement::requireAnswer()
{
    const std::vector<WeakDirection> weak = weakDirectionsOf(*components_);
    for (const WeakDirection& direction : weak)
        weakDirections_.push_back(direction.text);
    const double limit = tracks_.anyKnown() ? refusedLimitWithKnownPoints : refusedLimit;
    requireConvergence(limit);
    requireRedundancy();
    const double largestRatio = 1.5;
    const std::vector<WeakDirection>::const_iterator lens = std::find_if(weak.begin(), weak.end(), isLens);
    std::string refused = refusalOf(weak, limit);
    if (refused.empty())
        refused = refusalOf(weakDirectionsOfReportedMotion(), limit);
    if (refused.empty() && lens != weak.end() && deviationsHeldByLens() > largestRatio)
        refused = lens->text + ", or give distCoeffs or a smaller lensModel: other parameters hang on it";
    if (!refused.empty())
        refuse(refused);
    if (!observesTranslation())
        weakDirections_.push_back(unobservedTranslation(turns_.axis, turns_));
}

}} // namespace cv::active_handeye
