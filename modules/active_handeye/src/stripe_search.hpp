// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_ACTIVE_HANDEYE_STRIPE_SEARCH_HPP
#define OPENCV_ACTIVE_HANDEYE_STRIPE_SEARCH_HPP

#include "stripe_frame.hpp"
#include "stripe_kernels.hpp"

namespace cv { namespace active_handeye {

//! Zero-mean box kernel matched to a Gaussian stripe: mean of rows -inner..inner minus mean of the other rows of -outer..outer.
struct BoxKernel
{
    int inner, outer;
    double gain;      //!< score of a Gaussian of height 1
    double noiseGain; //!< standard deviation of the score of white noise of variance 1

    explicit BoxKernel(double sigma);
};

struct StripePeak
{
    int row;      //!< -1: none
    float height; //!< grey levels above the surroundings, as of a Gaussian profile
};

/** The highest peak of every column and the next one apart from it.

First windows of a few rows are compared with the windows before and after, half a window apart; then the rows of the best window are
compared one by one by a box kernel.
*/
class StripeSearch
{
public:
    //! Second peaks count where they are higher than this fraction of the best.
    void run(const StripeFrame& frame, double sigma, double leastSecond);

    std::vector<StripePeak> best, second; //!< per column
    double heightNoise = 0;               //!< standard deviation of height where there is no stripe (texture included)
    double pixelNoise = 0;                //!< of one pixel of the signal, if that were white

private:
    //! Scratch memory.
    template <typename T>
    struct Rows
    {
        std::vector<T> partial, ring, peaks;
    };

    template <typename T>
    struct Scan
    {
        const StripeFrame& frame;
        const StripeRowKernels<T>& kernels;
        Rows<T>& rows;
    };

    template <typename T>
    static const T* meanRow(const Scan<T>& scan, int first, int size, T* out, int level);
    template <typename T>
    void findWindows(const StripeFrame& frame, const StripeRowKernels<T>& kernels, Rows<T>& rows, int apart);
    template <class Pixels>
    StripePeak sharpened(const Pixels& pixels, const StripeFrame& frame, const BoxKernel& kernel, int x,
                         const StripePeak& window) const;
    template <class Pixels>
    void sharpen(const Pixels& pixels, const StripeFrame& frame, const BoxKernel& kernel);
    template <class Pixels>
    void measureNoise(const Pixels& pixels, const StripeFrame& frame, const BoxKernel& kernel);
    template <class Pixels>
    void finish(const Pixels& pixels, const StripeFrame& frame, const BoxKernel& kernel);

    float comparable_ = 0;
    int half_ = 1, windowsOfStrip_ = 1; //!< rows of half a window
    Rows<uchar> bytes_;
    Rows<float> floats_;
    std::vector<float> samples_;
};

}} // namespace cv::active_handeye

#endif
