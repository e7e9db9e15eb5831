// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "hand_eye_fit.hpp"
#include "distributions.hpp"

namespace cv { namespace active_handeye {

//! p-value below which a view is left out: 0.1 % for all tests of all views together.
double HandEyeFit::limit() const
{
    return 1e-3 / (2 * views_.count());
}

HandEyeFit::HandEyeFit(const HandEyeViews& views, const NoiseVariances& given, double length)
    : views_(views), variance_(given.cwiseAbs2()), iterations_(0)
{
    const double rounding = 1e-12;
    floors_ << rounding, rounding * length, rounding, rounding * length;
    floors_ = floors_.cwiseAbs2().eval();
    for (int k = 0; k < HAND_EYE_NOISES; ++k)
        isFree_[k] = given(k) < 0;
}

void HandEyeFit::linearize()
{
    residuals_.clear();
    for (int view : used_)
        residuals_.push_back(linearizedResidual(views_, view, state_));
    variances_ = std::allocate_shared<HandEyeVariances>(Eigen::aligned_allocator<HandEyeVariances>(), residuals_,
                                                        variance_, floors_, isFree_);
}

//! Least squares with the present levels, levels from its residuals, until neither changes.
void HandEyeFit::solve()
{
    const int maxRounds = 50;
    const double tolerance = 1e-8;
    double stepBefore = std::numeric_limits<double>::infinity();
    for (int round = 0; round < maxRounds; ++round)
    {
        HandEyeProblem problem(views_, used_, state_, variance_);
        iterations_ += solveLeastSquares(problem).iterations;
        state_ = problem.state();
        linearize();
        const double change = variances_->estimate(), step = variances_->squaredStep();
        variance_ = variances_->variances();
        if (change < tolerance && (step < 1e-12 || step >= stepBefore)) // or rounding is reached
            break;
        stepBefore = step;
    }
    if (variances_->squaredStep() < 1e-6) // sums of squares do not tell steps below 1e-7 standard deviations
    {
        state_ = state_.moved(variances_->step());
        linearize();
    }
}

double HandEyeFit::pValue(const HandEyeResidual& residual, int row, bool isUsed) const
{
    const Matrix6d ofState = residual.jacobian * variances_->covariance() * residual.jacobian.transpose();
    const Matrix6d covariance =
        isUsed ? residual.covariance(variance_) - ofState : Matrix6d(residual.covariance(variance_) + ofState);
    const Eigen::Vector3d r = residual.value.segment<3>(row);
    const double squares = r.dot(covariance.block<3, 3>(row, row).llt().solve(r));
    const int camera = row == 0 ? NOISE_TARGET_ROTATION : NOISE_TARGET_TRANSLATION,
              robot = row == 0 ? NOISE_ROBOT_ROTATION : NOISE_ROBOT_TRANSLATION;
    if (!isFree_[camera] && !isFree_[robot])
        return chiSquareTail(squares, 3);
    // The levels are estimates, and if the view is used also its own. Half of the degrees of freedom, since several levels share them.
    const double dof = 3. * usedViews() - 6, others = isUsed ? dof - 3 : dof;
    if (others < 1)
        return 1;
    const double rest = isUsed ? dof - squares : dof;
    return rest > 0 ? fTail(squares / 3 / (rest / others), 3, 0.5 * others) : 0;
}

Eigen::Vector2d HandEyeFit::pValues(int view) const
{
    const HandEyeResidual residual = linearizedResidual(views_, view, state_);
    return Eigen::Vector2d(pValue(residual, 0, isUsed(view)), pValue(residual, 3, isUsed(view)));
}

//! Leaves out the view that contradicts most, if it still does when the others alone give the solution.
void HandEyeFit::leaveOut(int view)
{
    used_.erase(std::find(used_.begin(), used_.end(), view));
    solve();
    if (pValues(view).minCoeff() >= limit())
        takeIn(view);
}

void HandEyeFit::takeIn(int view)
{
    used_.insert(std::upper_bound(used_.begin(), used_.end(), view), view);
    solve();
}

//! Leaves out the view that contradicts most, or takes in the one that agrees best; false when there is none.
bool HandEyeFit::exchangeView(std::vector<bool>& isDecided)
{
    int worst = -1, best = -1;
    double least = limit(), most = limit();
    for (int view = 0; view < views_.count(); ++view)
    {
        const double p = isDecided[view] ? limit() : pValues(view).minCoeff();
        if (isUsed(view) && p < least)
        {
            least = p;
            worst = view;
        }
        else if (!isUsed(view) && p > most)
        {
            most = p;
            best = view;
        }
    }
    if (worst >= 0 && usedViews() > 3)
    {
        isDecided[worst] = true;
        leaveOut(worst);
        return true;
    }
    if (best >= 0)
        takeIn(best);
    return best >= 0;
}

void HandEyeFit::run(const HandEyeStart& start)
{
    state_ = start.state;
    used_ = start.views;
    NoiseVariances squares = NoiseVariances::Zero();
    for (int view : used_)
    {
        const Vector6d residual = residualOf(views_, view, state_);
        const double angle = residual.head<3>().squaredNorm(), length = residual.tail<3>().squaredNorm();
        squares += Eigen::Vector4d(angle, length, angle, length) / (6. * used_.size());
    }
    for (int k = 0; k < HAND_EYE_NOISES; ++k)
        if (isFree_[k])
            variance_(k) = std::max(squares(k), floors_(k));
    solve();
    std::vector<bool> isDecided(views_.count(), false);
    while (exchangeView(isDecided))
        continue;
}

}} // namespace cv::active_handeye
