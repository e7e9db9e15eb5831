// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "planned_views.hpp"

namespace cv { namespace active_handeye {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::Vector4d;

bool AssumedScene::isInFront(const CameraView& view, const Vector4d& surface) const
{
    return surface.head<3>().dot(view.centre) > surface(3);
}

bool AssumedScene::isHidden(const CameraView& view, const Vector3d& X) const
{
    const double onSurface = 0.01; // of the distance
    for (const Vector4d& surface : surfaces)
    {
        const double gap = std::abs(surface.head<3>().dot(X) - surface(3)) / surface.head<3>().norm();
        if (gap < onSurface * (X - view.centre).norm() && !isInFront(view, surface))
            return true;
    }
    return false;
}

bool AssumedScene::contains(const Vector2d& pixel) const
{
    return pixel.x() >= 0 && pixel.y() >= 0 && pixel.x() <= imageSize.width - 1 && pixel.y() <= imageSize.height - 1;
}

bool AssumedScene::project(const CameraView& view, const Vector3d& X, Vector2d& pixel) const
{
    const Vector3d Y = view.toCamera(X);
    const double smallestDepth = 1e-3; // of the distance
    if (!(Y.z() > smallestDepth * Y.norm()))
        return false;
    pixel = calibration.camera.project(Y);
    // A lens model turns back far outside of the image.
    const bool isUnique = calibration.camera.distortJacobian(Y.head<2>() / Y.z()).determinant() > 0;
    return isUnique && contains(pixel) && !isHidden(view, X);
}

Pixels AssumedScene::project(const CameraView& view) const
{
    Pixels pixels(points.size(), Vector2d::Constant(std::numeric_limits<double>::quiet_NaN()));
    for (size_t j = 0; j < points.size(); ++j)
    {
        Vector2d pixel;
        if (project(view, points[j], pixel))
            pixels[j] = pixel;
    }
    return pixels;
}

namespace {

struct Line
{
    Vector3d start, direction; //!< camera frame, direction of length 1
};

//! Where light plane and surface meet; starts beside the middle of the image. False where they are parallel.
bool intersection(const HandEyeCalibration& calibration, const Size& imageSize, const CameraView& view,
                  const Vector4d& surface, Line& line)
{
    const LightPlane& light = calibration.light;
    const Vector3d w = surface.head<3>(), wc = view.R_base2cam * w, along = light.n.cross(wc);
    if (!(along.norm() > 1e-9 * wc.norm()))
        return false;
    line.direction = along.normalized();
    const Vector3d middle = calibration.camera.ray(0.5 * Vector2d(imageSize.width, imageSize.height));
    const Vector3d lit = light.d / light.n.dot(middle) * middle;
    Eigen::Matrix3d equations;
    equations << light.n.transpose(), wc.transpose(), line.direction.transpose();
    line.start = equations.lu().solve(Vector3d(light.d, surface(3) - w.dot(view.centre), line.direction.dot(lit)));
    return line.start.allFinite();
}

} // namespace

//! The two points of the line that the image shows of the stripe; false where it shows none.
bool AssumedScene::stripeEnds(const CameraView& view, const Vector4d& surface, Vector2d (&ends)[2]) const
{
    Line line;
    if (!isInFront(view, surface) || !intersection(calibration, imageSize, view, surface, line))
        return false;
    const int steps = 400;
    const double reach = 2 * line.start.norm();
    Pixels seen;
    for (int i = -steps; i <= steps; ++i)
    {
        const Vector3d Y = line.start + reach * i / steps * line.direction;
        Vector2d pixel;
        if (project(view, view.R_cam2base * Y + view.centre, pixel))
            seen.push_back(calibration.camera.idealPixel(pixel));
    }
    if (seen.size() < 2)
        return false;
    const StripeLine fitted = fitStripeLine(seen);
    for (int end = 0; end < 2; ++end)
        ends[end] = recordedEnd(fitted, calibration.camera, end);
    return true;
}

StripeSegments AssumedScene::stripes(const AlignedVector<Pose>& gripper2base) const
{
    StripeSegments result;
    for (int surface = 0; surface < int(surfaces.size()); ++surface)
        for (int v = 0; v < int(gripper2base.size()); ++v)
        {
            StripeSegment segment = {int(result.size()), v, surface, {}, 1, true};
            if (stripeEnds(view(gripper2base[v]), surfaces[surface], segment.ends))
                result.push_back(segment);
        }
    return result;
}

}} // namespace cv::active_handeye
