// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_ACTIVE_HANDEYE_STRIPE_SCATTER_HPP
#define OPENCV_ACTIVE_HANDEYE_STRIPE_SCATTER_HPP

#include "stripe_fitter.hpp"

namespace cv { namespace active_handeye {

/** Makes the standard deviations of a stripe's points agree with how neighbouring points scatter.

A profile tells its noise, but not how far texture and grain of the light move its peak. Third differences of the centres eight columns
apart do: bends of the stripe cancel, and texture and grain of two columns so far apart are independent. Their squares in units of what
the standard deviations say, without those across steps and with corners cut off, are averaged over 200 columns to each side around each point.
*/
class StripeScatter
{
public:
    //! Scales points[i].sigma; `points` are ordered by column.
    void apply(std::vector<StripePoint>& points);

private:
    void findPieces(const std::vector<StripePoint>& points);
    void collect(const std::vector<StripePoint>& points);
    double typicalSquare();

    std::vector<int> columns_; //!< in the middle of each difference
    std::vector<int> pieces_;  //!< per point
    std::vector<double> squares_, sample_;
};

}} // namespace cv::active_handeye

#endif
