// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "refine_input.hpp"
#include "numbers.hpp"

namespace cv { namespace active_handeye {

using Eigen::Vector3d;

std::vector<std::vector<double>> readPointSigmas(InputArrayOfArrays pointSigmas, const std::vector<Pixels>& imagePoints)
{
    std::vector<std::vector<double>> result;
    if (pointSigmas.empty())
        return result;
    const std::vector<Numbers> list = readList(pointSigmas);
    if (list.size() != imagePoints.size())
        CV_Error(Error::StsBadSize, cv::format("pointSigmas: needed one array for each of the %d views, given %d",
                                               int(imagePoints.size()), int(list.size())));
    for (size_t view = 0; view < list.size(); ++view)
    {
        const std::vector<double>& sigmas = list[view].values;
        if (sigmas.size() != imagePoints[view].size())
            CV_Error(Error::StsBadSize,
                     cv::format("pointSigmas[%d]: needed one number for each of the %d points, given %s", int(view),
                                int(imagePoints[view].size()), list[view].shape.c_str()));
        for (size_t j = 0; j < sigmas.size(); ++j)
            if (!std::isnan(imagePoints[view][j].x()) && !(sigmas[j] > 0 && std::isfinite(sigmas[j])))
                CV_Error(
                    Error::StsOutOfRange,
                    cv::format(
                        "pointSigmas[%d]: needed a positive number for a point that was seen, given %g at point %d",
                        int(view), sigmas[j], int(j)));
        result.push_back(sigmas);
    }
    return result;
}

AlignedVector<Vector3d> readObjectPoints(InputArray objectPoints, size_t points)
{
    AlignedVector<Vector3d> result;
    if (objectPoints.empty())
        return result;
    const Numbers numbers = numbersOf(objectPoints.getMat());
    if (numbers.rowLength != 3 || numbers.values.size() != 3 * points)
        CV_Error(Error::StsBadSize,
                 cv::format("objectPoints: needed %d x 3 coordinates, one row for each point of imagePoints, given %s",
                            int(points), numbers.shape.c_str()));
    for (size_t j = 0; j < points; ++j)
    {
        const Vector3d X(&numbers.values[3 * j]);
        const bool isUnknown = std::isnan(X.x()) && std::isnan(X.y()) && std::isnan(X.z());
        if (!isUnknown && !X.allFinite())
            CV_Error(
                Error::StsBadArg,
                cv::format(
                    "objectPoints: needed three finite numbers, or three NaN for an unknown point, given (%g, %g, %g) at point %d",
                    X.x(), X.y(), X.z(), int(j)));
        result.push_back(X);
    }
    return result;
}

std::vector<double> readStripeSigmas(InputArray stripeSigmas, size_t segments)
{
    std::vector<double> result;
    if (stripeSigmas.empty())
        return result;
    result = numbersOf(stripeSigmas.getMat()).values;
    if (result.size() != segments)
        CV_Error(Error::StsBadSize, cv::format("stripeSigmas: needed one number for each of the %d segments, given %d",
                                               int(segments), int(result.size())));
    for (size_t i = 0; i < result.size(); ++i)
        if (!(result[i] > 0 && std::isfinite(result[i])))
            CV_Error(Error::StsOutOfRange,
                     cv::format("stripeSigmas[%d]: needed a positive number, given %g", int(i), result[i]));
    return result;
}

LightPlane readLightPlane(InputArray lightPlane)
{
    const Numbers numbers = numbersOf(lightPlane.getMat());
    if (numbers.values.size() != 4)
        CV_Error(Error::StsBadSize, "lightPlane: needed 4 numbers (nx, ny, nz, d), given " + numbers.shape);
    const LightPlane light = {Vector3d(numbers.values.data()), numbers.values[3]};
    if (!(std::abs(light.n.norm() - 1) < 1e-6 && light.d > 0 && std::isfinite(light.d)))
        CV_Error(Error::StsBadArg,
                 cv::format("lightPlane: needed |n| = 1 and d > 0, given |n| = %g, d = %g", light.n.norm(), light.d));
    return LightPlane{light.n.normalized(), light.d};
}

void checkRefineParams(const RefineParams& params)
{
    const int allFlags = 2 * REFINE_ALLOW_PARTIAL - 1;
    if (params.flags & ~allFlags)
        CV_Error(Error::StsBadArg,
                 cv::format("params.flags: needed a combination of RefineFlags, given %d", params.flags));
    if (params.lensModel < LENS_AUTO || params.lensModel > LENS_K3)
        CV_Error(Error::StsBadArg,
                 cv::format("params.lensModel: needed LENS_AUTO (-1) to LENS_K3 (4), given %d", params.lensModel));
    if (params.pointSigma == 0 || params.stripeSigma == 0)
        CV_Error(Error::StsOutOfRange,
                 "params.pointSigma, params.stripeSigma: needed positive numbers, or negative ones for "
                 "levels to be estimated, given 0");
    const double levels[] = {params.pointSigma, params.stripeSigma, params.robotTranslationSigma,
                             params.robotRotationSigma};
    for (double level : levels)
        if (!std::isfinite(level))
            CV_Error(Error::StsOutOfRange, cv::format("params: needed finite noise levels, given %g", level));
    if ((params.robotTranslationSigma == 0) != (params.robotRotationSigma == 0))
        CV_Error(
            Error::StsBadArg,
            cv::format(
                "params.robotTranslationSigma, params.robotRotationSigma: needed both 0 (an exact robot) or neither, given %g and %g",
                params.robotTranslationSigma, params.robotRotationSigma));
    readPositive(params.huberThreshold, "params.huberThreshold");
    readPositive(params.rejectThreshold, "params.rejectThreshold");
    readPositive(params.maxIterations, "params.maxIterations");
    readPositive(params.orientationTolerance, "params.orientationTolerance");
}

}} // namespace cv::active_handeye
