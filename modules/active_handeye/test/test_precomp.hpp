// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.
#ifndef OPENCV_TEST_ACTIVE_HANDEYE_PRECOMP_HPP
#define OPENCV_TEST_ACTIVE_HANDEYE_PRECOMP_HPP

// One set of test sources for two builds: inside OpenCV with its module ts, on its own with GTest alone. Use GTest's names as of
// the version that ts carries (SetUpTestCase, INSTANTIATE_TEST_CASE_P; no GTEST_SKIP).
#ifdef ACTIVE_HANDEYE_STANDALONE
#include <gtest/gtest.h>
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>
#include "opencv2/core.hpp"
#undef INSTANTIATE_TEST_CASE_P // deprecated here
#define INSTANTIATE_TEST_CASE_P INSTANTIATE_TEST_SUITE_P
#else
#include "opencv2/ts.hpp"
#endif
#include <limits>

#include "opencv2/active_handeye.hpp"

namespace opencv_test {
using namespace cv;
using namespace cv::active_handeye;
using std::string;
using std::vector;

const double infinity = std::numeric_limits<double>::infinity();
} // namespace opencv_test

#endif
