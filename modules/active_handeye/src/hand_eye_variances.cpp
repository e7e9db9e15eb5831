// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "hand_eye_variances.hpp"
#include "decompositions.hpp"
#include "distributions.hpp"

namespace cv { namespace active_handeye {

// Gamma prior of shape 2 on the standard deviations (Chung et al. 2013): no level vanishes because the views are few.
static const double penalty = 1;

HandEyeVariances::HandEyeVariances(const HandEyeResiduals& residuals, const NoiseVariances& start,
                                   const NoiseVariances& floors, const bool (&isFree)[HAND_EYE_NOISES])
    : residuals_(&residuals), variances_(start), floors_(floors)
{
    std::copy(isFree, isFree + HAND_EYE_NOISES, isFree_);
    evaluate();
}

//! Generalised least squares with the present variances.
void HandEyeVariances::solve(AlignedVector<Matrix6d>& W, AlignedVector<Matrix6x12d>& WJ)
{
    Matrix12d H = Matrix12d::Zero();
    gradient_.setZero();
    deviance_ = 0;
    for (const HandEyeResidual& residual : *residuals_)
    {
        const Eigen::LLT<Matrix6d> llt(residual.covariance(variances_));
        W.push_back(llt.solve(Matrix6d::Identity()));
        WJ.push_back(W.back() * residual.jacobian);
        H += residual.jacobian.transpose() * WJ.back();
        gradient_ += WJ.back().transpose() * residual.value;
        deviance_ += 2 * llt.matrixLLT().diagonal().array().log().sum();
    }
    const Vector12d scale = H.diagonal().cwiseSqrt().cwiseInverse(); // unknowns of different units
    const Eigen::LLT<Matrix12d> llt(scale.asDiagonal() * H * scale.asDiagonal());
    covariance_ = scale.asDiagonal() * llt.solve(Matrix12d::Identity()) * scale.asDiagonal();
    deviance_ += 2 * (llt.matrixLLT().diagonal().array() / scale.array()).log().sum();
}

//! With W = covariance^-1 of the views and P = W - W J C J^T W: r^T P V_k P r, tr(P V_k) and tr(P V_k P V_l) / 2.
void HandEyeVariances::evaluate()
{
    AlignedVector<Matrix6d> W;
    AlignedVector<Matrix6x12d> WJ;
    solve(W, WJ);
    const Vector12d toOptimum = step();
    chiSquare_ = 0;
    quadratic_.setZero();
    trace_.setZero();
    information_.setZero();
    Matrix12d S[HAND_EYE_NOISES];
    std::fill(S, S + HAND_EYE_NOISES, Matrix12d(Matrix12d::Zero()));
    for (size_t i = 0; i < residuals_->size(); ++i)
    {
        const Vector6d r = (*residuals_)[i].value + (*residuals_)[i].jacobian * toOptimum, Pr = W[i] * r;
        const Matrix6d inner = W[i] - 2 * WJ[i] * covariance_ * WJ[i].transpose();
        chiSquare_ += r.dot(Pr);
        for (int k = 0; k < HAND_EYE_NOISES; ++k)
        {
            const Matrix6d V = (*residuals_)[i].covariance(k);
            quadratic_(k) += Pr.dot(V * Pr);
            trace_(k) += W[i].cwiseProduct(V).sum();
            S[k] += WJ[i].transpose() * V * WJ[i];
            for (int l = 0; l < HAND_EYE_NOISES; ++l)
                information_(k, l) += 0.5 * (V * W[i] * (*residuals_)[i].covariance(l)).cwiseProduct(inner).sum();
        }
    }
    deviance_ += chiSquare_;
    for (int k = 0; k < HAND_EYE_NOISES; ++k)
    {
        trace_(k) -= covariance_.cwiseProduct(S[k]).sum();
        for (int l = 0; l < HAND_EYE_NOISES; ++l)
            information_(k, l) += 0.5 * (covariance_ * S[k] * covariance_).cwiseProduct(S[l]).sum();
    }
    information_ = variances_.asDiagonal() * information_ * variances_.asDiagonal();
}

//! Of the logarithms of the variances, penalty included.
NoiseVariances HandEyeVariances::score() const
{
    return 0.5 * (variances_.cwiseProduct(quadratic_ - trace_).array() + penalty);
}

double HandEyeVariances::objective() const
{
    double sum = deviance_;
    for (int k = 0; k < HAND_EYE_NOISES; ++k)
        sum -= isFree_[k] ? penalty * std::log(variances_(k)) : 0;
    return sum;
}

//! At its floor a level takes part again only when there has to be more of it.
bool HandEyeVariances::isActive(int noise) const
{
    return isFree_[noise] && (variances_(noise) > floors_(noise) || score()(noise) > 0);
}

//! Inverse over the active noises, zero elsewhere.
NoiseMatrix HandEyeVariances::inverseOfActive(NoiseMatrix information) const
{
    for (int k = 0; k < HAND_EYE_NOISES; ++k)
        if (!isActive(k))
        {
            information.row(k).setZero();
            information.col(k).setZero();
            information(k, k) = 1;
        }
    NoiseMatrix inverse = inverseOfSymmetric(information);
    for (int k = 0; k < HAND_EYE_NOISES; ++k)
        if (!isActive(k))
            inverse(k, k) = 0;
    return inverse;
}

NoiseMatrix HandEyeVariances::logVarianceCovariance() const
{
    const double ridge = 1e-6; // two noises that act alike are not told apart
    return inverseOfActive(information_ + ridge * NoiseMatrix::Identity());
}

void HandEyeVariances::move(const NoiseVariances& logStep)
{
    for (int k = 0; k < HAND_EYE_NOISES; ++k)
        if (isFree_[k])
            variances_(k) = std::max(floors_(k), variances_(k) * std::exp(logStep(k)));
    evaluate();
}

//! Newton's step with the expected information, and where a level is small the observed one.
NoiseVariances HandEyeVariances::scoringStep() const
{
    const NoiseVariances slope = score(), observed = (slope.array() - 0.5 * penalty).abs();
    NoiseMatrix information = information_;
    information.diagonal() += observed;
    return inverseOfActive(information) * slope;
}

//! Minimum of a bound on the objective (Zhou et al. 2019), with the penalty: tr v^2 - penalty v - q v0^2 = 0.
NoiseVariances HandEyeVariances::ascentStep() const
{
    NoiseVariances step = NoiseVariances::Zero();
    for (int k = 0; k < HAND_EYE_NOISES; ++k)
        if (isActive(k))
        {
            const double trace = variances_(k) * trace_(k), quadratic = variances_(k) * quadratic_(k);
            step(k) = std::log((penalty + std::sqrt(penalty * penalty + 4 * trace * quadratic)) / (2 * trace));
        }
    return step;
}

double HandEyeVariances::estimate()
{
    const NoiseVariances start = variances_;
    const int maxIterations = 100;
    const double limit = 1.5, tolerance = 1e-9;
    for (int iteration = 0; iteration < maxIterations; ++iteration)
    {
        const NoiseVariances step = scoringStep();
        const double longest = step.cwiseAbs().maxCoeff(), before = objective();
        if (!(longest > tolerance))
            break;
        const HandEyeVariances here = *this;
        move(step * std::min(1., limit / longest));
        if (!(objective() <= before))
        {
            *this = here;
            move(ascentStep());
        }
    }
    return (variances_.array() / start.array().max(1e-300)).max(1e-300).log().cwiseAbs().maxCoeff() / 2;
}

double HandEyeVariances::degreesOfFreedom(int unknown) const
{
    const Vector12d direction = covariance_.col(unknown);
    NoiseVariances gradient = NoiseVariances::Zero();
    for (const HandEyeResidual& residual : *residuals_)
    {
        const Vector6d y = residual.covariance(variances_).llt().solve(residual.jacobian * direction);
        for (int k = 0; k < HAND_EYE_NOISES; ++k)
            gradient(k) += variances_(k) * y.dot(residual.covariance(k) * y);
    }
    const double variance = covariance_(unknown, unknown), spread = gradient.dot(logVarianceCovariance() * gradient);
    return spread > 0 ? 2 * variance * variance / spread : std::numeric_limits<double>::infinity();
}

//! Symmetric in the logarithm while that is known; else the variance itself is taken as normal.
Eigen::Vector2d HandEyeVariances::interval(int noise) const
{
    const double variance = variances_(noise),
                 normal95 = studentQuantile(0.05, std::numeric_limits<double>::infinity());
    if (!isFree_[noise])
        return Eigen::Vector2d::Constant(std::sqrt(variance));
    const double ofLogarithm = std::sqrt(logVarianceCovariance()(noise, noise)), known = 1;
    if (isActive(noise) && ofLogarithm < known)
        return Eigen::Vector2d(std::exp(-0.5 * normal95 * ofLogarithm), std::exp(0.5 * normal95 * ofLogarithm)) *
               std::sqrt(variance);
    const double ofVariance = variance / std::sqrt(information_(noise, noise));
    return Eigen::Vector2d(0, std::sqrt(variance + normal95 * ofVariance));
}

}} // namespace cv::active_handeye
