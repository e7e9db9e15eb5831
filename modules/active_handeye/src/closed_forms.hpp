// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// The closed forms as steps of a longer calculation, which decides itself what to make of views that contradict the others.
#ifndef OPENCV_ACTIVE_HANDEYE_CLOSED_FORMS_HPP
#define OPENCV_ACTIVE_HANDEYE_CLOSED_FORMS_HPP

namespace cv { namespace active_handeye {

struct ViewDoubts
{
    double threshold;               //!< px: larger residuals make a view suspect; in: see largeImageNoise
    std::vector<int> rejectedViews; //!< out: views that were not used
};

const double largeImageNoise = 0.5; //!< px

//! calibrateHandEyeTranslations() without its log.
double translationsClosedForm(InputArrayOfArrays R_gripper2base, InputArrayOfArrays t_gripper2base,
                              InputArrayOfArrays imagePoints, InputOutputArray cameraMatrix, InputArray distCoeffs,
                              OutputArray R_cam2gripper, OutputArray covariance, TranslationsMethod method, int flags,
                              double orientationTolerance, ViewDoubts& doubts);

//! calibrateHandEyeRotation() without its log.
double rotationClosedForm(InputArrayOfArrays R_gripper2base, InputArrayOfArrays t_gripper2base,
                          InputArrayOfArrays imagePoints, InputArray cameraMatrix, InputArray distCoeffs,
                          InputArray R_cam2gripper, OutputArray t_cam2gripper, OutputArray covariance, int flags,
                          ViewDoubts& doubts);

//! Names the views that were not used on OpenCV's log.
void warnOfRejectedViews(const char* function, const ViewDoubts& doubts);

}} // namespace cv::active_handeye

#endif
