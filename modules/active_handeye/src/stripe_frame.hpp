// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_ACTIVE_HANDEYE_STRIPE_FRAME_HPP
#define OPENCV_ACTIVE_HANDEYE_STRIPE_FRAME_HPP

namespace cv { namespace active_handeye {

//! Pixels of one column around a stripe, all in grey levels of one channel.
struct StripeWindow
{
    int top = 0;                //!< row of the first pixel
    std::vector<double> signal; //!< image minus background
    std::vector<double> albedo; //!< background relative to its mean in the window; 1 without background
    double background = 0;      //!< that mean; 0 when albedo is not used
    std::vector<char> valid;    //!< 0 where a channel is saturated

    int size() const { return int(signal.size()); }
};

/** The images a stripe is searched in, turned so that there is one point per column.

8 or 16 bit, 1 or 3 channels; the signal is the mean of the channels, laser on minus laser off.
*/
class StripeFrame
{
public:
    //! Throws StsBadArg / StsBadSize when image or background cannot be used. saturation 0 = largest value of the type.
    StripeFrame(const Mat& image, const Mat& background, bool vertical, double saturation);

    int rows() const { return image_.rows; }
    int cols() const { return image_.cols; }
    double saturation() const { return saturation_; }

    //! Sum over the channels of image minus background along row y; channels() times the signal.
    void signalRow(int y, float* out) const;
    int channels() const { return image_.channels(); }

    bool isSaturated(int x, int y) const;

    //! Rows [top, bottom] of column x. `noise` of a pixel of the signal: texture below it is not divided by.
    void window(int x, int top, int bottom, double noise, StripeWindow& out) const;

private:
    double pixel(const Mat& source, int x, int y) const;

    Mat image_, background_;
    double saturation_;
};

}} // namespace cv::active_handeye

#endif
