// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "measure.hpp"
#include "refine_input.hpp"
#include "stripe_profile.hpp"

namespace cv { namespace active_handeye {

using Eigen::Matrix2d;
using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

const double reach = 3;        // columns by which a point may lie beyond the end of its piece
const size_t leastColumns = 8; // of a piece, inside the window

struct PixelWithCovariance
{
    Vector2d pixel = Vector2d::Constant(std::numeric_limits<double>::quiet_NaN());
    Matrix2d covariance = Matrix2d::Constant(std::numeric_limits<double>::quiet_NaN());
};

//! The point of the recorded image where the line through a piece has coordinate `start` along the stripe.
class PointOfLine
{
public:
    PointOfLine(const ProfileLine& line, const Camera& camera, int along, double start) : line_(line), camera_(camera)
    {
        const int maxIterations = 20;
        for (int i = 0; i < maxIterations; ++i) // Newton
        {
            linearize();
            const double step = (start - recorded_[along]) / tangent_[along];
            t_ += step;
            if (std::abs(step) < 1e-9)
                break;
        }
        linearize();
    }

    //! `sigmaAlong` moves the point along the line, the line's own variance moves it across the stripe.
    PixelWithCovariance withCovariance(int along, double sigmaAlong) const
    {
        const Vector2d across = normal_ - tangent_ * (normal_[along] / tangent_[along]);
        const Vector2d slide = tangent_ / tangent_[along];
        PixelWithCovariance result;
        result.pixel = recorded_;
        result.covariance =
            line_.variance(t_) * across * across.transpose() + sigmaAlong * sigmaAlong * slide * slide.transpose();
        return result;
    }

private:
    void linearize()
    {
        const Vector3d ray = camera_.K.inverse() * line_.at(t_).homogeneous();
        const Matrix2d K = camera_.K.topLeftCorner<2, 2>();
        const Matrix2d J = K * camera_.distortJacobian(ray.head<2>()) * K.inverse();
        recorded_ = camera_.project(ray);
        tangent_ = J * line_.direction;
        normal_ = J * line_.normal();
    }

    const ProfileLine line_;
    const Camera& camera_;
    double t_ = 0;
    Vector2d recorded_, tangent_, normal_;
};

//! Nearest piece that passes the pixel.
PixelWithCovariance locate(const StripeProfile& profile, const Camera& camera, const Vector2d& pixel, double sigmaAlong,
                           double maxDistance)
{
    const int along = profile.along();
    const double start = pixel[along];
    PixelWithCovariance best;
    double nearest = maxDistance;
    for (const Columns& piece : profile.pieces())
    {
        if (piece.empty() || start < piece.front().recorded[along] - reach ||
            start > piece.back().recorded[along] + reach)
            continue;
        size_t begin = 0, end = piece.size();
        while (begin < end && piece[begin].recorded[along] < start - profile.halfWindow())
            ++begin;
        while (end > begin && piece[end - 1].recorded[along] > start + profile.halfWindow())
            --end;
        if (end - begin < leastColumns)
            continue;
        const PointOfLine point(profile.line(piece, begin, end), camera, along, start);
        const PixelWithCovariance found = point.withCovariance(along, sigmaAlong);
        const double distance = std::abs(found.pixel[1 - along] - pixel[1 - along]);
        if (distance <= nearest)
        {
            nearest = distance;
            best = found;
        }
    }
    return best;
}

struct Corner
{
    PixelWithCovariance point;
    double openingAngle; // degrees
    int first, second;
};

//! Unit vector in the light plane, camera frame, from the corner towards a pixel of the recorded image.
Vector3d directionTo(const Vector2d& pixel, const Vector3d& corner, const Camera& camera, const LightPlane& light)
{
    const Vector3d ray = camera.ray(pixel);
    return (ray * (light.d / light.n.dot(ray)) - corner).normalized();
}

//! Between two directions of the light plane, through the direction to the camera; degrees.
double openingAngle(const Vector3d& corner, const Vector3d& a, const Vector3d& b, const LightPlane& light)
{
    const Vector3d toCamera = -(corner - light.n * light.n.dot(corner));
    const auto angle = [&](const Vector3d& v) { return std::atan2(light.n.dot(toCamera.cross(v)), toCamera.dot(v)); };
    const double first = angle(a), second = angle(b);
    const double between = std::abs(first - second) * 180 / CV_PI;
    return first * second <= 0 ? between : 360 - between;
}

//! Where two lines meet, and what their errors make of it; recorded image.
PixelWithCovariance intersection(const ProfileLine& a, const ProfileLine& b, const Camera& camera)
{
    Matrix2d normals;
    normals << a.normal().transpose(), b.normal().transpose();
    const Matrix2d inverse = normals.inverse();
    const Vector2d ideal = inverse * Vector2d(a.normal().dot(a.origin), b.normal().dot(b.origin));
    const Vector2d variances(a.variance(a.direction.dot(ideal - a.origin)),
                             b.variance(b.direction.dot(ideal - b.origin)));
    const Vector3d ray = camera.K.inverse() * ideal.homogeneous();
    const Matrix2d K = camera.K.topLeftCorner<2, 2>();
    const Matrix2d J = K * camera.distortJacobian(ray.head<2>()) * K.inverse() * inverse;
    PixelWithCovariance result;
    result.pixel = camera.project(ray);
    result.covariance = J * variances.asDiagonal() * J.transpose();
    return result;
}

//! False when the two pieces do not meet.
bool findCorner(const StripeProfile& profile, const Camera& camera, const LightPlane& light, int first, int second,
                double maxGap, Corner& corner)
{
    const double leastBend = 5 * CV_PI / 180; // of the lines in the image: flatter corners have no place
    const Columns &left = profile.pieces()[size_t(first)], &right = profile.pieces()[size_t(second)];
    if (left.size() < leastColumns || right.size() < leastColumns)
        return false;
    const size_t window = size_t(2 * profile.halfWindow()) + 1;
    const ProfileLine a = profile.line(left, left.size() - std::min(window, left.size()), left.size());
    const ProfileLine b = profile.line(right, 0, std::min(window, right.size()));
    if (std::abs(a.normal().dot(b.direction)) < std::sin(leastBend))
        return false;
    corner.point = intersection(a, b, camera);
    if (!((corner.point.pixel - left.back().recorded).norm() <= maxGap &&
          (corner.point.pixel - right.front().recorded).norm() <= maxGap))
        return false;
    const Vector3d ray = camera.ray(corner.point.pixel);
    const Vector3d X = ray * (light.d / light.n.dot(ray));
    corner.openingAngle = openingAngle(X, directionTo(left.front().recorded, X, camera, light),
                                       directionTo(right.back().recorded, X, camera, light), light);
    corner.first = first;
    corner.second = second;
    return true;
}

void writePixels(const AlignedVector<PixelWithCovariance>& found, OutputArray points, OutputArray covariances)
{
    const int count = int(found.size()), sizes[] = {count, 2, 2};
    points.create(count, 2, CV_64F);
    covariances.create(3, sizes, CV_64F);
    Mat pixels = points.getMat(), blocks = covariances.getMat();
    for (int i = 0; i < count; ++i)
    {
        Eigen::Map<Vector2d>(pixels.ptr<double>(i)) = found[size_t(i)].pixel;
        Eigen::Map<Matrix2d>(blocks.ptr<double>(i)) = found[size_t(i)].covariance;
    }
}

} // namespace

void locateOnStripe(InputArray stripePoints, InputArray sigmas, InputArray segmentIds, InputArray pixels,
                    InputArray cameraMatrix, InputArray distCoeffs, OutputArray points, OutputArray covariances,
                    double sigmaAlong, int orientation, double halfWindow, double maxDistance)
{
    CV_TRACE_FUNCTION();
    const Camera camera = readCamera(cameraMatrix, distCoeffs);
    const StripeProfile profile = readStripeProfile(stripePoints, sigmas, segmentIds, camera, orientation, halfWindow);
    if (!(sigmaAlong >= 0) || !std::isfinite(sigmaAlong))
        CV_Error(Error::StsOutOfRange, cv::format("sigmaAlong: needed 0 or a positive number, given %g", sigmaAlong));
    readPositive(maxDistance, "maxDistance");
    AlignedVector<PixelWithCovariance> found;
    for (const Vector2d& pixel : readPixels(pixels, "pixels"))
        found.push_back(locate(profile, camera, pixel, sigmaAlong, maxDistance));
    writePixels(found, points, covariances);
}

void findProfileCorners(InputArray stripePoints, InputArray sigmas, InputArray segmentIds, InputArray cameraMatrix,
                        InputArray distCoeffs, InputArray lightPlane, OutputArray corners, OutputArray covariances,
                        OutputArray openingAngles, OutputArray segments, int orientation, double halfWindow,
                        double maxGap)
{
    CV_TRACE_FUNCTION();
    const Camera camera = readCamera(cameraMatrix, distCoeffs);
    const LightPlane light = readLightPlane(lightPlane);
    const StripeProfile profile = readStripeProfile(stripePoints, sigmas, segmentIds, camera, orientation, halfWindow);
    readPositive(maxGap, "maxGap");
    AlignedVector<PixelWithCovariance> found;
    std::vector<double> angles;
    std::vector<int> pairs;
    for (int second = 1; second < int(profile.pieces().size()); ++second)
    {
        Corner corner;
        if (!findCorner(profile, camera, light, second - 1, second, maxGap, corner))
            continue;
        found.push_back(corner.point);
        angles.push_back(corner.openingAngle);
        pairs.insert(pairs.end(), {corner.first, corner.second});
    }
    writePixels(found, corners, covariances);
    openingAngles.create(int(angles.size()), 1, CV_64F);
    std::copy(angles.begin(), angles.end(), openingAngles.getMat().begin<double>());
    segments.create(int(angles.size()), 2, CV_32S);
    std::copy(pairs.begin(), pairs.end(), segments.getMat().begin<int>());
}

}} // namespace cv::active_handeye
