// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_ACTIVE_HANDEYE_STRIPE_FITTER_HPP
#define OPENCV_ACTIVE_HANDEYE_STRIPE_FITTER_HPP

#include "stripe_frame.hpp"
#include "stripe_kernels.hpp"
#include "stripe_residuals.hpp"

#include <memory>

namespace cv { namespace active_handeye {

//! Where a stripe is supposed in a column.
struct StripeStart
{
    int column, row;
};

struct StripePoint
{
    int column;
    double centre, sigma;  //!< row, and its standard deviation
    double height, misfit; //!< grey levels, and mean square of the residuals
};

/** Least-squares fit of a Gaussian profile, many columns at a time.

signal(y) = albedo(y) (height exp(-(y - centre)^2 / (2 sigma^2)) + offset) with one sigma for all; albedo from the background, 1 without.
Pixels with a saturated channel do not count. The others count by their noise: that of the image, and grain of the laser light
(speckle, texture where there is no background) in proportion to the light.
*/
class StripeFitter
{
public:
    //! expectedSigma limits how long a saturated plateau may be.
    void begin(const StripeFrame& frame, double pixelNoise, double expectedSigma);
    void end() { frame_ = nullptr; }

    //! Median of the widths of the profiles around a sample of the starts; expectedSigma where too few say.
    double measureWidth(const std::vector<StripeStart>& starts);

    //! Grain of the light from the residuals around the same sample; until then there is none.
    void measureGrain(const std::vector<StripeStart>& starts, double sigma);

    //! Appends the columns in which one peak explains the signal.
    void fit(const std::vector<StripeStart>& starts, double sigma, std::vector<StripePoint>& points);

private:
    struct Rows
    {
        int top, bottom;
    };

    void load(const StripeStart* starts, int count, int margin);
    int loadSample(const std::vector<StripeStart>& starts, double sigma);
    PixelModel model() const;
    bool loadPlain(const StripeStart* starts, int count, int margin);
    void loadWeighted(const StripeStart* starts, int count, int margin);
    bool growOverPlateau(int x, Rows& rows) const;
    void loadColumn(int lane, int x, const Rows& rows, int first);
    void normaliseAlbedo(int lane, int first, int last);
    void solve(double sigma); //!< from the solution before, as far as the same columns are loaded
    double medianWidth(int lanes, double smallest, double ratio, int count);
    void append(const StripeStart* starts, int count, double sigma, std::vector<StripePoint>& points) const;

    const StripeFrame* frame_ = nullptr;
    double pixelNoise_ = 1, expectedSigma_ = 1;
    bool isPlain_ = false; //!< the loaded windows have neither weights nor background
    double grain_ = 0;
    float isLoaded_[FIT_LANES]; //!< 0: the column has no window
    int middle_[FIT_LANES];     //!< row of the middle of the window
    std::vector<double> widths_, squares_;
    StripeResiduals residuals_;
    std::unique_ptr<StripeFit> fit_;
};

}} // namespace cv::active_handeye

#endif
