// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_ACTIVE_HANDEYE_STRIPE_FRAME_HPP
#define OPENCV_ACTIVE_HANDEYE_STRIPE_FRAME_HPP

namespace cv { namespace active_handeye {

/** The images a stripe is searched in, turned so that there is one point per column.

8 or 16 bit, 1 or 3 channels; the signal is the mean of the channels, laser on minus laser off.
*/
class StripeFrame
{
public:
    /** Only the part `roi` of both, all when that is Rect(). saturation 0 = largest value of the type.

    Throws StsBadArg / StsBadSize when image or background cannot be used, StsOutOfRange for a roi outside of the image.
    */
    void set(const Mat& image, const Mat& background, const Rect& roi, bool vertical, double saturation);

    //! Forgets the caller's images.
    void release();

    int rows() const { return image_.rows; }
    int cols() const { return image_.cols; }
    double saturation() const { return saturation_; }
    bool hasBackground() const { return !background_.empty(); }

    //! One channel of 8 bits without background: row() is the signal.
    bool isPlain() const { return image_.type() == CV_8UC1 && background_.empty(); }
    const uchar* row(int y) const { return image_.ptr<uchar>(y); }
    size_t step() const { return image_.step; }

    //! Signal along row y.
    void signalRow(int y, float* out) const;

    float signal(int x, int y) const { return level(image_, x, y) - background(x, y); }
    float background(int x, int y) const { return background_.empty() ? 0 : level(background_, x, y); }
    bool isSaturated(int x, int y) const;

private:
    static float level(const Mat& source, int x, int y);

    Mat image_, background_;
    Mat turnedImage_, turnedBackground_; //!< their memory is used again
    double saturation_ = 0;
};

}} // namespace cv::active_handeye

#endif
