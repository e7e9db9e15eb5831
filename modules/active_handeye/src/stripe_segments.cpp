// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "input.hpp"
#include "decompositions.hpp"

namespace cv { namespace active_handeye {

using Eigen::Matrix2d;
using Eigen::Vector2d;

namespace {

//! Sums over a part of the stripe in constant time, for its best line.
class PrefixSums
{
public:
    PrefixSums(const Pixels& points, const std::vector<double>& weights)
        : weight_(1, 0.), first_(1, Vector2d(0, 0)), second_(1, Matrix2d::Zero())
    {
        const Vector2d origin = points.empty() ? Vector2d(0, 0) : points[points.size() / 2]; // keeps the sums small
        for (size_t i = 0; i < points.size(); ++i)
        {
            const Vector2d u = points[i] - origin;
            weight_.push_back(weight_.back() + weights[i]);
            first_.push_back(first_.back() + weights[i] * u);
            second_.push_back(second_.back() + weights[i] * u * u.transpose());
        }
        origin_ = origin;
    }

    Matrix2d scatter(size_t begin, size_t end) const
    {
        const Vector2d sum = first_[end] - first_[begin];
        return second_[end] - second_[begin] - sum * sum.transpose() / (weight_[end] - weight_[begin]);
    }

    Vector2d mean(size_t begin, size_t end) const
    {
        return origin_ + (first_[end] - first_[begin]) / (weight_[end] - weight_[begin]);
    }

    //! Weighted sum of squared distances to the best line: smaller eigenvalue of the scatter.
    double squares(size_t begin, size_t end) const
    {
        const Matrix2d S = scatter(begin, end);
        const double half = 0.5 * (S(0, 0) - S(1, 1));
        return 0.5 * (S(0, 0) + S(1, 1)) - std::sqrt(half * half + S(0, 1) * S(0, 1));
    }

private:
    std::vector<double> weight_;
    AlignedVector<Vector2d> first_;
    AlignedVector<Matrix2d> second_;
    Vector2d origin_;
};

double median(std::vector<double>& values)
{
    std::nth_element(values.begin(), values.begin() + values.size() / 2, values.end());
    return values[values.size() / 2];
}

struct Part
{
    size_t begin, end;
    size_t size() const { return end - begin; }
};

//! One stripe in ideal pixels, without outliers.
class StripeSplitter
{
public:
    StripeSplitter(const Pixels& points, const std::vector<double>& weights, double breakDistance, double maxGap,
                   int minPoints)
        : points_(points), sums_(points, weights), breakDistance_(breakDistance), maxGap_(maxGap),
          minPoints_(size_t(minPoints))
    {}

    std::vector<Part> run()
    {
        for (size_t begin = 0, end = 0; begin < points_.size(); begin = end)
        {
            end = begin + 1;
            while (end < points_.size() && (points_[end] - points_[end - 1]).norm() <= maxGap_)
                ++end;
            std::vector<Part> parts;
            split(Part{begin, end}, parts);
            mergeNeighbours(parts);
            for (const Part& part : parts)
                keepInner(part);
        }
        return segments_;
    }

    double distance(const Part& part, size_t i) const
    {
        const Matrix2d S = sums_.scatter(part.begin, part.end);
        const Vector2d normal = symmetricEigen(S).eigenvectors().col(0);
        return normal.dot(points_[i] - sums_.mean(part.begin, part.end));
    }

private:
    //! No five neighbours depart from the line by half the break distance.
    bool isStraight(const Part& part) const
    {
        const Matrix2d S = sums_.scatter(part.begin, part.end);
        const Vector2d normal = symmetricEigen(S).eigenvectors().col(0);
        const Vector2d mean = sums_.mean(part.begin, part.end);
        const size_t window = std::min<size_t>(5, part.size());
        std::vector<double> values(window);
        for (size_t i = part.begin; i + window <= part.end; ++i)
        {
            for (size_t k = 0; k < window; ++k)
                values[k] = normal.dot(points_[i + k] - mean);
            if (std::abs(median(values)) > 0.5 * breakDistance_)
                return false;
        }
        return true;
    }

    void split(const Part& part, std::vector<Part>& parts) const
    {
        if (part.size() < minPoints_)
            return;
        if (isStraight(part))
        {
            parts.push_back(part);
            return;
        }
        const size_t shortest = 3;
        size_t cut = part.begin + part.size() / 2;
        double best = std::numeric_limits<double>::infinity();
        for (size_t k = part.begin + shortest; k + shortest <= part.end; ++k)
        {
            const double cost = sums_.squares(part.begin, k) + sums_.squares(k, part.end);
            if (cost < best)
                best = cost, cut = k;
        }
        split(Part{part.begin, cut}, parts);
        split(Part{cut, part.end}, parts);
    }

    //! A first cut at the wrong place can leave two parts of one line.
    void mergeNeighbours(std::vector<Part>& parts) const
    {
        for (size_t i = 1; i < parts.size();)
        {
            const Part both = {parts[i - 1].begin, parts[i].end};
            if (parts[i].begin - parts[i - 1].end <= 3 && isStraight(both))
            {
                parts[i - 1] = both;
                parts.erase(parts.begin() + i);
            }
            else
                ++i;
        }
    }

    //! The stripe is cut off or shared by two planes at its ends: their last points are biased.
    void keepInner(const Part& part)
    {
        const size_t trimmed = 2;
        if (part.size() >= minPoints_ + 2 * trimmed)
            segments_.push_back(Part{part.begin + trimmed, part.end - trimmed});
    }

    const Pixels& points_;
    const PrefixSums sums_;
    const double breakDistance_, maxGap_;
    const size_t minPoints_;
    std::vector<Part> segments_;
};

//! Points that agree with the middle between two neighbours, for one of three pairs at least.
std::vector<size_t> withoutOutliers(const Pixels& points, const std::vector<double>& sigmas, double breakDistance)
{
    std::vector<size_t> kept;
    const size_t reach = 3;
    for (size_t i = 0; i < points.size(); ++i)
    {
        double departure = std::numeric_limits<double>::infinity();
        for (size_t k = 1; k <= reach && k <= i && i + k < points.size(); ++k)
            departure = std::min(departure, (points[i] - 0.5 * (points[i - k] + points[i + k])).norm());
        const bool hasNeighbours = i >= reach && i + reach < points.size();
        if (!hasNeighbours || departure <= std::max(2 * breakDistance, 5 * sigmas[i]))
            kept.push_back(i);
    }
    return kept;
}

} // namespace

void splitStripe(InputArray stripePoints, InputArray sigmas, InputArray cameraMatrix, InputArray distCoeffs,
                 OutputArray segmentIds, double breakDistance, double maxGap, int minPoints)
{
    CV_TRACE_FUNCTION();
    const Pixels pixels = readPixels(stripePoints, "stripePoints");
    const std::vector<double> deviations = sigmas.empty() ? std::vector<double>(pixels.size(), 0.) // they weigh alike
                                                          : readSigmas(sigmas, "sigmas", pixels.size());
    const Camera camera = readCamera(cameraMatrix, distCoeffs);
    readPositive(breakDistance, "breakDistance");
    readPositive(maxGap, "maxGap");
    if (minPoints < 5)
        CV_Error(Error::StsOutOfRange, cv::format("minPoints: needed at least 5, given %d", minPoints));

    Pixels ideal;
    for (const Vector2d& pixel : pixels)
        ideal.push_back(camera.idealPixel(pixel));
    const std::vector<size_t> kept = withoutOutliers(ideal, deviations, breakDistance);
    Pixels points;
    std::vector<double> weights;
    for (size_t i : kept)
    {
        points.push_back(ideal[i]);
        weights.push_back(deviations[i] > 0 ? 1 / (deviations[i] * deviations[i]) : 1);
    }
    StripeSplitter splitter(points, weights, breakDistance, maxGap, minPoints);
    const std::vector<Part> segments = splitter.run();

    segmentIds.create(int(pixels.size()), 1, CV_32S);
    Mat ids = segmentIds.getMat();
    ids.setTo(Scalar::all(-1));
    for (size_t s = 0; s < segments.size(); ++s)
        for (size_t i = segments[s].begin; i < segments[s].end; ++i)
            if (std::abs(splitter.distance(segments[s], i)) <= std::max(breakDistance, 5 * deviations[kept[i]]))
                ids.ptr<int>()[kept[i]] = int(s);
}

}} // namespace cv::active_handeye
