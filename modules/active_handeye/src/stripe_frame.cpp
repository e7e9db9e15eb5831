// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "stripe_frame.hpp"

namespace cv { namespace active_handeye {

static std::string describe(const Mat& image)
{
    return cv::format("%d x %d pixels, %d channels, depth code %d", image.cols, image.rows, image.channels(),
                      image.depth());
}

static void requireImage(const Mat& image)
{
    if (image.empty())
        CV_Error(Error::StsBadArg, "image: is empty; needed an image of 8 or 16 bits with 1 or 3 channels");
    const bool known =
        (image.depth() == CV_8U || image.depth() == CV_16U) && (image.channels() == 1 || image.channels() == 3);
    if (image.dims != 2 || !known)
        CV_Error(Error::StsBadArg,
                 "image: needed 8 or 16 bits without sign (depth code 0 or 2) and 1 or 3 channels, given " +
                     describe(image));
}

static void requireSameFormat(const Mat& image, const Mat& background)
{
    if (background.size() != image.size())
        CV_Error(Error::StsBadSize,
                 "background: needed the size of image (" + describe(image) + "), given " + describe(background));
    if (background.type() != image.type())
        CV_Error(Error::StsBadArg,
                 "background: needed the type of image (" + describe(image) + "), given " + describe(background));
}

static Rect requireInside(const Rect& roi, const Size& size)
{
    const Rect whole(0, 0, size.width, size.height);
    if (roi == Rect())
        return whole;
    const bool isInside = roi.x >= 0 && roi.y >= 0 && roi.width > 0 && roi.height > 0 &&
                          roi.width <= size.width - roi.x && roi.height <= size.height - roi.y;
    if (!isInside)
        CV_Error(Error::StsOutOfRange,
                 cv::format("params.roi: needed a part of the image (%d x %d pixels), given x %d, y %d, %d x %d pixels",
                            size.width, size.height, roi.x, roi.y, roi.width, roi.height));
    return roi;
}

void StripeFrame::set(const Mat& image, const Mat& background, const Rect& roi, bool vertical, double saturation)
{
    requireImage(image);
    if (!background.empty())
        requireSameFormat(image, background);
    const Rect part = requireInside(roi, image.size());
    saturation_ = saturation > 0 ? saturation : image.depth() == CV_8U ? 255 : 65535;
    image_ = image(part);
    background_ = background.empty() ? Mat() : background(part);
    if (!vertical)
        return;
    cv::transpose(image_, turnedImage_);
    image_ = turnedImage_;
    if (background_.empty())
        return;
    cv::transpose(background_, turnedBackground_);
    background_ = turnedBackground_;
}

void StripeFrame::release()
{
    image_.release();
    background_.release();
}

template <typename T>
static void addChannels(const T* pixels, int channels, int cols, float factor, float* out)
{
    if (channels == 1)
        for (int x = 0; x < cols; ++x)
            out[x] += factor * float(pixels[x]);
    else
        for (int x = 0; x < cols; ++x)
            out[x] += factor * float(int(pixels[3 * x]) + int(pixels[3 * x + 1]) + int(pixels[3 * x + 2]));
}

static void addRow(const Mat& source, int y, float sign, float* out)
{
    const float factor = sign / float(source.channels());
    if (source.depth() == CV_8U)
        addChannels(source.ptr<uchar>(y), source.channels(), source.cols, factor, out);
    else
        addChannels(source.ptr<ushort>(y), source.channels(), source.cols, factor, out);
}

void StripeFrame::signalRow(int y, float* out) const
{
    std::fill(out, out + cols(), 0.f);
    addRow(image_, y, 1.f, out);
    if (!background_.empty())
        addRow(background_, y, -1.f, out);
}

static int channelValue(const Mat& source, int x, int y, int channel)
{
    const int i = x * source.channels() + channel;
    return source.depth() == CV_8U ? int(source.ptr<uchar>(y)[i]) : int(source.ptr<ushort>(y)[i]);
}

float StripeFrame::level(const Mat& source, int x, int y)
{
    int sum = 0;
    for (int c = 0; c < source.channels(); ++c)
        sum += channelValue(source, x, y, c);
    return float(sum) / float(source.channels());
}

bool StripeFrame::isSaturated(int x, int y) const
{
    for (int c = 0; c < image_.channels(); ++c)
        if (channelValue(image_, x, y, c) >= saturation_)
            return true;
    return false;
}

}} // namespace cv::active_handeye
