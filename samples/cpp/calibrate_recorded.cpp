// SPDX-FileCopyrightText: 2026 active_handeye contributors
// SPDX-License-Identifier: Apache-2.0

// Camera matrix, distortion and hand-eye transform with 95 % intervals, from poses and image points of a data set. The
// same as cv-active-handeye calibrate --no-laser on a data set with image_points.
//
// calibrate_recorded DATASET. doc/files.md describes the folder.
#include "recording.hpp"

#include <opencv2/active_handeye.hpp>

#include <cstdio>
#include <exception>

namespace {

using cv::active_handeye::RefineSummary;

//! All estimates in the order of RefineSummary::parameterNames; the rotation error vector and the missing plane are 0.
std::vector<double> inOrder(const cv::Mat& K, const cv::Mat& D, const cv::Mat& t)
{
    std::vector<double> values = {K.at<double>(0, 0), K.at<double>(1, 1), K.at<double>(0, 2), K.at<double>(1, 2),
                                  K.at<double>(0, 1)};
    values.insert(values.end(), D.begin<double>(), D.end<double>());
    values.insert(values.end(), 3, 0.0);
    values.insert(values.end(), t.begin<double>(), t.end<double>());
    return values;
}

void print(const cv::Mat& K, const cv::Mat& D, const cv::Mat& R, const cv::Mat& t, const RefineSummary& summary)
{
    std::puts("parameter,estimate,lower,upper  [px; rad; m]");
    const std::vector<double> values = inOrder(K, D, t);
    for (size_t i = 0; i < values.size(); ++i)
    {
        const double* ends = summary.intervals95.ptr<double>(int(i));
        std::printf("%s,%.9g,%.9g,%.9g\n", summary.parameterNames[i].c_str(), values[i], ends[0], ends[1]);
    }
    std::puts("R_cam2gripper");
    for (int i = 0; i < 3; ++i)
        std::printf("%.9f,%.9f,%.9f\n", R.at<double>(i, 0), R.at<double>(i, 1), R.at<double>(i, 2));
    std::puts(summary.message.c_str());
    for (const std::string& text : summary.culprits)
        std::printf("  %s\n", text.c_str());
    for (const std::string& text : summary.weakDirections)
        std::printf("  %s\n", text.c_str());
}

//! Returns the exit status: 5 for a result that must not be used.
int run(const std::string& folder)
{
    const recording::Recording seen(folder);
    cv::Mat K, D, R, t, plane;
    RefineSummary summary;
    cv::active_handeye::refineHandEye(seen.R_gripper2base, seen.t_gripper2base, seen.imagePoints, K, D, R, t, plane,
                                      summary);
    print(K, D, R, t, summary);
    return summary.usable ? 0 : 5;
}

} // namespace

int main(int argc, char** argv)
{
    if (argc != 2)
    {
        std::fprintf(stderr, "usage: %s DATASET\n", argv[0]);
        return 2;
    }
    try
    {
        return run(argv[1]);
    }
    catch (const std::exception& error)
    {
        std::fprintf(stderr, "error: %s\n", error.what());
        return 4;
    }
}
