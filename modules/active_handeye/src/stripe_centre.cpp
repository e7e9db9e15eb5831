// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "stripe_centre.hpp"

namespace cv { namespace active_handeye {

namespace {

enum
{
    HEIGHT,
    OFFSET,
    CENTRE,
    SIGMA
};

struct Normal
{
    Eigen::Matrix4d A = Eigen::Matrix4d::Zero();
    Eigen::Vector4d b = Eigen::Vector4d::Zero();
    double squares = 0;
    int pixels = 0;
};

//! The background is noisy too, and multiplied by the laser light: image - background (1 + light / background).
double pixelWeight(const StripeWindow& window, double light)
{
    if (window.background == 0)
        return 1;
    const double gain = 1 + std::max(0., light) / window.background;
    return 2 / (1 + gain * gain);
}

Normal normalEquations(const StripeWindow& window, const StripeProfile& p)
{
    Normal normal;
    for (int i = 0; i < window.size(); ++i)
    {
        if (!window.valid[i])
            continue;
        const double d = (window.top + i - p.centre) / p.sigma;
        const double albedo = window.albedo[i], g = std::exp(-0.5 * d * d), slope = p.height * g * d / p.sigma;
        const Eigen::Vector4d J = albedo * Eigen::Vector4d(g, 1, slope, slope * d);
        const double residual = window.signal[i] - albedo * (p.height * g + p.offset),
                     weight = pixelWeight(window, p.height * g);
        normal.A.noalias() += weight * J * J.transpose();
        normal.b.noalias() += weight * residual * J;
        normal.squares += weight * residual * residual;
        ++normal.pixels;
    }
    return normal;
}

//! Height and offset are linear: their best values for the present centre and sigma.
bool fitLinearPart(const StripeWindow& window, StripeProfile& p)
{
    p.height = p.offset = 0;
    const Normal normal = normalEquations(window, p);
    const Eigen::Matrix2d A = normal.A.topLeftCorner<2, 2>();
    if (normal.pixels < 4 || A.determinant() <= 1e-9 * A(0, 0) * A(1, 1))
        return false;
    const Eigen::Vector2d x = A.inverse() * normal.b.head<2>();
    p.height = x(0);
    p.offset = x(1);
    return p.height > 0;
}

typedef Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 4, 4> Small; // no allocation
typedef Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 4, 1> SmallVector;

//! Standard deviation and misfit at the solution; false when the centre is not observed or the residuals are not those of one peak.
bool assess(const Normal& normal, const Eigen::LDLT<Small>& ldlt, double pixelNoise, StripeProfile& profile)
{
    // noise: the residuals here, held by the noise of the image because they are few
    const double priorFreedom = 4;
    const int unknowns = int(ldlt.rows()), freedom = normal.pixels - unknowns;
    const double variance =
        (normal.squares + priorFreedom * pixelNoise * pixelNoise) / (std::max(0, freedom) + priorFreedom);
    const SmallVector column = ldlt.solve(SmallVector::Unit(unknowns, CENTRE));
    profile.centreSigma = std::sqrt(variance * column(CENTRE));
    profile.misfit = std::sqrt(normal.squares / std::max(1, freedom));
    const bool isObserved = profile.centreSigma > 0 && profile.centreSigma < profile.sigma; // also false for NaN
    return isObserved && freedom > 0 && profile.misfit <= std::max(4 * pixelNoise, 0.2 * profile.height);
}

} // namespace

bool fitStripeProfile(const StripeWindow& window, double pixelNoise, bool fitSigma, StripeProfile& profile)
{
    const double start = profile.centre, smallest = 0.5 * profile.sigma, largest = 2 * profile.sigma;
    const int unknowns = fitSigma ? 4 : 3, maxIterations = 30;
    if (!fitLinearPart(window, profile))
        return false;
    for (int iteration = 0; iteration < maxIterations; ++iteration)
    {
        const Normal normal = normalEquations(window, profile);
        const Eigen::LDLT<Small> ldlt(normal.A.topLeftCorner(unknowns, unknowns));
        const SmallVector step = ldlt.solve(normal.b.head(unknowns));
        const double move = std::max(-profile.sigma, std::min(profile.sigma, step(CENTRE)));
        if (!std::isfinite(move))
            return false;
        profile.centre += move;
        if (fitSigma)
            profile.sigma = std::max(smallest, std::min(largest, profile.sigma + step(SIGMA)));
        const bool centreInside = profile.centre > window.top && profile.centre < window.top + window.size() - 1;
        if (!centreInside || !fitLinearPart(window, profile))
            return false;
        const double sigmaMove = fitSigma ? std::abs(step(SIGMA)) : 0;
        if (std::abs(move) > 1e-7 || (sigmaMove > 1e-4 && profile.sigma > smallest && profile.sigma < largest))
            continue;
        return assess(normal, ldlt, pixelNoise, profile) && std::abs(profile.centre - start) <= 0.5 * window.size();
    }
    return false;
}

}} // namespace cv::active_handeye
