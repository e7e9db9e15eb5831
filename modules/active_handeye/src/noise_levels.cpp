// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "noise_levels.hpp"
#include "decompositions.hpp"

namespace cv { namespace active_handeye {

using Eigen::Matrix4d;
using Eigen::MatrixXd;
using Eigen::Vector4d;
using Eigen::VectorXd;

//! (L L^T)^-1 = L^-T L^-1; columns of L^-1 are solved for in blocks, which skips the zeros above its diagonal.
static MatrixXd inverse(const Eigen::LLT<MatrixXd>& llt)
{
    const int n = int(llt.rows()), width = 32;
    const MatrixXd& L = llt.matrixLLT();
    MatrixXd inverseOfL = MatrixXd::Identity(n, n);
    for (int at = 0; at < n; at += width)
    {
        const int columns = std::min(width, n - at), rows = n - at;
        L.bottomRightCorner(rows, rows)
            .triangularView<Eigen::Lower>()
            .solveInPlace(inverseOfL.block(at, at, rows, columns));
    }
    MatrixXd result(n, n);
    for (int at = 0; at < n; at += width)
    {
        const int columns = std::min(width, n - at), rows = n - at;
        result.block(at, 0, columns, at + columns).noalias() =
            inverseOfL.block(at, at, rows, columns).transpose() * inverseOfL.block(at, 0, rows, at + columns);
    }
    return result.selfadjointView<Eigen::Lower>();
}

VarianceComponents::VarianceComponents(const RefineProblem& problem, const bool (&isFixed)[NOISE_COMPONENTS],
                                       const double (&floors)[NOISE_COMPONENTS])
    : problem_(problem)
{
    const NoiseLevels& noise = problem.noise;
    const double start[] = {noise.point, noise.stripe, noise.translation, noise.rotation};
    const int n = problem.unknowns.count();
    corrections_.setZero(n);
    prior_[NOISE_TRANSLATION].setZero(n);
    prior_[NOISE_ROTATION].setZero(n);
    for (int view = 0; view < int(problem.unknowns.poses.size()); ++view)
    {
        if (problem.unknowns.poses[view] != POSE_PRIOR)
            continue;
        const int column = problem.unknowns.poseColumn(view);
        corrections_.segment<6>(column) = problem.correction(view);
        prior_[NOISE_ROTATION].segment<3>(column).setOnes();
        prior_[NOISE_TRANSLATION].segment<3>(column + 3).setOnes();
    }
    count_[NOISE_POINT] = problem.points().redundancy;
    count_[NOISE_STRIPE] = problem.stripes().redundancy;
    count_[NOISE_TRANSLATION] = int(prior_[NOISE_TRANSLATION].sum());
    count_[NOISE_ROTATION] = int(prior_[NOISE_ROTATION].sum());
    for (int k = 0; k < NOISE_COMPONENTS; ++k)
    {
        floor_[k] = floors[k] * floors[k];
        variance_[k] = start[k] * start[k];
        isFree_[k] = !isFixed[k] && isPresent(k);
        isAtFloor_[k] = false;
    }
    logVarianceCovariance_.setZero();
    solve();
    updateInformation();
}

VectorXd VarianceComponents::product(int component, const VectorXd& u) const
{
    if (component == NOISE_POINT)
        return problem_.points().JtJ * u;
    if (component == NOISE_STRIPE)
        return problem_.stripes().JtJ * u;
    return prior_[component].cwiseProduct(u);
}

//! Covariance and the sums of squares at the solution for the present variances.
void VarianceComponents::solve()
{
    MatrixXd H = problem_.points().JtJ / variance_[NOISE_POINT];
    VectorXd gradient = problem_.points().Jtr / variance_[NOISE_POINT];
    if (isPresent(NOISE_STRIPE))
    {
        H += problem_.stripes().JtJ / variance_[NOISE_STRIPE];
        gradient += problem_.stripes().Jtr / variance_[NOISE_STRIPE];
    }
    for (int k = NOISE_TRANSLATION; k <= NOISE_ROTATION; ++k)
        if (isPresent(k))
        {
            H.diagonal() += prior_[k] / variance_[k];
            gradient += prior_[k].cwiseProduct(corrections_) / variance_[k];
        }
    // Unknowns of such different units need Jacobi's scaling.
    const VectorXd scale = H.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
    MatrixXd scaled = scale.asDiagonal() * H * scale.asDiagonal();
    scaled.diagonal().array() += 1e-13; // what nothing observes gets a huge variance instead of none
    const Eigen::LLT<MatrixXd> llt(scaled);
    covariance_ = inverse(llt);
    inflation_ = covariance_.diagonal();
    logDeterminant_ = 2 * (MatrixXd(llt.matrixLLT()).diagonal().array() / scale.array()).log().sum();
    covariance_ = scale.asDiagonal() * covariance_ * scale.asDiagonal();

    step_ = -covariance_ * gradient;
    squaredStep_ = -gradient.dot(step_);
    const DataTerm* data[] = {&problem_.points(), &problem_.stripes()};
    for (int k = 0; k < 2; ++k)
        if (isPresent(k))
            quadratic_(k) =
                (data[k]->squares + 2 * data[k]->Jtr.dot(step_) + step_.dot(data[k]->JtJ * step_)) / variance_[k];
    for (int k = NOISE_TRANSLATION; k <= NOISE_ROTATION; ++k)
        if (isPresent(k))
            quadratic_(k) = prior_[k].dot((corrections_ + step_).cwiseAbs2()) / variance_[k];
    if (isPresent(NOISE_STRIPE))
        stripeProduct_ = covariance_ * problem_.stripes().JtJ / variance_[NOISE_STRIPE];
}

//! tr(T_k T_l) for two components other than the points, whose T is I minus the others.
double VarianceComponents::traceOfProduct(int k, int l) const
{
    if (!isPresent(k) || !isPresent(l))
        return 0;
    if (k == NOISE_STRIPE && l == NOISE_STRIPE)
        return stripeProduct_.cwiseProduct(stripeProduct_.transpose()).sum();
    if (k == NOISE_STRIPE || l == NOISE_STRIPE)
    {
        const int robot = std::max(k, l); // tr(T_s C M) = sum_i (T_s C)_ii M_ii
        return stripeProduct_.cwiseProduct(covariance_).rowwise().sum().dot(prior_[robot]) / variance_[robot];
    }
    return prior_[k].dot(covariance_.cwiseAbs2() * prior_[l]) / (variance_[k] * variance_[l]);
}

//! Expected information of the log variances: (delta_kl (n_k - 2 tr T_k) + tr(T_k T_l)) / 2.
void VarianceComponents::updateInformation()
{
    Matrix4d products = Matrix4d::Zero();
    trace_.setZero();
    for (int k = NOISE_STRIPE; k < NOISE_COMPONENTS; ++k)
    {
        if (!isPresent(k))
            continue;
        trace_(k) = k == NOISE_STRIPE ? stripeProduct_.trace() : covariance_.diagonal().dot(prior_[k]) / variance_[k];
        for (int l = NOISE_STRIPE; l < NOISE_COMPONENTS; ++l)
            products(k, l) = traceOfProduct(k, l);
    }
    trace_(NOISE_POINT) = double(covariance_.rows()) - trace_.tail<3>().sum();
    for (int k = NOISE_STRIPE; k < NOISE_COMPONENTS; ++k)
        products(0, k) = products(k, 0) = trace_(k) - products.row(k).tail<3>().sum();
    products(0, 0) = trace_(0) - products.row(0).tail<3>().sum();

    Matrix4d information = 0.5 * products;
    for (int k = 0; k < NOISE_COMPONENTS; ++k)
        information(k, k) += 0.5 * (count_[k] - 2 * trace_(k));
    for (int k = 0; k < NOISE_COMPONENTS; ++k)
        if (!isFree_[k] || isAtFloor_[k])
        {
            information.row(k).setZero();
            information.col(k).setZero();
            information(k, k) = 1;
        }
    logVarianceCovariance_ = inverseOfSymmetric(information);
    for (int k = 0; k < NOISE_COMPONENTS; ++k)
        if (!isFree_[k] || isAtFloor_[k])
            logVarianceCovariance_(k, k) = 0;
}

double VarianceComponents::estimate()
{
    const Vector4d start(variance_);
    const int maxIterations = 100;
    const bool isOpen = std::any_of(isFree_, isFree_ + NOISE_COMPONENTS, [](bool free) { return free; });
    for (int iteration = 0; iteration < maxIterations && isOpen; ++iteration)
    {
        Vector4d score = Vector4d::Zero();
        for (int k = 0; k < NOISE_COMPONENTS; ++k)
            if (isFree_[k] && !isAtFloor_[k])
                score(k) = -0.5 * (count_[k] - trace_(k) - quadratic_(k));
        Vector4d step = logVarianceCovariance_ * score;
        const double longest = step.cwiseAbs().maxCoeff(), limit = 1.5;
        if (longest > limit)
            step *= limit / longest;
        for (int k = 0; k < NOISE_COMPONENTS; ++k)
            if (isFree_[k] && !isAtFloor_[k])
            {
                variance_[k] = std::max(floor_[k], variance_[k] * std::exp(step(k)));
                isAtFloor_[k] = variance_[k] == floor_[k];
            }
        solve();
        updateInformation();
        if (longest < 1e-4)
            break;
    }
    double change = 0;
    for (int k = 0; k < NOISE_COMPONENTS; ++k)
        if (isFree_[k])
            change = std::max(change, std::abs(std::log(variance_[k] / start(k))) / 2);
    return change;
}

double VarianceComponents::deviance() const
{
    double sum = logDeterminant_;
    for (int k = 0; k < NOISE_COMPONENTS; ++k)
        if (isPresent(k))
            sum += count_[k] * std::log(variance_[k]) + quadratic_(k);
    return sum;
}

NoiseLevels VarianceComponents::levels() const
{
    return NoiseLevels{std::sqrt(variance_[0]), std::sqrt(variance_[1]), std::sqrt(variance_[2]),
                       std::sqrt(variance_[3])};
}

double VarianceComponents::degreesOfFreedom(const VectorXd& J) const
{
    const VectorXd v = covariance_ * J;
    const double variance = J.dot(v);
    Vector4d gradient = Vector4d::Zero();
    for (int k = 0; k < NOISE_COMPONENTS; ++k)
        if (isPresent(k))
            gradient(k) = v.dot(product(k, v)) / variance_[k];
    const double spread = gradient.dot(logVarianceCovariance_ * gradient);
    return spread > 0 ? 2 * variance * variance / spread : std::numeric_limits<double>::infinity();
}

}} // namespace cv::active_handeye
