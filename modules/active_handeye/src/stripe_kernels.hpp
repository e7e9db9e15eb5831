// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// The inner loops of detectStripe: plain loops that compilers vectorise, compiled once for every processor and once for AVX2.
#ifndef OPENCV_ACTIVE_HANDEYE_STRIPE_KERNELS_HPP
#define OPENCV_ACTIVE_HANDEYE_STRIPE_KERNELS_HPP

namespace cv { namespace active_handeye {

enum
{
    FIT_LANES = 64,    //!< columns fitted together
    FIT_MAX_TAPS = 512 //!< rows of the largest window
};

//! What the weights of a fit allow for.
enum PixelModel
{
    PIXELS_EQUAL,  //!< every pixel counts alike
    PIXELS_GRAINY, //!< grain of the light: noise in proportion to it
    PIXELS_ANY,    //!< that, and pixels that do not count, albedo and noise of a background
    PIXEL_MODELS
};

/** Columns whose stripe is fitted together; entry [i * FIT_LANES + lane] belongs to row i of the window of that lane.

Model: signal = albedo (height exp(-(y - centre)^2 / (2 sigma^2)) + offset), y and centre from the middle row of the window.
*/
struct StripeFit
{
    int taps;                  //!< rows of the windows, an odd number
    float inverseVariance;     //!< 1 / sigma^2
    float largestStep;         //!< of the centre in one iteration [px]
    float pixelNoise;          //!< grey levels
    float grain;               //!< (contrast of the grain of the light / pixelNoise)^2; not used by PIXELS_EQUAL
    float gauss[FIT_MAX_TAPS]; //!< exp(-y^2 / (2 sigma^2))
    float signal[FIT_MAX_TAPS * FIT_LANES];
    float weight[FIT_MAX_TAPS *
                 FIT_LANES]; //!< 0 where a pixel does not count; only used by PIXELS_ANY, as are the next two
    float albedo[FIT_MAX_TAPS * FIT_LANES];
    float background[FIT_LANES]; //!< mean level with the laser off, 0 = not known

    // The solution
    float centre[FIT_LANES], height[FIT_LANES], offset[FIT_LANES];
    float information[FIT_LANES]; //!< about the centre, for noise of variance 1
    float squares[FIT_LANES];     //!< weighted sum of the squared residuals
    float pixels[FIT_LANES];      //!< that count
    float move[FIT_LANES];        //!< last step of the centre, in units of the precision that is worth a step
    float failed[FIT_LANES];      //!< 1 where no peak fits
};

//! The highest window of every column and the next one apart from it. A window is known by its strip and its number in there.
template <typename T>
struct StripePeakRows
{
    T *best, *bestStrip, *bestWhich;
    T *second, *secondStrip, *secondWhich;
};

//! Rows of an image of `T`; numbers of strips and of windows in a strip must fit into it.
template <typename T>
struct StripeRowKernels
{
    //! out = (a + b) / 2
    void (*average)(int n, const T* a, const T* b, T* out);

    //! How far `centre` is above the mean of `before` and `after`; updates the highest of a strip and which it was.
    void (*score)(int n, T window, const T* centre, const T* before, const T* after, T* highest, T* which);

    //! Updates the peaks by the next strip of so many windows, and clears it; a second peak is more than `apart` windows away.
    void (*merge)(int n, T strip, T windows, T apart, T* highest, T* which, StripePeakRows<T> peaks);
};

struct StripeKernels
{
    StripeRowKernels<uchar> bytes;
    StripeRowKernels<float> floats;

    //! One iteration of all columns: height and offset for the present centre, and a step of the centre.
    void (*fit[PIXEL_MODELS])(StripeFit& fit);

    //! squares, at the solution.
    void (*assess[PIXEL_MODELS])(StripeFit& fit);
};

//! The fastest that this processor can run.
const StripeKernels& stripeKernels();

//! Those that every processor can run.
StripeKernels portableStripeKernels();

#ifdef ACTIVE_HANDEYE_AVX2
StripeKernels stripeKernelsAvx2();
#endif

}} // namespace cv::active_handeye

#endif
