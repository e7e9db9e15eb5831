// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "stripe_lines.hpp"
#include "decompositions.hpp"

namespace cv { namespace active_handeye {

static const double sigmaFloor = 0.02; // px

StripeLine fitStripeLine(const Pixels& idealPixels)
{
    StripeLine line;
    line.points = int(idealPixels.size());
    line.centre.setZero();
    for (const Eigen::Vector2d& pixel : idealPixels)
        line.centre += pixel / line.points;
    Eigen::Matrix2d scatter = Eigen::Matrix2d::Zero();
    for (const Eigen::Vector2d& pixel : idealPixels)
        scatter += (pixel - line.centre) * (pixel - line.centre).transpose();
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen = symmetricEigen(scatter);
    line.direction = eigen.eigenvectors().col(1);
    line.halfLength = std::sqrt(scatter.trace() / line.points);
    line.squares = 0;
    for (const Eigen::Vector2d& pixel : idealPixels)
        line.squares += line.distance(pixel) * line.distance(pixel);
    const double variance = line.points > 2 ? line.squares / (line.points - 2) : 0;
    line.sigma = std::sqrt(2 * variance / line.points + sigmaFloor * sigmaFloor);
    return line;
}

Eigen::Vector2d recordedEnd(const StripeLine& line, const Camera& camera, int i)
{
    return camera.project(camera.K.inverse() * line.end(i).homogeneous());
}

StripeLine readStripeLine(const Pixels& pixels, const Camera& camera, int index)
{
    if (pixels.size() < 2)
        CV_Error(Error::StsBadSize,
                 cv::format("stripePoints[%d]: needed at least 2 points, given %d", index, int(pixels.size())));
    Pixels ideal;
    ideal.reserve(pixels.size());
    for (const Eigen::Vector2d& pixel : pixels)
        ideal.push_back(camera.idealPixel(pixel));
    const StripeLine line = fitStripeLine(ideal);
    const double across = std::sqrt(line.squares / line.points), shortest = 0.5;
    if (line.halfLength < shortest || across > 0.3 * line.halfLength)
        CV_Error(
            Error::StsBadArg,
            cv::format(
                "stripePoints[%d]: needed a straight segment, given %d points that spread %.2f px along and %.2f px "
                "across their best line",
                index, line.points, line.halfLength, across));
    return line;
}

std::vector<int> readStripeViews(InputArray stripeViews, size_t segments, size_t views)
{
    const std::vector<int> values = readIntegers(stripeViews, "stripeViews");
    if (values.size() != segments)
        CV_Error(Error::StsBadSize,
                 cv::format("stripeViews: needed one view for each of the %d segments in stripePoints, given %d",
                            int(segments), int(values.size())));
    for (size_t i = 0; i < values.size(); ++i)
        if (values[i] < 0 || values[i] >= int(views))
            CV_Error(Error::StsOutOfRange, cv::format("stripeViews[%d]: needed a view from 0 to %d, given %d", int(i),
                                                      int(views) - 1, values[i]));
    return values;
}

std::vector<int> readSurfaceIds(InputArray surfaceIds, size_t segments)
{
    const std::vector<int> values = readIntegers(surfaceIds, "surfaceIds");
    if (values.size() != segments)
        CV_Error(Error::StsBadSize,
                 cv::format("surfaceIds: needed one id for each of the %d segments in stripePoints, given %d",
                            int(segments), int(values.size())));
    for (size_t i = 0; i < values.size(); ++i)
        if (values[i] < -1)
            CV_Error(Error::StsOutOfRange,
                     cv::format("surfaceIds[%d]: needed an id from 0 on, or -1 = not known, given %d", int(i),
                                values[i]));
    return values;
}

}} // namespace cv::active_handeye
