// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// What detectStripe allocates on a second frame: every operator new of this program and every buffer of a Mat is counted.
#include "../src/precomp.hpp"
#include "opencv2/active_handeye/stripe.hpp"

#include <cstdlib>
#include <gtest/gtest.h>
#include <new>

static size_t allocations = 0;

static void* counted(size_t size)
{
    ++allocations;
    if (void* memory = std::malloc(size > 0 ? size : 1))
        return memory;
    throw std::bad_alloc();
}

void* operator new(size_t size)
{
    return counted(size);
}

void* operator new[](size_t size)
{
    return counted(size);
}

void operator delete(void* memory) noexcept
{
    std::free(memory);
}

void operator delete[](void* memory) noexcept
{
    std::free(memory);
}

// C++11 does not declare these, but GTest may be compiled for a standard that calls them.
void operator delete(void* memory, size_t) noexcept;
void operator delete[](void* memory, size_t) noexcept;

void operator delete(void* memory, size_t) noexcept
{
    std::free(memory);
}

void operator delete[](void* memory, size_t) noexcept
{
    std::free(memory);
}

namespace opencv_test { namespace {

using namespace cv;
using namespace cv::active_handeye;

//! Counts, and leaves the work to OpenCV's allocator.
class CountingAllocator : public MatAllocator
{
public:
    CountingAllocator() { Mat::setDefaultAllocator(this); }
    ~CountingAllocator() { Mat::setDefaultAllocator(Mat::getStdAllocator()); }

    UMatData* allocate(int dims, const int* sizes, int type, void* data, size_t* step, AccessFlag flags,
                       UMatUsageFlags usage) const CV_OVERRIDE
    {
        ++allocations;
        return Mat::getStdAllocator()->allocate(dims, sizes, type, data, step, flags, usage);
    }
    bool allocate(UMatData* data, AccessFlag flags, UMatUsageFlags usage) const CV_OVERRIDE
    {
        return Mat::getStdAllocator()->allocate(data, flags, usage);
    }
    void deallocate(UMatData* data) const CV_OVERRIDE { Mat::getStdAllocator()->deallocate(data); }
};

//! A noisy stripe that ends at `length`, with a reflection beside it in some columns.
Mat frame(int length, int type, uint64 seed)
{
    RNG rng(seed);
    Mat grey(200, 320, CV_64F), image;
    for (int y = 0; y < grey.rows; ++y)
        for (int x = 0; x < grey.cols; ++x)
        {
            const double d = y - 80 - 0.05 * x, apart = y - 140;
            const double light = x < length ? std::exp(-d * d / 4.5) : 0;
            const double reflection = x > 50 && x < 60 ? 0.8 * std::exp(-apart * apart / 4.5) : 0;
            grey.at<double>(y, x) = 20 + 150 * (light + reflection) + rng.gaussian(3);
        }
    grey.convertTo(image, CV_MAT_DEPTH(type));
    if (CV_MAT_CN(type) == 3)
        cv::merge(std::vector<Mat>(3, image), image);
    return image;
}

//! Frames of every length after a first one of full length, into the same outputs.
template <typename Points, typename Sigmas>
size_t allocationsAfterTheFirst(int type, bool hasBackground, const StripeParams& params)
{
    std::vector<Mat> frames;
    for (int length : {320, 200, 0, 320, 90})
        frames.push_back(frame(length, type, uint64(length + 1)));
    const Mat background = hasBackground ? Mat(frames[0].size(), type, Scalar::all(20)) : Mat();
    Points points;
    Sigmas sigmas;
    detectStripe(frames[0], points, sigmas, background, params);
    const CountingAllocator counter;
    const size_t before = allocations;
    for (const Mat& image : frames)
        detectStripe(image, points, sigmas, background, params);
    return allocations - before;
}

TEST(ActiveHandEye_detectStripe, further_frames_allocate_nothing)
{
    for (int orientation : {STRIPE_HORIZONTAL, STRIPE_VERTICAL})
        for (int type : {CV_8UC1, CV_16UC3})
            for (bool hasBackground : {false, true})
            {
                SCOPED_TRACE(cv::format("orientation=%d type=%d background=%d", orientation, type, int(hasBackground)));
                StripeParams params;
                params.orientation = orientation;
                EXPECT_EQ(0u, (allocationsAfterTheFirst<Mat, Mat>(type, hasBackground, params)));
                EXPECT_EQ(0u, (allocationsAfterTheFirst<std::vector<Point2d>, std::vector<double>>(type, hasBackground,
                                                                                                   params)));
            }
}

TEST(ActiveHandEye_detectStripe, the_allocations_of_a_first_frame_are_seen)
{
    const Mat image = frame(320, CV_8UC1, 1);
    const CountingAllocator counter;
    const size_t before = allocations;
    Mat points;
    std::vector<double> sigmas;
    detectStripe(image, points, sigmas);
    EXPECT_GE(allocations - before, 2u);
    EXPECT_EQ(size_t(points.rows), sigmas.size());
}

}} // namespace opencv_test
