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

StripeFrame::StripeFrame(const Mat& image, const Mat& background, bool vertical, double saturation)
    : saturation_(saturation > 0           ? saturation
                  : image.depth() == CV_8U ? 255
                                           : 65535)
{
    requireImage(image);
    if (!background.empty())
        requireSameFormat(image, background);
    image_ = image;
    background_ = background;
    if (!vertical)
        return;
    cv::transpose(image, image_);
    if (!background.empty())
        cv::transpose(background, background_);
}

template <typename T>
static void sumChannels(const T* pixels, int channels, int cols, float sign, float* out)
{
    if (channels == 1)
        for (int x = 0; x < cols; ++x)
            out[x] += sign * float(pixels[x]);
    else
        for (int x = 0; x < cols; ++x)
            out[x] += sign * float(int(pixels[3 * x]) + int(pixels[3 * x + 1]) + int(pixels[3 * x + 2]));
}

static void addRow(const Mat& source, int y, float sign, float* out)
{
    if (source.depth() == CV_8U)
        sumChannels(source.ptr<uchar>(y), source.channels(), source.cols, sign, out);
    else
        sumChannels(source.ptr<ushort>(y), source.channels(), source.cols, sign, out);
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

double StripeFrame::pixel(const Mat& source, int x, int y) const
{
    double sum = 0;
    for (int c = 0; c < source.channels(); ++c)
        sum += channelValue(source, x, y, c);
    return sum / source.channels();
}

bool StripeFrame::isSaturated(int x, int y) const
{
    for (int c = 0; c < channels(); ++c)
        if (channelValue(image_, x, y, c) >= saturation_)
            return true;
    return false;
}

//! Background -> albedo relative to its mean, with as much contrast as stands out of the noise.
static double normaliseAlbedo(std::vector<double>& albedo, double noise)
{
    double mean = 0, variance = 0;
    for (double value : albedo)
        mean += value / double(albedo.size());
    for (double value : albedo)
        variance += (value - mean) * (value - mean) / double(albedo.size());
    const double contrast =
        mean > 3 * noise ? std::max(0., 1 - 1.5 * noise * noise / std::max(variance, noise * noise)) : 0;
    const double darkest = 0.05;
    for (double& value : albedo)
        value = contrast > 0 ? std::max(darkest, 1 + contrast * (value / mean - 1)) : 1;
    return contrast > 0 ? mean : 0;
}

void StripeFrame::window(int x, int top, int bottom, double noise, StripeWindow& out) const
{
    const int size = bottom - top + 1;
    out.top = top;
    out.signal.resize(size);
    out.valid.resize(size);
    out.albedo.assign(size, 1.);
    out.background = 0;
    for (int i = 0; i < size; ++i)
    {
        out.signal[i] = pixel(image_, x, top + i);
        out.valid[i] = !isSaturated(x, top + i);
        if (background_.empty())
            continue;
        out.albedo[i] = pixel(background_, x, top + i);
        out.signal[i] -= out.albedo[i];
    }
    if (!background_.empty())
        out.background = normaliseAlbedo(out.albedo, noise / std::sqrt(2.));
}

}} // namespace cv::active_handeye
