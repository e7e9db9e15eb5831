// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "least_squares.hpp"

namespace cv { namespace active_handeye {

LeastSquaresSummary solveLeastSquares(LeastSquaresProblem& problem, int maxIterations, double tolerance)
{
    LeastSquaresSummary summary;
    summary.converged = false;
    Eigen::VectorXd Jtr;
    summary.cost = problem.linearize(summary.JtJ, Jtr);
    double damping = 1e-6;
    const double maxDamping = 1e12;
    const double rounding = 1e-12; // of the cost; a decrease below it cannot be seen
    for (summary.iterations = 0; summary.iterations < maxIterations && !summary.converged; ++summary.iterations)
    {
        // Marquardt's scaling; the added constant keeps parameters that nothing observes where they are.
        Eigen::MatrixXd damped = summary.JtJ;
        damped.diagonal() +=
            damping * (summary.JtJ.diagonal().array() + 1e-12 * summary.JtJ.diagonal().maxCoeff() + 1e-300).matrix();
        const Eigen::LLT<Eigen::MatrixXd> llt(damped);
        if (llt.info() != Eigen::Success)
        {
            summary.converged = damping > maxDamping;
            damping *= 10;
            continue;
        }
        const Eigen::VectorXd step = -llt.solve(Jtr);
        const double cost = problem.costAfter(step);
        const double predictedDecrease = -step.dot(Jtr);
        const double negligible = std::max(tolerance * summary.cost, problem.negligibleDecrease());
        if (!(cost < summary.cost))
        {
            const bool isHidden = damping < 1 && predictedDecrease <= rounding * summary.cost;
            summary.converged = predictedDecrease <= negligible || isHidden || damping > maxDamping;
            damping *= 10;
            continue;
        }
        summary.converged = summary.cost - cost <= negligible;
        problem.apply(step);
        summary.cost = problem.linearize(summary.JtJ, Jtr);
        damping = std::max(damping * 0.1, 1e-12);
    }
    return summary;
}

}} // namespace cv::active_handeye
