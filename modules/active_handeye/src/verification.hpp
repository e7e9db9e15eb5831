// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_ACTIVE_HANDEYE_VERIFICATION_HPP
#define OPENCV_ACTIVE_HANDEYE_VERIFICATION_HPP

#include "refine_problem.hpp"

namespace cv { namespace active_handeye {

//! Error of a view predicted from the others, and what noise and calibration let expect; RMS lengths, image and scene.
struct ViewPrediction
{
    double pixels, expectedPixels, length, expectedLength;
};

const double verificationHuberThreshold = 2.5; //!< sigmas

//! The steps of verifyHandEye().
class Verification
{
public:
    //! covariance: of the POINT_COLUMNS; columns of variance 0 or infinity are not tested.
    Verification(const AlignedVector<Pose>& gripper2base, const SceneTracks& tracks,
                 const HandEyeCalibration& calibration, const Eigen::MatrixXd& covariance, const NoiseLevels& noise);

    //! Scene points and poses for the calibration as it is; leaves wrong matches out.
    void findScene();

    //! Score test of the calibration.
    void testDrift();

    //! Predicts a view from the others. NaN where that is impossible.
    ViewPrediction predict(int view) const;

    double driftChiSquare = 0, fitChiSquare = 0,
           noiseFactor = 1; //!< noiseFactor: of the variances, where the residuals ask for more
    int driftDof = 0, fitDof = 0, used = 0, rejected = 0;
    Eigen::VectorXd shift, shiftDeviation; //!< POINT_COLUMNS

private:
    void settle(RefineProblem& problem) const;
    void leaveOut(double limit);
    bool isMostlyRejected(int view) const;
    void estimateShift(const Eigen::MatrixXd& byScore, const Eigen::MatrixXd& ofCalibration, const Eigen::VectorXd& z,
                       const Eigen::VectorXd& tested, double factor);
    Eigen::MatrixXd testedColumns() const;
    Eigen::MatrixXd testedCorrelation() const;
    Eigen::MatrixXd covarianceOf(RefineProblem& problem) const;

    const AlignedVector<Pose>& gripper2base_;
    SceneTracks tracks_;
    StripeSegments noSegments_;
    const Eigen::MatrixXd covariance_;
    RefineProblem problem_;
};

}} // namespace cv::active_handeye

#endif
