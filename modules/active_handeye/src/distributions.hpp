// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// Tails of the distributions that tests and intervals need.
#ifndef OPENCV_ACTIVE_HANDEYE_DISTRIBUTIONS_HPP
#define OPENCV_ACTIVE_HANDEYE_DISTRIBUTIONS_HPP

namespace cv { namespace active_handeye {

//! P(chi-square with `dof` degrees of freedom > x).
double chiSquareTail(double x, double dof);

//! P(F(dof1, dof2) > x); dof2 may be infinite.
double fTail(double x, double dof1, double dof2);

//! t with P(|Student's t with `dof`| > t) = p; dof may be infinite.
double studentQuantile(double p, double dof);

}} // namespace cv::active_handeye

#endif
