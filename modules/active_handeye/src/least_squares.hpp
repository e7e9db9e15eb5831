// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_ACTIVE_HANDEYE_LEAST_SQUARES_HPP
#define OPENCV_ACTIVE_HANDEYE_LEAST_SQUARES_HPP

namespace cv { namespace active_handeye {

/** A sum of squares over a manifold, as the solver sees it.

The problem owns its state; a step is a vector in the tangent space at the present state.
*/
class LeastSquaresProblem
{
public:
    virtual ~LeastSquaresProblem() {}

    //! Normal equations at the present state: JtJ = J^T J, Jtr = J^T r. Returns r^T r.
    virtual double linearize(Eigen::MatrixXd& JtJ, Eigen::VectorXd& Jtr) = 0;

    //! r^T r after the step, the state unchanged; infinity where the step leaves the domain.
    virtual double costAfter(const Eigen::VectorXd& step) const = 0;

    //! Moves the state by the step.
    virtual void apply(const Eigen::VectorXd& step) = 0;

    //! A decrease of r^T r not worth a step, whatever r^T r is: where the data are exact, it is rounding alone.
    virtual double negligibleDecrease() const { return 0; }
};

struct LeastSquaresSummary
{
    bool converged; //!< false: the iterations ran out
    int iterations;
    double cost;         //!< r^T r at the solution
    Eigen::MatrixXd JtJ; //!< at the solution; its inverse times the variance of r is the covariance
};

//! Levenberg-Marquardt; stops when a step lowers the cost by no more than `tolerance` of it or by what is negligible.
LeastSquaresSummary solveLeastSquares(LeastSquaresProblem& problem, int maxIterations = 50, double tolerance = 1e-14);

}} // namespace cv::active_handeye

#endif
