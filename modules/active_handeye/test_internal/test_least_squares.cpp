// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.
#include "../src/precomp.hpp"
#include "../src/least_squares.hpp"

#include <gtest/gtest.h>

namespace cv { namespace active_handeye { namespace {

//! One unknown whose gradient promises a decrease that the cost never shows.
class EmptyPromise : public LeastSquaresProblem
{
public:
    EmptyPromise(double cost, double decrease) : cost_(cost), gradient_(std::sqrt(decrease)) {}

    double linearize(Eigen::MatrixXd& JtJ, Eigen::VectorXd& Jtr) CV_OVERRIDE
    {
        JtJ = Eigen::MatrixXd::Ones(1, 1);
        Jtr = Eigen::VectorXd::Constant(1, gradient_);
        return cost_;
    }
    double costAfter(const Eigen::VectorXd&) const CV_OVERRIDE { return cost_; }
    void apply(const Eigen::VectorXd&) CV_OVERRIDE { FAIL() << "a step that decreases nothing"; }

private:
    double cost_, gradient_;
};

TEST(ActiveHandEye_LeastSquares, a_decrease_that_rounding_hides_is_the_end)
{
    EmptyPromise problem(1000, 0.5e-12 * 1000);
    const LeastSquaresSummary summary = solveLeastSquares(problem, 50, 1e-14);
    EXPECT_TRUE(summary.converged);
    EXPECT_EQ(1, summary.iterations);
}

TEST(ActiveHandEye_LeastSquares, a_decrease_that_should_be_seen_and_is_not_is_no_end)
{
    EmptyPromise problem(1000, 1e-6);
    const LeastSquaresSummary summary = solveLeastSquares(problem, 10, 1e-14);
    EXPECT_FALSE(summary.converged);
    EXPECT_EQ(10, summary.iterations);
}

}}} // namespace cv::active_handeye
