// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_ACTIVE_HANDEYE_STRIPE_PEAKS_HPP
#define OPENCV_ACTIVE_HANDEYE_STRIPE_PEAKS_HPP

#include "stripe_frame.hpp"

namespace cv { namespace active_handeye {

//! The highest peak of every column and the height of the next one apart from it.
struct StripePeaks
{
    std::vector<int> row;      //!< 0 where the column has none
    std::vector<float> height; //!< grey levels above the surroundings, as of a Gaussian profile
    std::vector<float> second;
    double heightNoise; //!< standard deviation of height where there is no stripe (texture included)
    double pixelNoise;  //!< of one pixel of the signal, if that were white
};

/** One pass over the image: mean of the inner rows minus mean of the outer rows around each pixel (box sums that run
down the columns), its two highest separated maxima per column, and its robust spread.
*/
StripePeaks findStripePeaks(const StripeFrame& frame, double sigma);

}} // namespace cv::active_handeye

#endif
