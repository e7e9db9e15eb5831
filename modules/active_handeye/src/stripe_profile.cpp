// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "stripe_profile.hpp"

namespace cv { namespace active_handeye {

using Eigen::Vector2d;

static const double sigmaFloor = 0.02; // px, of any line (doc/method/light_plane.md)

namespace {

//! A straight line h = a + b (s - centre), s along and h across the direction from the first to the last column.
struct LineFit
{
    Vector2d direction, normal;
    std::vector<double> residuals; // in units of the stated standard deviations
    double weight = 0, centre = 0, a = 0, spread = 0, b = 0;

    LineFit(const Columns& piece, size_t begin, size_t end, int along)
    {
        const Vector2d reference = piece[begin].ideal;
        direction = (piece[end - 1].ideal - reference).normalized();
        normal = Vector2d(-direction.y(), direction.x());
        const double obliqueness = std::abs(normal[1 - along]); // errors are along u or v, h is across
        std::vector<double> s, h, w;
        for (size_t i = begin; i < end; ++i)
        {
            const Vector2d x = piece[i].ideal - reference;
            const double sigma = obliqueness * piece[i].sigma;
            s.push_back(direction.dot(x));
            h.push_back(normal.dot(x));
            w.push_back(1 / (sigma * sigma));
            weight += w.back();
            centre += w.back() * s.back();
            a += w.back() * h.back();
        }
        centre /= weight;
        a /= weight;
        for (size_t i = 0; i < s.size(); ++i)
        {
            spread += w[i] * (s[i] - centre) * (s[i] - centre);
            b += w[i] * (s[i] - centre) * (h[i] - a);
        }
        b /= spread;
        for (size_t i = 0; i < s.size(); ++i)
            residuals.push_back(std::sqrt(w[i]) * (h[i] - a - b * (s[i] - centre)));
    }
};

} // namespace

StripeProfile::StripeProfile(const Pixels& pixels, const std::vector<double>& sigmas,
                             const std::vector<int>& segmentIds, const Camera& camera, int along, double halfWindow)
    : along_(along), halfWindow_(halfWindow)
{
    for (size_t i = 0; i < pixels.size(); ++i)
    {
        const int id = segmentIds[i];
        if (id < 0)
            continue;
        if (id >= int(pieces_.size()))
            pieces_.resize(size_t(id) + 1);
        pieces_[size_t(id)].push_back(Column{pixels[i], camera.idealPixel(pixels[i]), sigmas[i]});
    }
    inflation_ = correlationInflation();
}

/** 1 + 2 sum of r_k over the first lags k, r_k the correlation of the errors of columns k apart.

The residuals of a line through n columns have autocovariances that are 2 / n of the long-run variance too small, since
the line has two parameters: the last line undoes that.
*/
double StripeProfile::correlationInflation() const
{
    const size_t lags = 5, shortest = 30, longest = size_t(4 * halfWindow_) + 1;
    double sums[lags + 1] = {}, counts[lags + 1] = {}, windows = 0;
    for (const Columns& piece : pieces_)
    {
        const size_t parts = (piece.size() + longest - 1) / longest;
        for (size_t part = 0; part < parts && piece.size() / parts >= shortest; ++part, ++windows)
        {
            const LineFit fit(piece, piece.size() * part / parts, piece.size() * (part + 1) / parts, along_);
            for (size_t k = 0; k <= lags; ++k)
                for (size_t i = 0; i + k < fit.residuals.size(); ++i, ++counts[k])
                    sums[k] += fit.residuals[i] * fit.residuals[i + k];
        }
    }
    if (!(sums[0] > 0))
        return 1;
    double sum = 1;
    for (size_t k = 1; k <= lags; ++k)
        sum += 2 * (sums[k] / counts[k]) / (sums[0] / counts[0]);
    const double lost = 2 * windows / counts[0];
    return std::max(1., sum / (1 - (2 * lags + 1) * lost + lost * sum));
}

ProfileLine StripeProfile::line(const Columns& piece, size_t begin, size_t end) const
{
    const LineFit fit(piece, begin, end, along_);
    double squares = 0;
    for (double residual : fit.residuals)
        squares += residual * residual;
    const double scale = inflation_ * std::max(1., squares / double(fit.residuals.size() - 2));
    ProfileLine line;
    line.origin = piece[begin].ideal + fit.centre * fit.direction + fit.a * fit.normal;
    line.direction = (fit.direction + fit.b * fit.normal).normalized();
    line.varianceOfOrigin = scale / fit.weight + sigmaFloor * sigmaFloor;
    line.varianceOfSlope = scale / fit.spread;
    return line;
}

StripeProfile readStripeProfile(InputArray stripePoints, InputArray sigmas, InputArray segmentIds, const Camera& camera,
                                int orientation, double halfWindow)
{
    const Pixels pixels = readPixels(stripePoints, "stripePoints");
    const std::vector<int> ids = readIntegers(segmentIds, "segmentIds");
    if (ids.size() != pixels.size())
        CV_Error(Error::StsBadSize, cv::format("segmentIds: needed one number for each of the %d points, given %d",
                                               int(pixels.size()), int(ids.size())));
    for (int id : ids)
        if (id < -1 || id >= int(ids.size()))
            CV_Error(Error::StsOutOfRange,
                     cv::format("segmentIds: needed numbers from -1 to %d, given %d", int(ids.size()) - 1, id));
    if (orientation != STRIPE_HORIZONTAL && orientation != STRIPE_VERTICAL)
        CV_Error(Error::StsBadArg,
                 cv::format("orientation: needed STRIPE_HORIZONTAL or STRIPE_VERTICAL, given %d", orientation));
    if (!(halfWindow >= 4 && halfWindow <= 1000))
        CV_Error(Error::StsOutOfRange, cv::format("halfWindow: needed 4 to 1000 columns, given %g", halfWindow));
    return StripeProfile(pixels, readSigmas(sigmas, "sigmas", pixels.size()), ids, camera,
                         orientation == STRIPE_VERTICAL ? 1 : 0, halfWindow);
}

}} // namespace cv::active_handeye
