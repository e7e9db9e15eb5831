// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "measure.hpp"
#include "numbers.hpp"

namespace cv { namespace active_handeye {

namespace {

//! Symmetric, and no covariance larger than the variances allow; what belongs to parameters of infinite variance is set to 0.
void readCalibrationCovariance(InputArray covariance, MeasurementErrors& errors)
{
    const Numbers numbers = numbersOf(covariance.getMat());
    const int n = CALIBRATION_PARAMETERS;
    if (numbers.values.size() != size_t(n) * n || numbers.rowLength != n)
        CV_Error(Error::StsBadSize,
                 "calibrationCovariance: needed 20 x 20 numbers as in RefineSummary::covariance, given " +
                     numbers.shape);
    errors.calibration = Eigen::Map<const Eigen::Matrix<double, n, n, Eigen::RowMajor>>(numbers.values.data());
    CalibrationMatrix& C = errors.calibration;
    for (int i = 0; i < n; ++i)
        if (C(i, i) == std::numeric_limits<double>::infinity())
        {
            errors.unobserved.push_back(i);
            C.row(i).setZero();
            C.col(i).setZero();
        }
    for (int i = 0; i < n; ++i)
        for (int j = 0; j <= i; ++j)
        {
            const double largest = std::sqrt(C(i, i) * C(j, j)), tolerance = 1e-6 * largest;
            if (!(std::abs(C(i, j)) <= largest + tolerance && std::abs(C(i, j) - C(j, i)) <= tolerance))
                CV_Error(
                    Error::StsBadArg,
                    cv::format("calibrationCovariance: needed a symmetric matrix with |c_ij| <= sqrt(c_ii c_jj), given "
                               "c_%d,%d = %g, c_%d,%d = %g with variances %g and %g",
                               i, j, C(i, j), j, i, C(j, i), C(i, i), C(j, j)));
        }
}

double readSigmaOfRobot(double sigma, const char* name)
{
    if (!(sigma >= 0) || !std::isfinite(sigma))
        CV_Error(Error::StsOutOfRange, cv::format("%s: needed 0 or a positive number, given %g", name, sigma));
    return sigma;
}

} // namespace

MeasurementErrors readMeasurementErrors(InputArray calibrationCovariance, double robotTranslationSigma,
                                        double robotRotationSigma)
{
    MeasurementErrors errors;
    if (!calibrationCovariance.empty())
        readCalibrationCovariance(calibrationCovariance, errors);
    errors.robotTranslationSigma = readSigmaOfRobot(robotTranslationSigma, "robotTranslationSigma");
    errors.robotRotationSigma = readSigmaOfRobot(robotRotationSigma, "robotRotationSigma");
    return errors;
}

void refuseMissed(const std::vector<size_t>& missed, const Pixels& pixels)
{
    const size_t named = std::min<size_t>(missed.size(), 8);
    std::string list;
    for (size_t i = 0; i < named; ++i)
        list += (i ? ", " : "") + std::to_string(missed[i]);
    CV_Error(
        Error::StsOutOfRange,
        cv::format("stripePoints: needed pixels whose rays meet the light plane in front of the camera, given %d of %d "
                   "points whose rays do not: %s%s; point %d is (%g, %g)",
                   int(missed.size()), int(pixels.size()), list.c_str(), named < missed.size() ? ", ..." : "",
                   int(missed[0]), pixels[missed[0]].x(), pixels[missed[0]].y()));
}

bool meets(const LightPlane& light, const Eigen::Vector3d& ray)
{
    const double smallestSlope = 1e-9; // of the angle between ray and plane, rad
    return light.n.dot(ray) > smallestSlope * ray.norm();
}

}} // namespace cv::active_handeye
