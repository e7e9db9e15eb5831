// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "observability.hpp"
#include "decompositions.hpp"

namespace cv { namespace active_handeye {

using Eigen::MatrixXd;
using Eigen::Vector3d;

CalibrationStep naturalUnits(const HandEyeCalibration& calibration, double workingDistance, double imageRadius)
{
    const double f = calibration.camera.K(0, 0), r2 = imageRadius * imageRadius;
    CalibrationStep units;
    units << f, f, f, f, f, 1 / r2, 1 / (r2 * r2), 1 / imageRadius, 1 / imageRadius, 1 / (r2 * r2 * r2),
        Vector3d::Ones(), Vector3d::Constant(workingDistance), 1, 1,
        std::max(calibration.light.d, 1e-9 * workingDistance);
    return units;
}

Eigen::VectorXd unitsOf(const MatrixXd& basis, const CalibrationStep& units)
{
    Eigen::VectorXd scale(basis.cols());
    for (int i = 0; i < basis.cols(); ++i)
    {
        int largest = 0;
        basis.col(i).cwiseAbs().maxCoeff(&largest);
        scale(i) = units(largest);
    }
    return scale;
}

namespace {

std::string vectorText(const Vector3d& v)
{
    return cv::format("(%.2f, %.2f, %.2f)", v.x(), v.y(), v.z());
}

std::string translationText(const Vector3d& direction, const std::string& deviates, const TurnDirections& turns)
{
    const std::string cure = turns.observed.cols() > 0 ? "a rotation about an axis away from it, such as gripper " +
                                                             vectorText(direction.unitOrthogonal())
                                                       : std::string("rotations about two axes that are not parallel");
    return "t_cam2gripper along gripper " + vectorText(direction) + ": " + deviates + "; add " + cure;
}

std::string describe(const CalibrationStep& direction, double deviation, const HandEyeCalibration& calibration,
                     const TurnDirections& turns)
{
    const double camera = direction.head<COLUMN_DISTORTION>().squaredNorm(),
                 lens = direction.segment<5>(COLUMN_DISTORTION).squaredNorm(),
                 rotation = direction.segment<3>(COLUMN_ROTATION).squaredNorm(),
                 translation = direction.segment<3>(COLUMN_TRANSLATION).squaredNorm(),
                 light = direction.tail<3>().squaredNorm();
    const double most = std::max(std::max(std::max(camera, lens), std::max(rotation, translation)), light);
    const std::string deviates = std::isfinite(deviation)
                                     ? cv::format("badly determined (standard deviation %.1f %%)", 100 * deviation)
                                     : "not observed";
    if (most == translation)
        return translationText(direction.segment<3>(COLUMN_TRANSLATION).normalized(), deviates, turns);
    if (most == rotation)
        return "R_cam2gripper about gripper " + vectorText(direction.segment<3>(COLUMN_ROTATION).normalized()) + ": " +
               deviates + "; add translations across this axis";
    if (most == camera)
    {
        const bool isFocal = direction.head<2>().squaredNorm() > 0.5 * camera;
        const Vector3d axis = calibration.cam2gripper.R.col(2);
        return std::string(isFocal ? "focal length: " : "principal point and skew: ") + deviates +
               (isFocal ? "; add translations along and across the optical axis, gripper "
                        : "; add translations along the optical axis, gripper ") +
               vectorText(axis);
    }
    if (most == lens)
        return "lens distortion: " + deviates + "; let points of the scene reach the corners of the image";
    return "light plane: " + deviates + "; add stripes of another direction, or on a surface of another tilt";
}

} // namespace

std::string unobservedTranslation(const Vector3d& direction, const TurnDirections& turns)
{
    return translationText(direction, "not observed", turns);
}

std::vector<WeakDirection> findWeakDirections(const MatrixXd& information, const MatrixXd& basis,
                                              const HandEyeCalibration& calibration, double workingDistance,
                                              double imageRadius, const TurnDirections& turns, double limit)
{
    const CalibrationStep units = naturalUnits(calibration, workingDistance, imageRadius);
    const Eigen::VectorXd scale = unitsOf(basis, units);
    const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen =
        symmetricEigen<MatrixXd>(scale.asDiagonal() * information * scale.asDiagonal());
    std::vector<WeakDirection> weak;
    for (int i = 0; i < basis.cols(); ++i)
    {
        const double value = eigen.eigenvalues()(i), smallest = 1e-12 * eigen.eigenvalues().maxCoeff();
        const double deviation = value > smallest ? 1 / std::sqrt(value) : std::numeric_limits<double>::infinity();
        if (deviation <= limit)
            break;
        const CalibrationStep direction =
            (basis * scale.asDiagonal() * eigen.eigenvectors().col(i)).cwiseQuotient(units);
        weak.push_back(WeakDirection{direction, deviation, describe(direction, deviation, calibration, turns)});
    }
    return weak;
}

}} // namespace cv::active_handeye
