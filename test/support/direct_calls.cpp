// SPDX-FileCopyrightText: 2026 active_handeye contributors
// SPDX-License-Identifier: Apache-2.0

// The C++ functions without Python between: arrays come on stdin and go to stdout as raw numbers, so that the tests of the bindings can
// compare bit for bit. Usage: direct_calls FUNCTION <request >answer. Both are: number of arguments; for each the number of its arrays;
// for each of these rows, columns, and the doubles row by row. Counts are 32-bit integers.

#include <cstdint>
#include <iostream>
#include <iterator>
#include <string>
#include <vector>
#include "opencv2/active_handeye.hpp"

using cv::Mat;
using namespace cv::active_handeye;

namespace {

typedef std::vector<Mat> Mats;

int32_t readCount()
{
    int32_t count = 0;
    std::cin.read(reinterpret_cast<char*>(&count), sizeof count);
    return count;
}

std::vector<Mats> readArguments()
{
    std::vector<Mats> arguments(static_cast<size_t>(readCount()));
    for (Mats& argument : arguments)
    {
        argument.resize(static_cast<size_t>(readCount()));
        for (Mat& mat : argument)
        {
            const int32_t rows = readCount(), cols = readCount();
            mat = Mat(rows, cols, CV_64F);
            std::cin.read(reinterpret_cast<char*>(mat.data),
                          static_cast<std::streamsize>(mat.total() * sizeof(double)));
        }
    }
    return arguments;
}

void writeCount(int count)
{
    const int32_t value = count;
    std::cout.write(reinterpret_cast<const char*>(&value), sizeof value);
}

void writeAnswer(const Mats& outputs)
{
    writeCount(int(outputs.size()));
    for (const Mat& output : outputs)
    {
        Mat doubles;
        output.convertTo(doubles, CV_64F);
        writeCount(1);
        writeCount(doubles.rows);
        writeCount(doubles.cols);
        std::cout.write(reinterpret_cast<const char*>(doubles.data),
                        static_cast<std::streamsize>(doubles.total() * sizeof(double)));
    }
}

Mat number(double value)
{
    return Mat(1, 1, CV_64F, cv::Scalar(value)).clone();
}

Mats call(const std::string& function, const std::vector<Mats>& a)
{
    Mat u, v, w;
    if (function == "estimateFOE")
    {
        const int inliers = estimateFOE(a[0][0], a[1][0], u, v, w);
        return {number(inliers), u, v, w};
    }
    if (function == "groupViews")
        return groupViews(a[0], u), Mats{u};
    if (function == "calibrateHandEyeTranslations")
    {
        const double rms = calibrateHandEyeTranslations(a[0], a[1], a[2], u, a[3][0], v, w);
        return {number(rms), u, v, w};
    }
    if (function == "calibrateHandEyeRotation")
    {
        const double rms = calibrateHandEyeRotation(a[0], a[1], a[2], a[3][0], a[4][0], a[5][0], u, v);
        return {number(rms), u, v};
    }
    if (function == "calibrateLightPlane")
    {
        const double rms = calibrateLightPlane(a[0], a[1], a[2], a[3][0], a[4][0], a[5][0], a[6][0], a[7][0], u, v);
        return {number(rms), u, v};
    }
    if (function == "detectStripe")
    {
        Mat image;
        a[0][0].convertTo(image, CV_8U);
        return detectStripe(image, u, v), Mats{u, v};
    }
    if (function == "splitStripe")
        return splitStripe(a[0][0], a[1][0], a[2][0], a[3][0], u), Mats{u};
    if (function == "associateStripes")
        return associateStripes(a[0], a[1], a[2], a[3][0], a[4], a[5][0], a[6][0], a[7][0], a[8][0], u, v), Mats{u, v};
    CV_Error(cv::Error::StsBadArg, "no such function: " + function);
}

} // namespace

int main(int argc, char** argv)
{
    writeAnswer(call(argc > 1 ? argv[1] : "", readArguments()));
    return 0;
}
