// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "input.hpp"
#include "stripe_fitter.hpp"
#include "stripe_scatter.hpp"
#include "stripe_search.hpp"

namespace cv { namespace active_handeye {

StripeParams::StripeParams()
    : orientation(STRIPE_HORIZONTAL), sigma(1.5), minSnr(4.5), minContrast(0.02), maxSecondPeak(0.6), saturation(0),
      minRun(5)
{}

static void requireRange(double value, double low, double high, const char* name)
{
    if (!(value >= low && value <= high)) // also refuses NaN
        CV_Error(Error::StsOutOfRange,
                 cv::format("params.%s: needed a value from %g to %g, given %g", name, low, high, value));
}

static void checkParams(const StripeParams& params)
{
    if (params.orientation != STRIPE_HORIZONTAL && params.orientation != STRIPE_VERTICAL)
        CV_Error(Error::StsBadArg,
                 cv::format("params.orientation: needed STRIPE_HORIZONTAL (0) or STRIPE_VERTICAL (1), given %d",
                            params.orientation));
    requireRange(params.sigma, 0.5, 20, "sigma");
    requireRange(params.minSnr, 1, 1000, "minSnr");
    requireRange(params.minContrast, 0, 1, "minContrast");
    requireRange(params.maxSecondPeak, 0, 1, "maxSecondPeak");
    requireRange(params.saturation, 0, 65535, "saturation");
    requireRange(params.minRun, 1, 1e6, "minRun");
}

namespace {

//! From an image to the centre line. Keeps its memory from frame to frame.
class StripeDetector
{
public:
    const std::vector<StripePoint>& run(const Mat& image, const Mat& background, const StripeParams& params)
    {
        frame_.set(image, background, params.roi, params.orientation == STRIPE_VERTICAL, params.saturation);
        search_.run(frame_, params.sigma, params.maxSecondPeak);
        fitter_.begin(frame_, search_.pixelNoise, params.sigma);
        points_.clear();
        findClearColumns(params);
        const double width =
            fitter_.measureWidth(starts_); // wider than sigma where the stripe is oblique or out of focus
        fitter_.measureGrain(starts_, width);
        fitter_.fit(starts_, width, points_);
        resolveDoublePeaks(params, width);
        const double least = params.minContrast * frame_.saturation();
        keepIf([least](const StripePoint& point) { return point.height >= least; });
        removeMisfits();
        removeShortRuns(params.minRun);
        scatter_.apply(points_);
        frame_.release();
        return points_;
    }

private:
    //! Starts at the columns with one clear peak; those with two are kept for later.
    void findClearColumns(const StripeParams& params)
    {
        const double significant = params.minSnr * search_.heightNoise;
        const double least = std::max(significant, params.minContrast * frame_.saturation());
        starts_.clear();
        doublePeaks_.clear();
        for (int x = 0; x < frame_.cols(); ++x)
        {
            const StripePeak &best = search_.best[x], &second = search_.second[x];
            if (best.row < 0 || !(best.height >= least))
                continue;
            if (second.height <= std::max(significant, params.maxSecondPeak * best.height))
                starts_.push_back(StripeStart{x, best.row});
            else
                doublePeaks_.push_back(x);
        }
    }

    /** Of two peaks the one on the line between the points at both sides, if the other one is not. */
    void resolveDoublePeaks(const StripeParams& params, double width)
    {
        const int longestGap = 200, tolerance = BoxKernel(params.sigma).outer;
        const size_t clear = points_.size();
        size_t right = 0;
        starts_.clear();
        for (int x : doublePeaks_)
        {
            while (right < clear && points_[right].column < x)
                ++right;
            if (right == 0 || right == clear || points_[right].column - points_[right - 1].column > longestGap)
                continue;
            const StripePoint &a = points_[right - 1], &b = points_[right];
            const double line = a.centre + (b.centre - a.centre) * (x - a.column) / double(b.column - a.column);
            const int rows[] = {search_.best[x].row, search_.second[x].row};
            const bool isNear[] = {std::abs(rows[0] - line) <= tolerance, std::abs(rows[1] - line) <= tolerance};
            if (isNear[0] != isNear[1])
                starts_.push_back(StripeStart{x, isNear[0] ? rows[0] : rows[1]});
        }
        resolved_.clear();
        fitter_.fit(starts_, width, resolved_);
        merged_.resize(points_.size() + resolved_.size());
        std::merge(points_.begin(), points_.end(), resolved_.begin(), resolved_.end(), merged_.begin(),
                   [](const StripePoint& a, const StripePoint& b) { return a.column < b.column; });
        points_.swap(merged_);
    }

    template <class Predicate>
    void keepIf(const Predicate& isKept)
    {
        points_.erase(std::remove_if(points_.begin(), points_.end(),
                                     [&](const StripePoint& point) { return !isKept(point); }),
                      points_.end());
    }

    //! Two stripes in one, as at a step, fit worse than the others; how well those fit depends on speckle and texture.
    void removeMisfits()
    {
        if (points_.empty())
            return;
        ratios_.clear();
        for (const StripePoint& point : points_)
            ratios_.push_back(point.misfit / (point.height * point.height));
        const double limit = 9 * medianOf(ratios_), noise = 6.25 * search_.pixelNoise * search_.pixelNoise;
        keepIf([=](const StripePoint& point)
               { return point.misfit <= std::max(noise, limit * point.height * point.height); });
    }

    static bool areNeighbours(const StripePoint& a, const StripePoint& b)
    {
        const int columns = b.column - a.column;
        return columns <= 3 && std::abs(b.centre - a.centre) <= columns + 3 * (a.sigma + b.sigma);
    }

    void removeShortRuns(int minRun)
    {
        size_t kept = 0;
        for (size_t begin = 0, end = 0; begin < points_.size(); begin = end)
        {
            end = begin + 1;
            while (end < points_.size() && areNeighbours(points_[end - 1], points_[end]))
                ++end;
            if (end - begin < size_t(minRun))
                continue;
            std::copy(points_.begin() + begin, points_.begin() + end, points_.begin() + kept);
            kept += end - begin;
        }
        points_.resize(kept);
    }

    StripeFrame frame_;
    StripeSearch search_;
    StripeFitter fitter_;
    StripeScatter scatter_;
    std::vector<StripeStart> starts_;
    std::vector<int> doublePeaks_;
    std::vector<StripePoint> points_, resolved_, merged_;
    std::vector<double> ratios_;
};

} // namespace

//! n rows; a Mat that had as many before keeps its memory.
static double* rowsOf(OutputArray out, int n, int cols)
{
    const int vectorType = CV_MAKETYPE(CV_64F, cols);
    if (out.kind() == _InputArray::STD_VECTOR && out.type() == vectorType)
        out.create(n, 1, vectorType);
    else if (out.kind() == _InputArray::MAT && out.dims() == 2 && out.cols() == cols && out.type() == CV_64F &&
             !out.isSubmatrix())
        out.getMatRef().resize(size_t(n));
    else
        out.create(n, cols, CV_64F);
    return n > 0 ? out.getMat().ptr<double>() : nullptr;
}

void detectStripe(InputArray image, OutputArray stripePoints, OutputArray sigmas, InputArray background,
                  const StripeParams& params)
{
    CV_TRACE_FUNCTION();
    checkParams(params);
    static thread_local StripeDetector detector;
    const std::vector<StripePoint>& points = detector.run(image.getMat(), background.getMat(), params);
    const int n = int(points.size()), along = params.orientation == STRIPE_VERTICAL ? 1 : 0;
    const int first[] = {params.roi.x, params.roi.y};
    double *positions = rowsOf(stripePoints, n, 2), *deviations = rowsOf(sigmas, n, 1);
    for (int i = 0; i < n; ++i)
    {
        positions[2 * i + along] = first[along] + points[i].column;
        positions[2 * i + 1 - along] = first[1 - along] + points[i].centre;
        deviations[i] = points[i].sigma;
    }
}

}} // namespace cv::active_handeye
