// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// Points seen in several views: generalised least squares over what each view says alone.
#include "precomp.hpp"
#include "measure.hpp"
#include "decompositions.hpp"
#include "numbers.hpp"
#include "refine_input.hpp"
#include "stripe_lines.hpp"

namespace cv { namespace active_handeye {

using Eigen::Matrix2d;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

namespace {

struct StripeObservation
{
    size_t row; //!< of stripePoints
    int view;
    ReprojectedPoint point;
    Matrix2d pixelCovariance;
};

typedef AlignedVector<StripeObservation> Observations;

struct CombinedPoint
{
    Vector3d X;
    Matrix3d covariance;
    std::vector<double> disagreements; // of the observations
};

//! Joint covariance of all coordinates: pixels apart, poses common to a view, calibration common to all.
MatrixXd jointCovariance(const Observations& seen, const MeasurementErrors& errors)
{
    const double exactness = 1e-7; // of the depth: the light plane is not better known, and the matrix regular
    const int n = int(seen.size());
    MatrixXd joint(3 * n, 3 * n);
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j)
        {
            const ReprojectedPoint &a = seen[size_t(i)].point, &b = seen[size_t(j)].point;
            Matrix3d block = errors.fromCalibration(a, b);
            if (seen[size_t(i)].view == seen[size_t(j)].view)
                block += errors.fromRobot(a, b);
            if (i == j)
                block += a.byPixel * seen[size_t(i)].pixelCovariance * a.byPixel.transpose() +
                         exactness * exactness * a.arm.squaredNorm() * Matrix3d::Identity();
            joint.block<3, 3>(3 * i, 3 * j) = block;
        }
    return joint;
}

//! Squared length of `x` in units of `covariance`, in the directions in which that is not zero.
double mahalanobis(const Vector3d& x, const Matrix3d& covariance)
{
    const Eigen::SelfAdjointEigenSolver<Matrix3d> eigen(covariance);
    double sum = 0;
    for (int i = 0; i < 3; ++i)
        if (eigen.eigenvalues()[i] > 1e-6 * eigen.eigenvalues()[2])
            sum += std::pow(eigen.eigenvectors().col(i).dot(x), 2) / eigen.eigenvalues()[i];
    return sum;
}

//! X minimises (X_i - X)^T C^-1 (X_j - X), C the joint covariance.
CombinedPoint combine(const Observations& seen, const MeasurementErrors& errors)
{
    CombinedPoint result;
    if (seen.size() == 1)
    {
        result.X = seen[0].point.X;
        result.covariance = errors.covariance(seen[0].point, seen[0].pixelCovariance);
        result.disagreements.assign(1, 0.);
        return result;
    }
    const int n = int(seen.size());
    const MatrixXd joint = jointCovariance(seen, errors);
    MatrixXd design(3 * n, 3);
    VectorXd X(3 * n);
    for (int i = 0; i < n; ++i)
    {
        design.block<3, 3>(3 * i, 0).setIdentity();
        X.segment<3>(3 * i) = seen[size_t(i)].point.X;
    }
    const MatrixXd weighted = solveSymmetric(joint, design);
    result.covariance = inverseOfSymmetric(design.transpose() * weighted);
    result.covariance = (0.5 * (result.covariance + result.covariance.transpose())).eval();
    result.X = result.covariance * (weighted.transpose() * X);
    for (int i = 0; i < n; ++i)
        result.disagreements.push_back(mahalanobis(X.segment<3>(3 * i) - result.X,
                                                   joint.block<3, 3>(3 * i, 3 * i) - result.covariance));
    for (const StripeObservation& observation : seen)
        errors.markUnobserved(observation.point, result.covariance);
    return result;
}

std::vector<int> readPointIds(InputArray pointIds, size_t count)
{
    const std::vector<int> ids = readIntegers(pointIds, "pointIds");
    if (ids.size() != count)
        CV_Error(Error::StsBadSize, cv::format("pointIds: needed one id for each of the %d pixels, given %d",
                                               int(count), int(ids.size())));
    std::vector<bool> present(count + 1, false);
    int largest = -1;
    for (size_t i = 0; i < count; ++i)
    {
        if (ids[i] < 0 || ids[i] >= int(count))
            CV_Error(Error::StsOutOfRange,
                     cv::format("pointIds[%d]: needed an id from 0 to %d, as there are no more points than pixels, "
                                "given %d",
                                int(i), int(count) - 1, ids[i]));
        present[size_t(ids[i])] = true;
        largest = std::max(largest, ids[i]);
    }
    for (int id = 0; id < largest; ++id)
        if (!present[size_t(id)])
            CV_Error(Error::StsBadArg,
                     cv::format("pointIds: needed every id from 0 to %d, given none that is %d", largest, id));
    return ids;
}

AlignedVector<Matrix2d> readPixelCovariances(InputArray covariances, size_t count)
{
    const Numbers numbers = numbersOf(covariances.getMat());
    if (numbers.values.size() != 4 * count)
        CV_Error(Error::StsBadSize, cv::format("pixelCovariances: needed %d x 2 x 2 numbers, given %s", int(count),
                                               numbers.shape.c_str()));
    AlignedVector<Matrix2d> result;
    for (size_t i = 0; i < count; ++i)
    {
        const Eigen::Map<const Matrix2d> C(&numbers.values[4 * i]);
        const double product = C(0, 0) * C(1, 1), tolerance = 1e-9 * product;
        const bool isCovariance = C(0, 0) >= 0 && C(1, 1) >= 0 && C.trace() > 0 && C.allFinite() &&
                                  std::abs(C(0, 1) - C(1, 0)) <= 1e-6 * std::sqrt(product) &&
                                  C(0, 1) * C(1, 0) <= product + tolerance;
        if (!isCovariance)
            CV_Error(Error::StsBadArg,
                     cv::format("pixelCovariances[%d]: needed a covariance other than zero, given (%g, %g; %g, %g)",
                                int(i), C(0, 0), C(1, 0), C(0, 1), C(1, 1)));
        result.push_back(C);
    }
    return result;
}

std::vector<Observations> observe(const Pixels& pixels, const std::vector<int>& views, const std::vector<int>& ids,
                                  const AlignedVector<Matrix2d>& pixelCovariances, const AlignedVector<Pose>& robot,
                                  StripeGeometry geometry)
{
    std::vector<Observations> points;
    std::vector<size_t> missed;
    for (size_t i = 0; i < pixels.size(); ++i)
    {
        const Vector3d ray = geometry.camera.ray(pixels[i]);
        if (!meets(geometry.light, ray))
        {
            missed.push_back(i);
            continue;
        }
        geometry.gripper2base = robot[size_t(views[i])];
        if (ids[i] >= int(points.size()))
            points.resize(size_t(ids[i]) + 1);
        points[size_t(ids[i])].push_back(StripeObservation{i, views[i], ReprojectedPoint(geometry, ray),
                                                           pixelCovariances[i]});
    }
    if (!missed.empty())
        refuseMissed(missed, pixels);
    return points;
}

} // namespace

void measureStripePoints(InputArrayOfArrays R_gripper2base, InputArrayOfArrays t_gripper2base, InputArray stripePoints,
                         InputArray stripeViews, InputArray pointIds, InputArray cameraMatrix, InputArray distCoeffs,
                         InputArray lightPlane, InputArray R_cam2gripper, InputArray t_cam2gripper,
                         OutputArray points3D, OutputArray covariances, OutputArray disagreements,
                         InputArray calibrationCovariance, InputArray pixelCovariances, double robotTranslationSigma,
                         double robotRotationSigma)
{
    CV_TRACE_FUNCTION();
    const AlignedVector<Pose> robot = readRobotPoses(R_gripper2base, t_gripper2base, 1);
    const Pixels pixels = readPixels(stripePoints, "stripePoints");
    const std::vector<int> views = readStripeViews(stripeViews, pixels.size(), robot.size());
    const std::vector<int> ids = readPointIds(pointIds, pixels.size());
    const Pose identity = {Matrix3d::Identity(), Vector3d::Zero()};
    const Pose cam2gripper = {readRotation(R_cam2gripper, "R_cam2gripper"),
                              readVector3(t_cam2gripper, "t_cam2gripper")};
    const StripeGeometry geometry = {readCamera(cameraMatrix, distCoeffs), readLightPlane(lightPlane),
                                     StripeGeometry::BASE, cam2gripper, identity};
    const MeasurementErrors errors =
        readMeasurementErrors(calibrationCovariance, robotTranslationSigma, robotRotationSigma);
    const std::vector<Observations> points =
        observe(pixels, views, ids, readPixelCovariances(pixelCovariances, pixels.size()), robot, geometry);

    const int count = int(points.size()), sizes[] = {count, 3, 3};
    points3D.create(count, 3, CV_64F);
    covariances.create(3, sizes, CV_64F);
    disagreements.create(int(pixels.size()), 1, CV_64F);
    Mat X = points3D.getMat(), C = covariances.getMat(), apart = disagreements.getMat();
    for (int p = 0; p < count; ++p)
    {
        const CombinedPoint combined = combine(points[size_t(p)], errors);
        Eigen::Map<Vector3d>(X.ptr<double>(p)) = combined.X;
        Eigen::Map<Matrix3d>(C.ptr<double>(p)) = combined.covariance;
        for (size_t i = 0; i < points[size_t(p)].size(); ++i)
            apart.ptr<double>(int(points[size_t(p)][i].row))[0] = combined.disagreements[i];
    }
}

}} // namespace cv::active_handeye
