// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// Noise levels as variance components: restricted maximum likelihood on the linearised problem.
#ifndef OPENCV_ACTIVE_HANDEYE_NOISE_LEVELS_HPP
#define OPENCV_ACTIVE_HANDEYE_NOISE_LEVELS_HPP

#include "refine_problem.hpp"

namespace cv { namespace active_handeye {

enum NoiseComponent
{
    NOISE_POINT,
    NOISE_STRIPE,
    NOISE_TRANSLATION,
    NOISE_ROTATION,
    NOISE_COMPONENTS
};

/** A Gaussian linear model whose precision is a sum over variance components.

H = sum_k M_k / v_k is the information of all unknowns, M_k and n_k (residuals minus eliminated unknowns) those of component k. Every derivative that REML
needs is a trace of products of T_k = H^-1 M_k / v_k (doc/method/refine.md).
*/
class VarianceComponents
{
public:
    //! Linearised at the present state of the problem (RefineProblem::linearizeData has been called).
    //! fixedLevels: those that are not estimated.
    VarianceComponents(const RefineProblem& problem, const bool (&isFixed)[NOISE_COMPONENTS],
                       const double (&floors)[NOISE_COMPONENTS]);

    //! Fisher scoring until the levels no longer change. Returns the largest relative change of a level.
    double estimate();

    NoiseLevels levels() const;

    //! Inverse of H: covariance of the reduced unknowns.
    const Eigen::MatrixXd& covariance() const { return covariance_; }

    //! Largest ratio, over the first unknowns, of their variance to what it would be were all others known.
    double varianceInflation(int unknowns) const { return inflation_.head(unknowns).maxCoeff(); }

    //! Where the reduced unknowns have their optimum, seen from the linearisation.
    const Eigen::VectorXd& step() const { return step_; }

    //! Squared length of this step in standard deviations: what it would take off the cost.
    double squaredStep() const { return squaredStep_; }

    //! -2 log restricted likelihood of the present levels, but for a constant of the linearisation.
    double deviance() const;

    //! Degrees of freedom of the variance of J u (Satterthwaite); infinite when no level was estimated.
    double degreesOfFreedom(const Eigen::VectorXd& J) const;

    //! Covariance of the logarithms of the variances; zero rows for levels that were not estimated.
    const Eigen::Matrix4d& logVarianceCovariance() const { return logVarianceCovariance_; }

    //! Of the residuals of one component, noise level 1; expected: level^2 x effectiveRedundancy.
    double sumOfSquares(int component) const { return quadratic_(component) * variance_[component]; }
    double effectiveRedundancy(int component) const { return count_[component] - trace_(component); }

    bool isPresent(int component) const { return count_[component] > 0; }
    bool isEstimated(int component) const { return isFree_[component]; }

private:
    void solve();
    double traceOfProduct(int k, int l) const;
    void updateInformation();
    Eigen::VectorXd product(int component, const Eigen::VectorXd& u) const;

    const RefineProblem& problem_;
    Eigen::VectorXd prior_[NOISE_COMPONENTS]; //!< diagonal of M_k of the robot's components
    Eigen::VectorXd step_, inflation_;
    Eigen::VectorXd corrections_; //!< of the poses at the linearisation, zero elsewhere
    double variance_[NOISE_COMPONENTS], floor_[NOISE_COMPONENTS];
    int count_[NOISE_COMPONENTS];
    bool isFree_[NOISE_COMPONENTS], isAtFloor_[NOISE_COMPONENTS];

    Eigen::MatrixXd covariance_, traces_;
    double logDeterminant_; //!< of H
    double squaredStep_;
    Eigen::MatrixXd stripeProduct_; //!< T of the stripes
    Eigen::Vector4d quadratic_, trace_;
    Eigen::Matrix4d logVarianceCovariance_;
};

}} // namespace cv::active_handeye

#endif
