// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// Noise levels of the poses as variance components: restricted maximum likelihood on the linearised views.
#ifndef OPENCV_ACTIVE_HANDEYE_HAND_EYE_VARIANCES_HPP
#define OPENCV_ACTIVE_HANDEYE_HAND_EYE_VARIANCES_HPP

#include "hand_eye_problem.hpp"

namespace cv { namespace active_handeye {

typedef Eigen::Matrix<double, HAND_EYE_NOISES, HAND_EYE_NOISES> NoiseMatrix;

class HandEyeVariances
{
public:
    //! isFree: the noises whose variances are estimated, from the start given and not below their floors.
    HandEyeVariances(const HandEyeResiduals& residuals, const NoiseVariances& start, const NoiseVariances& floors,
                     const bool (&isFree)[HAND_EYE_NOISES]);

    //! Fisher scoring; where that does not raise the penalised likelihood, a step that always does. Returns the largest relative change of a level.
    double estimate();

    const NoiseVariances& variances() const { return variances_; }

    //! Of the 12 unknowns.
    const Matrix12d& covariance() const { return covariance_; }

    //! From the linearisation to the optimum.
    Vector12d step() const { return -covariance_ * gradient_; }

    //! Squared length of this step in standard deviations.
    double squaredStep() const { return gradient_.dot(covariance_ * gradient_); }

    double chiSquare() const { return chiSquare_; }

    //! Degrees of freedom of the variance of one unknown (Satterthwaite); infinite when no level was estimated.
    double degreesOfFreedom(int unknown) const;

    //! 95 % interval of a level; from 0 where the level cannot be told from it.
    Eigen::Vector2d interval(int noise) const;

private:
    void solve(AlignedVector<Matrix6d>& W, AlignedVector<Matrix6x12d>& WJ);
    void evaluate();
    bool isActive(int noise) const;
    NoiseVariances score() const;
    double objective() const;
    NoiseMatrix inverseOfActive(NoiseMatrix information) const;
    NoiseVariances scoringStep() const;
    NoiseVariances ascentStep() const;

    //! Covariance of the logarithms of the variances; zero rows for levels that were not estimated.
    NoiseMatrix logVarianceCovariance() const;
    void move(const NoiseVariances& logStep);

    const HandEyeResiduals* residuals_;
    NoiseVariances variances_, floors_;
    bool isFree_[HAND_EYE_NOISES];

    Matrix12d covariance_;
    Vector12d gradient_;
    double deviance_, chiSquare_;      //!< deviance: -2 log restricted likelihood but for a constant
    NoiseVariances quadratic_, trace_; //!< of the score of every variance
    NoiseMatrix information_;          //!< expected, of the logarithms of the variances
};

}} // namespace cv::active_handeye

#endif
