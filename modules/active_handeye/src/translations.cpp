// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "closed_forms.hpp"
#include "decompositions.hpp"
#include "foe.hpp"
#include "translations_problem.hpp"

namespace cv { namespace active_handeye {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;

namespace {

const int allFlags = TRANSLATIONS_FIX_K | TRANSLATIONS_ZERO_SKEW | TRANSLATIONS_SQUARE_PIXELS;

struct Estimate
{
    Projection projection;
    MatrixXd covariance;
    double rms;
};

//! Residuals of a projection that something else has found.
class GivenProjection : public TranslationsProblem
{
public:
    GivenProjection(const GroupTranslations& motion, const std::vector<Pixels>& pixels, const Normalization& T,
                    const ProjectionSolver& solver, const Projection& given)
        : TranslationsProblem(motion, pixels, T, solver), p_(solver.vector(given))
    {}

    Vector9d minimize(const Matrix9d&) CV_OVERRIDE { return p_; }
    bool mirror(const Matrix9d&, Vector9d&) CV_OVERRIDE { return false; }
    MatrixXd tangent() const CV_OVERRIDE { return MatrixXd(9, 0); }

private:
    Vector9d p_;
};

void requireTracks(const Tracks& tracks, const std::vector<Pixels>& pixels, int parameters)
{
    std::vector<int> points;
    points.reserve(size_t(tracks.count()));
    for (int j = 0; j < tracks.count(); ++j)
        points.push_back(tracks.observations[tracks.first[j]].point);
    std::sort(points.begin(), points.end());
    const int common = int(std::unique(points.begin(), points.end()) - points.begin());
    const int equations = 2 * int(tracks.observations.size()) - 3 * tracks.count();
    if (common < 2 || equations < parameters)
        CV_Error(
            Error::StsNoConv,
            cv::format(
                "imagePoints: too few points in common; needed 2 or more points that are seen in two views of equal orientation, and %d "
                "equations, given %d such points with %d equations (2 per image point - 3 per point and group) out of %d points in %d views",
                parameters, common, equations, int(pixels[0].size()), int(pixels.size())));
}

//! The covariance leaves no doubt that the data say something about fx.
void requireKnownFocalLength(const Projection& projection, const MatrixXd& covariance)
{
    const double fx = projection.K(0, 0), deviation = std::sqrt(covariance(0, 0)), largestShare = 0.3;
    if (!(deviation < largestShare * fx))
        CV_Error(
            Error::StsNoConv,
            cv::format(
                "imagePoints: cameraMatrix is not determined; needed a standard deviation of fx below %g of it, given fx = %.4g +- "
                "%.2g px: translate farther, also along the optical axis, or use points at different depths",
                largestShare, fx, deviation));
}

Estimate estimateMetric(const GroupTranslations& motion, const std::vector<Pixels>& pixels, const Normalization& T,
                        const ProjectionSolver& solver, ViewDoubts& doubts)
{
    TranslationsProblem problem(motion, pixels, T, solver);
    problem.largeResidual = doubts.threshold;
    requireTracks(problem.tracks, pixels, solver.freeCount());
    const TrackFit<TranslationModel> fit = fitTracks(problem);
    doubts.rejectedViews = fit.rejectedViews;
    const MatrixXd covariance = solver.covariance(problem.projection, fit.S, fit.sigma(solver.freeCount()));
    return Estimate{problem.projection, covariance, fit.rms() / T.scale};
}

//! One translation: its FOE in normalised pixels, with the information on the tangent plane, and the displacement of the gripper.
struct Expansion
{
    Vector3d e;
    Matrix3d information;
    Vector3d b;
    int view;
};

Expansion expansionOf(const GroupTranslations& motion, const std::vector<Pixels>& pixels, const Normalization& T,
                      int from, int to)
{
    Pixels x1, x2;
    for (size_t j = 0; j < pixels[from].size(); ++j)
        if (pixels[from][j].allFinite() && pixels[to][j].allFinite())
            x1.push_back(pixels[from][j]), x2.push_back(pixels[to][j]);
    const double threshold = 2, confidence = 0.999;
    const FOE foe = estimateFOE(x1, x2, FOE_RANSAC, threshold, confidence,
                                cv::format("imagePoints[%d], imagePoints[%d]", from, to));
    const Vector3d mapped = T.matrix() * foe.direction;
    const Vector3d e = mapped.normalized();
    const Eigen::Matrix<double, 3, 2> basis = tangentBasis(e);
    const Eigen::Matrix<double, 2, 3> J = basis.transpose() * T.matrix() / mapped.norm();
    const double floor = 1e-9; // rad: exact data have no noise, but their rounding
    const Eigen::Matrix2d C = J * foe.covariance * J.transpose() + floor * floor * Eigen::Matrix2d::Identity();
    return Expansion{e, basis * C.inverse() * basis.transpose(), motion.displacement[to] - motion.displacement[from],
                     to};
}

TranslationModel modelOf(const Expansion& expansion)
{
    TranslationModel model;
    model.b = expansion.b;
    return model;
}

//! e_i ~ P b_i (paper, (16)-(17)), weighted by the covariance of every FOE: p^T S p.
Matrix9d expansionForm(const std::vector<Expansion>& expansions, const Vector9d* p)
{
    Matrix9d S = Matrix9d::Zero();
    for (const Expansion& expansion : expansions)
    {
        const Eigen::Matrix<double, 3, 9> D = modelOf(expansion).D();
        const double length = p ? (D * *p).norm() : expansion.b.norm();
        const Matrix3d W =
            p ? expansion.information : Matrix3d(Matrix3d::Identity() - expansion.e * expansion.e.transpose());
        S += D.transpose() * W * D / (length * length);
    }
    return S;
}

void requireFourDirections(const Matrix9d& S)
{
    const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen = symmetricEigen<MatrixXd>(S);
    if (eigen.eigenvalues()[1] < 1e-7 * eigen.eigenvalues()[8])
        CV_Error(
            Error::StsNoConv,
            "t_gripper2base: TRANSLATIONS_FOE with cameraMatrix unknown needs at least four translations in one group or "
            "over all groups, no three of them coplanar; given fewer: add translations in new directions, or use "
            "TRANSLATIONS_METRIC, which needs three");
}

//! R_cam2gripper that turns the FOEs into the displacements. Unlike p^T S p, which squares them, it heeds their signs.
Matrix3d rotationFromFOEs(const std::vector<Expansion>& expansions, const Normalization& T, const Matrix3d& K)
{
    const Matrix3d toCamera = (T.matrix() * K).inverse();
    Matrix3d sum = Matrix3d::Zero();
    for (const Expansion& expansion : expansions)
        sum += expansion.b.normalized() * (toCamera * expansion.e).normalized().transpose();
    return nearestRotation(sum);
}

//! Minimum of p^T S p, and its S; in three passes, since the weights need the lengths of the P b_i.
Projection projectionFromFOEs(const std::vector<Expansion>& expansions, const Normalization& T,
                              const ProjectionSolver& solver, const Matrix3d* knownK, Matrix9d& S)
{
    Projection projection;
    if (knownK)
        projection.K = *knownK, projection.R = rotationFromFOEs(expansions, T, *knownK);
    S = expansionForm(expansions, 0);
    if (!knownK)
        requireFourDirections(S);
    for (int pass = 0; pass < 3; ++pass)
    {
        projection = knownK ? solver.minimizeFrom(projection, S) : solver.minimize(S);
        const Vector9d p = solver.vector(projection);
        S = expansionForm(expansions, &p);
    }
    return projection;
}

Estimate estimateFromFOEs(const GroupTranslations& motion, const std::vector<Pixels>& pixels, const Normalization& T,
                          const ProjectionSolver& solver, const Matrix3d* knownK)
{
    std::vector<Expansion> expansions;
    for (const MotionGroup& group : motion.groups)
        for (size_t k = 1; k < group.views.size(); ++k)
            expansions.push_back(expansionOf(motion, pixels, T, group.views[0], group.views[k]));
    Matrix9d S;
    const Projection projection = projectionFromFOEs(expansions, T, solver, knownK, S);
    const Vector9d p = solver.vector(projection);
    for (const Expansion& expansion : expansions)
        if (expansion.e.dot(modelOf(expansion).shift(p)) > 0)
            CV_Error(
                Error::StsNoConv,
                cv::format(
                    "t_gripper2base[%d]: the image moved against the translation of the robot; needed poses that belong to "
                    "imagePoints: are they inverted (base2gripper), or in another order?",
                    expansion.view));
    const int redundancy = 2 * int(expansions.size()) - solver.freeCount();
    const double misfit = redundancy > 0 ? std::sqrt(std::max(p.dot(S * p), 0.) / redundancy) : 1;
    GivenProjection given(motion, pixels, T, solver, projection);
    return Estimate{projection, solver.covariance(projection, S, std::max(misfit, 1.)), rmsOfTracks(given) / T.scale};
}

Estimate estimateOnce(const GroupTranslations& motion, const std::vector<Pixels>& pixels, const Camera& camera,
                      TranslationsMethod method, int flags, ViewDoubts& doubts)
{
    std::vector<const Pixels*> all;
    for (const MotionGroup& group : motion.groups)
        for (int view : group.views)
            if (group.views.size() > 1)
                all.push_back(&pixels[view]);
    const Normalization T(all);
    const ProjectionSolver solver(T, motion.directions, flags, camera.K);
    return method == TRANSLATIONS_FOE
               ? estimateFromFOEs(motion, pixels, T, solver, flags & TRANSLATIONS_FIX_K ? &camera.K : 0)
               : estimateMetric(motion, pixels, T, solver, doubts);
}

//! K unknown, distortion known: removes it with the last K until K stays.
Estimate estimateWithDistortion(const GroupTranslations& motion, const std::vector<Pixels>& recorded, Camera camera,
                                bool guessed, TranslationsMethod method, int flags, ViewDoubts& doubts)
{
    if (!guessed)
        camera.K = estimateOnce(motion, recorded, camera, method, flags, doubts).projection.K;
    const int maxRounds = 100;
    for (int round = 0; round < maxRounds; ++round)
    {
        const Estimate estimate = estimateOnce(motion, idealPixels(recorded, camera), camera, method, flags, doubts);
        const double change = (estimate.projection.K - camera.K).cwiseAbs().maxCoeff();
        camera.K = estimate.projection.K;
        if (change <= 1e-10 * camera.K(0, 0))
            return estimate;
    }
    CV_Error(
        Error::StsNoConv,
        cv::format(
            "distCoeffs: removing the distortion with an unknown cameraMatrix did not settle in %d rounds; needed a weaker "
            "distortion, or cameraMatrix with TRANSLATIONS_FIX_K",
            maxRounds));
}

} // namespace

double translationsClosedForm(InputArrayOfArrays R_gripper2base, InputArrayOfArrays t_gripper2base,
                              InputArrayOfArrays imagePoints, InputOutputArray cameraMatrix, InputArray distCoeffs,
                              OutputArray R_cam2gripper, OutputArray covariance, TranslationsMethod method, int flags,
                              double orientationTolerance, ViewDoubts& doubts)
{
    const AlignedVector<Pose> poses = readRobotPoses(R_gripper2base, t_gripper2base);
    const std::vector<Pixels> recorded = readImagePoints(imagePoints, poses.size());
    if (method != TRANSLATIONS_METRIC && method != TRANSLATIONS_FOE)
        CV_Error(Error::StsBadArg,
                 cv::format("method: needed TRANSLATIONS_METRIC (0) or TRANSLATIONS_FOE (1), given %d", int(method)));
    if (flags & ~allFlags)
        CV_Error(
            Error::StsBadArg,
            cv::format("flags: needed a combination of TRANSLATIONS_FIX_K, _ZERO_SKEW and _SQUARE_PIXELS, given %d",
                       flags));
    readPositive(orientationTolerance, "orientationTolerance");
    const bool knownK = (flags & TRANSLATIONS_FIX_K) != 0, guessed = !cameraMatrix.empty();
    Camera camera;
    if (knownK || guessed)
        camera = readCamera(cameraMatrix, distCoeffs);
    else
        readDistortion(distCoeffs, camera);

    const GroupTranslations motion(poses, orientationTolerance);
    motion.requireDirections(knownK ? 2 : 3, knownK ? "two that are not parallel"
                                                    : "three that are not coplanar (two with TRANSLATIONS_FIX_K)");
    const Estimate estimate = knownK || !camera.hasDistortion()
                                  ? estimateOnce(motion, idealPixels(recorded, camera), camera, method, flags, doubts)
                                  : estimateWithDistortion(motion, recorded, camera, guessed, method, flags, doubts);
    requireKnownFocalLength(estimate.projection, estimate.covariance);
    writeNewMatrix(estimate.projection.K, cameraMatrix);
    writeMatrix(estimate.projection.R, R_cam2gripper);
    if (covariance.needed())
        writeMatrix(estimate.covariance, covariance);
    return estimate.rms;
}

double calibrateHandEyeTranslations(InputArrayOfArrays R_gripper2base, InputArrayOfArrays t_gripper2base,
                                    InputArrayOfArrays imagePoints, InputOutputArray cameraMatrix,
                                    InputArray distCoeffs, OutputArray R_cam2gripper, OutputArray covariance,
                                    TranslationsMethod method, int flags, double orientationTolerance)
{
    CV_TRACE_FUNCTION();
    ViewDoubts doubts = {largeImageNoise, {}};
    const double rms = translationsClosedForm(R_gripper2base, t_gripper2base, imagePoints, cameraMatrix, distCoeffs,
                                              R_cam2gripper, covariance, method, flags, orientationTolerance, doubts);
    warnOfRejectedViews("calibrateHandEyeTranslations", doubts);
    return rms;
}

}} // namespace cv::active_handeye
