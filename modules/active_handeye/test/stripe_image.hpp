// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.
#ifndef OPENCV_TEST_ACTIVE_HANDEYE_STRIPE_IMAGE_HPP
#define OPENCV_TEST_ACTIVE_HANDEYE_STRIPE_IMAGE_HPP

#include "point_scene.hpp"
#include <functional>

namespace opencv_test {

//! A Gaussian stripe with known centres: one per column, y = centre(x).
struct StripeImage
{
    int rows, cols, type;
    double sigma, height, noise, offset;
    std::function<double(int)> centre;
    std::function<double(int, int)> albedo; // (x, y), 1 = white
    double grain;                           //!< relative contrast of the light, 1.7 px wide at half height

    StripeImage()
        : rows(240), cols(640), type(CV_8U), sigma(1.5), height(120), noise(0), offset(20),
          centre([](int x) { return 60 + 0.02 * x + 3 * std::sin(0.01 * x); }), albedo([](int, int) { return 1.; }),
          grain(0)
    {}

    Mat render(bool laser, uint64 seed = 1) const
    {
        RNG rng(seed);
        const Mat light = grainImage(seed);
        Mat grey(rows, cols, CV_64F);
        for (int y = 0; y < rows; ++y)
            for (int x = 0; x < cols; ++x)
            {
                const double d = (y - centre(x)) / sigma;
                const double shine = laser ? height * std::exp(-0.5 * d * d) * light.at<double>(y, x) : 0.;
                grey.at<double>(y, x) = albedo(x, y) * (offset + shine) + rng.gaussian(noise);
            }
        Mat image;
        grey.convertTo(image, type);
        return image;
    }

    //! 1 + grain of correlation exp(-d^2 / (4 0.7^2)), by a Gaussian of 0.7 px.
    Mat grainImage(uint64 seed) const
    {
        Mat one(rows, cols, CV_64F, Scalar(1));
        if (grain == 0)
            return one;
        const int reach = 3;
        double taps[2 * reach + 1], power = 0;
        for (int i = -reach; i <= reach; ++i)
            power += std::pow(taps[i + reach] = std::exp(-0.5 * i * i / (0.7 * 0.7)), 2);
        RNG rng(seed + 1000);
        Mat white(rows, cols, CV_64F), smooth = white.clone();
        rng.fill(white, RNG::NORMAL, 0, grain / power);
        for (const bool across : {true, false})
        {
            smooth = Scalar(0);
            for (int y = reach; y < rows - reach; ++y)
                for (int x = reach; x < cols - reach; ++x)
                    for (int i = -reach; i <= reach; ++i)
                        smooth.at<double>(y, x) +=
                            taps[i + reach] * white.at<double>(across ? y + i : y, across ? x : x + i);
            cv::swap(white, smooth);
        }
        return one + white;
    }

    //! Smallest standard deviation an unbiased estimate of the centre can have.
    double bound() const { return noise / height * std::sqrt(2 * sigma / std::sqrt(CV_PI)); }
};

struct Accuracy
{
    size_t count;
    double bias, rmse, normalisedRmse;
};

inline Accuracy accuracy(const Mat& points, const Mat& sigmas, const std::function<double(int)>& centre)
{
    Accuracy a = {points.total() / 2, 0, 0, 0};
    for (int i = 0; i < points.rows; ++i)
    {
        const double error = points.at<double>(i, 1) - centre(cvRound(points.at<double>(i, 0)));
        a.bias += error / points.rows;
        a.rmse += error * error / points.rows;
        a.normalisedRmse += std::pow(error / sigmas.at<double>(i, 0), 2) / points.rows;
    }
    a.rmse = std::sqrt(a.rmse);
    a.normalisedRmse = std::sqrt(a.normalisedRmse);
    return a;
}

} // namespace opencv_test

#endif
