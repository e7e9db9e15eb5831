// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_ACTIVE_HANDEYE_NUMBERS_HPP
#define OPENCV_ACTIVE_HANDEYE_NUMBERS_HPP

namespace cv { namespace active_handeye {

//! The numbers of one array, row by row, whatever its depth, layout and continuity.
struct Numbers
{
    std::vector<double> values;
    std::string shape;
    int rowLength; //!< numbers in one row: channels, or the last dimension
};

Numbers numbersOf(const Mat& m);

//! A list of arrays, or one array split along its first dimension (a vector of points along its only one).
std::vector<Numbers> readList(const _InputArray& a);

//! The upper one of the two in the middle of an even number.
double median(std::vector<double> values);

}} // namespace cv::active_handeye

#endif
