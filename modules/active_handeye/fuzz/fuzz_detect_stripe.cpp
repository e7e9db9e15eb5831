// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// detectStripe with any image and any parameters: either an error of its own, or a centre line that keeps its promises.
#include "opencv2/active_handeye/stripe.hpp"

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size);

namespace {

using namespace cv;
using namespace cv::active_handeye;

//! The input, read from front to back; zeros after its end.
class Bytes
{
public:
    Bytes(const uint8_t* data, size_t size) : data_(data), size_(size) {}
    int next() { return at_ < size_ ? data_[at_++] : 0; }
    double upTo(double most) { return most * next() / 255; }

private:
    const uint8_t* data_;
    size_t size_, at_ = 0;
};

StripeParams readParams(Bytes& bytes, const Size& size)
{
    StripeParams params;
    const int kind = bytes.next();
    params.orientation = kind & 1;
    params.sigma = 0.4 + bytes.upTo(21);
    params.minSnr = 0.9 + bytes.upTo(10);
    params.minContrast = bytes.upTo(0.5);
    params.maxSecondPeak = bytes.upTo(1.1);
    params.saturation = kind & 2 ? 0 : 256. * bytes.next();
    params.minRun = bytes.next() % 12;
    if (kind & 4)
        params.roi =
            Rect(bytes.next() % (size.width + 1), bytes.next() % (size.height + 1), bytes.next() - 1, bytes.next() - 1);
    return params;
}

//! Bytes of the input, or a stripe of some height and width with holes and plateaus where they say so.
Mat readImage(Bytes& bytes, const Size& size, int type)
{
    Mat image(size, type);
    const bool isStripe = bytes.next() & 1;
    const double height = bytes.upTo(500), width = 0.3 + bytes.upTo(12), slope = bytes.upTo(4) - 2;
    const size_t values = image.total() * size_t(image.channels());
    for (size_t i = 0; i < values; ++i)
    {
        const int x = int(i) / image.channels() % size.width, y = int(i) / image.channels() / size.width;
        const double apart = (y - 0.5 * size.height - slope * (x - 0.5 * size.width)) / width;
        const double light = isStripe ? height * std::exp(-0.5 * apart * apart) : 0;
        const double grey = light + (isStripe ? 0.1 : 1.0) * bytes.next();
        if (image.depth() == CV_8U)
            image.ptr<uchar>()[i] = saturate_cast<uchar>(grey);
        else
            image.ptr<ushort>()[i] = saturate_cast<ushort>(200 * grey);
    }
    return image;
}

void require(bool holds, const char* what)
{
    if (holds)
        return;
    std::fprintf(stderr, "detectStripe: %s\n", what);
    std::abort();
}

void checkResult(const Mat& points, const Mat& sigmas, const StripeParams& params, const Size& size)
{
    const Rect area = params.roi == Rect() ? Rect(Point(), size) : params.roi;
    const int along = params.orientation == STRIPE_VERTICAL ? 1 : 0;
    require(points.rows == sigmas.rows, "as many sigmas as points are needed");
    require(points.empty() || (points.cols == 2 && points.type() == CV_64F && sigmas.type() == CV_64F),
            "points need two coordinates");
    for (int i = 0; i < points.rows; ++i)
    {
        const double *point = points.ptr<double>(i), sigma = sigmas.at<double>(i);
        require(std::isfinite(sigma) && sigma > 0, "sigmas need to be positive and finite");
        require(point[0] >= area.x - 0.5 && point[0] <= area.br().x - 0.5 && point[1] >= area.y - 0.5 &&
                    point[1] <= area.br().y - 0.5,
                "points need to be inside the roi");
        require(point[along] == std::floor(point[along]), "one coordinate is that of a column");
        require(i == 0 || point[along] > points.at<double>(i - 1, along), "points need to be in order");
    }
}

} // namespace

int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size)
{
    Bytes bytes(data, size);
    const Size area(1 + bytes.next() % 80, 1 + bytes.next() % 160);
    const int kind = bytes.next(), type = CV_MAKETYPE(kind & 1 ? CV_16U : CV_8U, kind & 2 ? 3 : 1);
    const StripeParams params = readParams(bytes, area);
    const Mat image = readImage(bytes, area, type), background = kind & 4 ? readImage(bytes, area, type) : Mat();
    Mat points, sigmas;
    try
    {
        detectStripe(image, points, sigmas, background, params);
    }
    catch (const cv::Exception& error)
    {
        require(error.code == Error::StsOutOfRange || error.code == Error::StsBadArg,
                "errors need a code of their own");
        return 0;
    }
    checkResult(points, sigmas, params, area);
    return 0;
}
