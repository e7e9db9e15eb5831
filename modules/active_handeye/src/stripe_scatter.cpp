// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "stripe_scatter.hpp"

namespace cv { namespace active_handeye {

static const int apart = 8;               // columns
static const double cutoff = 16;          // square of four standard deviations
static const int reach = 200, block = 32; // columns to each side; that share a scale
static const double prior = 30;           // differences' worth of trust in the wider average

static double squared(double value)
{
    return value * value;
}

//! Numbers the smooth pieces of the stripe: a new one begins where a step between neighbours is far beyond the typical one.
void StripeScatter::findPieces(const std::vector<StripePoint>& points)
{
    const double farBeyond = 8;
    pieces_.assign(points.size(), 0);
    if (points.size() < 2)
        return;
    const auto columnsAt = [&](size_t i) { return points[i].column - points[i - 1].column; };
    const auto stepAt = [&](size_t i) { return points[i].centre - points[i - 1].centre; };
    const size_t stride = 1 + points.size() / 256;
    sample_.clear();
    for (size_t i = 1; i < points.size(); i += stride)
        sample_.push_back(stepAt(i) / columnsAt(i));
    const double slope = medianOf(sample_);
    for (double& value : sample_)
        value = std::abs(value - slope);
    const double limit = farBeyond * medianOf(sample_);
    for (size_t i = 1; i < points.size(); ++i)
    {
        const int columns = columnsAt(i);
        pieces_[i] = pieces_[i - 1] + int(std::abs(stepAt(i) - slope * columns) > limit * columns);
    }
}

//! Squared third differences over their variance. Columns that lack a partner on their piece have none.
void StripeScatter::collect(const std::vector<StripePoint>& points)
{
    findPieces(points);
    columns_.clear();
    squares_.clear();
    size_t at[4] = {0, 0, 0, 0};
    for (; at[0] < points.size(); ++at[0])
    {
        bool isComplete = true;
        for (int k = 1; k < 4; ++k)
        {
            const int column = points[at[0]].column + k * apart;
            while (at[k] < points.size() && points[at[k]].column < column)
                ++at[k];
            isComplete = isComplete && at[k] < points.size() && points[at[k]].column == column;
        }
        if (!isComplete || pieces_[at[0]] != pieces_[at[3]])
            continue;
        const StripePoint &a = points[at[0]], &b = points[at[1]], &c = points[at[2]], &d = points[at[3]];
        const double variance = squared(a.sigma) + 9 * squared(b.sigma) + 9 * squared(c.sigma) + squared(d.sigma);
        columns_.push_back((b.column + c.column) / 2);
        squares_.push_back(squared(a.centre - 3 * b.centre + 3 * c.centre - d.centre) / variance);
    }
}

//! Mean of the squares without those far beyond it; few squares hardly move it from 1.
double StripeScatter::typicalSquare()
{
    if (squares_.empty())
        return 1;
    const double quartile = 0.1015; // of squares of normal variables; steps spoil the upper ones
    sample_.clear();
    for (size_t i = 0; i < squares_.size(); i += 1 + squares_.size() / 256)
        sample_.push_back(squares_[i]);
    const auto lower = sample_.begin() + int(sample_.size() / 4);
    std::nth_element(sample_.begin(), lower, sample_.end());
    double typical = *lower / quartile;
    for (int round = 0; round < 3; ++round)
    {
        double sum = prior, count = prior;
        for (double square : squares_)
            if (square <= cutoff * typical)
            {
                sum += square;
                ++count;
            }
        typical = sum / count;
    }
    return typical;
}

void StripeScatter::apply(std::vector<StripePoint>& points)
{
    collect(points);
    const double typical = typicalSquare();
    double sum = prior * typical, count = prior, scale = 1;
    const auto change = [&](size_t i, int sign)
    {
        const bool isKept = squares_[i] <= cutoff * typical;
        sum += isKept ? sign * squares_[i] : 0;
        count += isKept ? sign : 0;
    };
    size_t begin = 0, end = 0;
    int last = -block;
    for (StripePoint& point : points)
    {
        if (point.column >= last + block)
        {
            last = point.column;
            for (; end < columns_.size() && columns_[end] <= last + reach; ++end)
                change(end, 1);
            for (; begin < end && columns_[begin] < last - reach; ++begin)
                change(begin, -1);
            scale = std::sqrt(sum / count);
        }
        point.sigma *= scale;
    }
}

}} // namespace cv::active_handeye
