// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "input.hpp"
#include "numbers.hpp"

namespace cv { namespace active_handeye {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

const double rotationTolerance = 1e-6;

void requireFinite(const Numbers& numbers, const std::string& name)
{
    for (size_t i = 0; i < numbers.values.size(); ++i)
        if (!std::isfinite(numbers.values[i]))
            CV_Error(Error::StsBadArg, cv::format("%s: needed finite numbers, given %g at position %d", name.c_str(),
                                                  numbers.values[i], int(i)));
}

Matrix3d toRotation(const Numbers& numbers, const std::string& name)
{
    requireFinite(numbers, name);
    if (numbers.values.size() == 3)
        return expRotation(Vector3d(numbers.values.data()));
    if (numbers.values.size() != 9)
        CV_Error(Error::StsBadSize,
                 name + ": needed a 3 x 3 rotation or a rotation vector of 3 numbers, given " + numbers.shape);
    const Matrix3d R = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(numbers.values.data());
    const double deviation = (R.transpose() * R - Matrix3d::Identity()).cwiseAbs().maxCoeff();
    if (deviation > rotationTolerance || R.determinant() < 0)
        CV_Error(Error::StsBadArg,
                 cv::format(
                     "%s: needed a rotation (|R^T R - I| <= %g, det R = +1), given |R^T R - I| = %.3g, det R = %.6g%s",
                     name.c_str(), rotationTolerance, deviation, R.determinant(),
                     R.determinant() < 0 ? " (left-handed)" : ""));
    return Eigen::Quaterniond(R).normalized().toRotationMatrix();
}

//! "name[i]"; made for every item of every list, and cv::format() takes four times as long.
std::string itemName(const std::string& name, size_t i)
{
    return name + "[" + std::to_string(i) + "]";
}

Vector3d toVector3(const Numbers& numbers, const std::string& name)
{
    requireFinite(numbers, name);
    if (numbers.values.size() != 3)
        CV_Error(Error::StsBadSize, name + ": needed 3 numbers, given " + numbers.shape);
    return Vector3d(numbers.values.data());
}

Pixels toPixels(const Numbers& numbers, const std::string& name)
{
    if (!numbers.values.empty() && numbers.rowLength != 2)
        CV_Error(Error::StsBadSize, name + ": needed N x 2 pixels, given " + numbers.shape);
    Pixels pixels;
    pixels.reserve(numbers.values.size() / 2);
    for (size_t i = 0; i < numbers.values.size(); i += 2)
        pixels.push_back(Vector2d(numbers.values[i], numbers.values[i + 1]));
    return pixels;
}

//! Refuses a view whose translation is about 1000 times longer than most, or 1000 times shorter in much the same direction.
void requireOneUnit(const AlignedVector<Pose>& poses, const char* name)
{
    std::vector<double> coordinates[3], lengths;
    for (const Pose& pose : poses)
    {
        lengths.push_back(pose.t.norm());
        for (int axis = 0; axis < 3; ++axis)
            coordinates[axis].push_back(pose.t[axis]);
    }
    const Vector3d typical(median(coordinates[0]), median(coordinates[1]), median(coordinates[2]));
    const double length = median(lengths);
    for (size_t view = 0; view < poses.size(); ++view)
    {
        const bool tooLong = length > 0 && lengths[view] > 300 * length && lengths[view] < 3000 * length;
        const bool tooShort = lengths[view] > length / 3000 && lengths[view] < length / 300 &&
                              poses[view].t.dot(typical) > 0.8 * lengths[view] * typical.norm();
        if (tooLong || tooShort)
            CV_Error(
                Error::StsBadArg,
                cv::format("%s[%d]: millimetres and metres seem to be mixed; needed one unit of length in all views, "
                           "given |t| = %g where the median of the views is %g",
                           name, int(view), lengths[view], length));
    }
}

} // namespace

double readPositive(double value, const char* name)
{
    if (!(value > 0) || !std::isfinite(value))
        CV_Error(Error::StsOutOfRange, cv::format("%s: needed a positive number, given %g", name, value));
    return value;
}

Matrix3d readRotation(InputArray R, const char* name)
{
    return toRotation(numbersOf(R.getMat()), name);
}

Vector3d readVector3(InputArray v, const char* name)
{
    return toVector3(numbersOf(v.getMat()), name);
}

std::vector<Matrix3d> readRotations(InputArrayOfArrays R, const char* name)
{
    const std::vector<Numbers> list = readList(R);
    std::vector<Matrix3d> rotations;
    rotations.reserve(list.size());
    for (size_t i = 0; i < list.size(); ++i)
        rotations.push_back(toRotation(list[i], itemName(name, i)));
    return rotations;
}

AlignedVector<Pose> readPoses(InputArrayOfArrays R, InputArrayOfArrays t, const char* R_name, const char* t_name,
                              size_t least)
{
    const std::vector<Matrix3d> rotations = readRotations(R, R_name);
    const std::vector<Numbers> translations = readList(t);
    if (rotations.size() != translations.size())
        CV_Error(Error::StsBadSize,
                 cv::format("%s: needed one translation for each of the %d rotations of %s, given %d", t_name,
                            int(rotations.size()), R_name, int(translations.size())));
    if (rotations.size() < least)
        CV_Error(Error::StsBadSize,
                 cv::format("%s: needed at least %d views, given %d", R_name, int(least), int(rotations.size())));
    AlignedVector<Pose> poses;
    for (size_t i = 0; i < rotations.size(); ++i)
        poses.push_back(Pose{rotations[i], toVector3(translations[i], itemName(t_name, i))});
    requireOneUnit(poses, t_name);
    return poses;
}

AlignedVector<Pose> readRobotPoses(InputArrayOfArrays R_gripper2base, InputArrayOfArrays t_gripper2base, size_t least)
{
    return readPoses(R_gripper2base, t_gripper2base, "R_gripper2base", "t_gripper2base", least);
}

Pixels readPixels(InputArray points, const char* name)
{
    const Numbers numbers = numbersOf(points.getMat());
    requireFinite(numbers, name);
    return toPixels(numbers, name);
}

AlignedVector<Vector3d> readPoints3D(InputArray points, const char* name)
{
    AlignedVector<Vector3d> result;
    const Numbers numbers = numbersOf(points.getMat());
    requireFinite(numbers, name);
    if (!numbers.values.empty() && numbers.rowLength != 3)
        CV_Error(Error::StsBadSize, cv::format("%s: needed M x 3 coordinates, given %s", name, numbers.shape.c_str()));
    for (size_t i = 0; i < numbers.values.size(); i += 3)
        result.push_back(Vector3d(&numbers.values[i]));
    return result;
}

std::vector<Pixels> readPixelLists(InputArrayOfArrays points, const char* name)
{
    const std::vector<Numbers> list = readList(points);
    std::vector<Pixels> result;
    for (size_t i = 0; i < list.size(); ++i)
    {
        const std::string item = itemName(name, i);
        requireFinite(list[i], item);
        result.push_back(toPixels(list[i], item));
    }
    return result;
}

std::vector<Pixels> readImagePoints(InputArrayOfArrays imagePoints, size_t views)
{
    const std::vector<Numbers> list = readList(imagePoints);
    if (list.size() != views)
        CV_Error(Error::StsBadSize, cv::format("imagePoints: needed one array for each of the %d views, given %d",
                                               int(views), int(list.size())));
    std::vector<Pixels> result;
    for (size_t view = 0; view < views; ++view)
    {
        const std::string item = itemName("imagePoints", view);
        result.push_back(toPixels(list[view], item));
        if (result[view].size() != result[0].size())
            CV_Error(
                Error::StsBadSize,
                cv::format(
                    "%s: needed %d pixels as in imagePoints[0] (row j is the same scene point in every view), given %d",
                    item.c_str(), int(result[0].size()), int(result[view].size())));
        for (size_t j = 0; j < result[view].size(); ++j)
        {
            const Vector2d& x = result[view][j];
            if (!x.allFinite() && !(std::isnan(x.x()) && std::isnan(x.y())))
                CV_Error(
                    Error::StsBadArg,
                    cv::format(
                        "%s: needed two finite numbers, or (NaN, NaN) for a point that was not seen, given (%g, %g) "
                        "at point %d",
                        item.c_str(), x.x(), x.y(), int(j)));
        }
    }
    return result;
}

std::vector<double> readSigmas(InputArray sigmas, const char* name, size_t count)
{
    const std::vector<double> values = numbersOf(sigmas.getMat()).values;
    if (values.size() != count)
        CV_Error(Error::StsBadSize, cv::format("%s: needed one number for each of the %d points, given %d", name,
                                               int(count), int(values.size())));
    for (double value : values)
        readPositive(value, name);
    return values;
}

std::vector<int> readIntegers(InputArray values, const char* name)
{
    const Numbers numbers = numbersOf(values.getMat());
    std::vector<int> integers;
    for (double value : numbers.values)
    {
        if (!(value == std::floor(value)) || std::abs(value) > 1e9)
            CV_Error(Error::StsBadArg, cv::format("%s: needed whole numbers, given %g", name, value));
        integers.push_back(int(value));
    }
    return integers;
}

void readDistortion(InputArray distCoeffs, Camera& camera)
{
    const Numbers numbers = numbersOf(distCoeffs.getMat());
    requireFinite(numbers, "distCoeffs");
    const size_t count = numbers.values.size();
    if (count != 0 && count != 4 && count != 5)
        CV_Error(Error::StsBadSize,
                 cv::format("distCoeffs: needed none, 4 (k1, k2, p1, p2) or 5 (and k3) numbers, given %d", int(count)));
    std::copy(numbers.values.begin(), numbers.values.end(), camera.D);
}

Camera readCamera(InputArray cameraMatrix, InputArray distCoeffs)
{
    const Numbers numbers = numbersOf(cameraMatrix.getMat());
    if (numbers.values.size() != 9)
        CV_Error(Error::StsBadSize,
                 "cameraMatrix: needed 3 x 3 numbers, given " + (numbers.values.empty() ? "none" : numbers.shape));
    requireFinite(numbers, "cameraMatrix");
    Camera camera;
    camera.K = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(numbers.values.data());
    const Matrix3d& K = camera.K;
    if (!(K(0, 0) > 0 && K(1, 1) > 0 && K(1, 0) == 0 && K(2, 0) == 0 && K(2, 1) == 0 && K(2, 2) == 1))
        CV_Error(Error::StsBadArg,
                 cv::format(
                     "cameraMatrix: needed (fx, skew, cx; 0, fy, cy; 0, 0, 1) with fx, fy > 0, given (%g, %g, %g; %g, "
                     "%g, %g; %g, %g, %g)",
                     K(0, 0), K(0, 1), K(0, 2), K(1, 0), K(1, 1), K(1, 2), K(2, 0), K(2, 1), K(2, 2)));
    readDistortion(distCoeffs, camera);
    return camera;
}

std::vector<Pixels> idealPixels(std::vector<Pixels> recorded, const Camera& camera)
{
    if (!camera.hasDistortion())
        return recorded;
    for (Pixels& pixels : recorded)
        for (Vector2d& x : pixels)
            if (!std::isnan(x.x()))
                x = camera.idealPixel(x);
    return recorded;
}

}} // namespace cv::active_handeye
