// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "refinement.hpp"
#include "distributions.hpp"

namespace cv { namespace active_handeye {

using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;

static CalibrationState stateOf(const HandEyeCalibration& calibration, const AlignedVector<Pose>& gripper2base)
{
    CalibrationState state;
    state.calibration = calibration;
    state.gripper2base = gripper2base;
    return state;
}

HandEyeRefinement::HandEyeRefinement(const RefineMeasurements& measurements, const RefineParams& params,
                                     const HandEyeCalibration& start, const std::vector<int>& doubted)
    : measurements_(measurements), params_(params), turns_(measurements.gripper2base), start_(start),
      tracks_(measurements.imagePoints, measurements.pointSigmas, measurements.objectPoints),
      problem_(tracks_, segments_, measurements.gripper2base, stateOf(start, measurements.gripper2base),
               params.huberThreshold),
      lensModel_(params.lensModel)
{
    if (lensModel_ == LENS_AUTO)
        lensModel_ = params.flags & REFINE_FIX_K ? LENS_FIXED : LENS_K1_K2;
    const bool isExact = params.robotTranslationSigma == 0;
    problem_.unknowns.poses.assign(measurements.gripper2base.size(), isExact ? POSE_EXACT : POSE_PRIOR);
    for (int view : doubted)
        if (!isExact)
        {
            problem_.unknowns.poses[view] = POSE_FREE;
            doubtedViews_.push_back(view);
        }
    problem_.unknowns.object = tracks_.anyKnown();
}

double HandEyeRefinement::misfit() const
{
    return Vector2d(rms(), robotNoiseInImage()).norm();
}

double HandEyeRefinement::robotNoiseInImage() const
{
    const bool isExact = params_.robotTranslationSigma == 0;
    const double angle =
        isExact ? 0 : Vector2d(problem_.noise.rotation, problem_.noise.translation / workingDistance()).norm();
    return calibration().camera.K(0, 0) * angle;
}

int lensCoefficients(int lensModel)
{
    const int counts[LENS_MODELS] = {0, 1, 2, 4, 5};
    return counts[lensModel];
}

//! The directions in which the calibration may move.
void HandEyeRefinement::setUnknowns(bool isAspectFree)
{
    typedef Eigen::Matrix<double, CALIBRATION_COLUMNS, 1> Column;
    AlignedVector<Column> columns;
    const auto free = [&](int column) { columns.push_back(Column::Unit(column)); };
    if (!(params_.flags & REFINE_FIX_K))
    {
        const Eigen::Matrix3d& K = start_.camera.K;
        if (params_.flags & REFINE_FIX_ASPECT && !isAspectFree)
            columns.push_back(Column::Unit(COLUMN_FX) + K(1, 1) / K(0, 0) * Column::Unit(COLUMN_FY));
        else
            free(COLUMN_FX), free(COLUMN_FY);
        free(COLUMN_CX);
        free(COLUMN_CY);
        if (params_.flags & REFINE_SKEW)
            free(COLUMN_SKEW);
    }
    for (int i = 0; i < lensCoefficients(lensModel_); ++i)
        free(COLUMN_DISTORTION + i);
    for (int i = 0; i < 3 && !(params_.flags & REFINE_FIX_ROTATION); ++i)
        free(COLUMN_ROTATION + i);
    for (int i = 0; i < turns_.observed.cols() && !(params_.flags & REFINE_FIX_TRANSLATION); ++i)
    {
        Column direction = Column::Zero();
        if (turns_.observed.cols() == 3)
            direction(COLUMN_TRANSLATION + i) = 1;
        else
            direction.segment<3>(COLUMN_TRANSLATION) = turns_.observed.col(i);
        columns.push_back(direction);
    }
    for (int column = COLUMN_NORMAL;
         useStripes_ && column <= COLUMN_OFFSET && !(params_.flags & REFINE_FIX_LIGHT_PLANE); ++column)
        free(column);
    problem_.unknowns.calibration.resize(CALIBRATION_COLUMNS, columns.size());
    for (size_t i = 0; i < columns.size(); ++i)
        problem_.unknowns.calibration.col(i) = columns[i];
    problem_.unknowns.surfaces = useStripes_ ? int(problem_.state.surfaces.size()) : 0;
}

bool HandEyeRefinement::isLevelGiven(int component) const
{
    const double given[] = {params_.pointSigma, params_.stripeSigma, params_.robotTranslationSigma,
                            params_.robotRotationSigma};
    return given[component] >= 0;
}

//! Least squares and noise levels in turn, until neither changes.
void HandEyeRefinement::fit(double tolerance)
{
    const bool isFixed[] = {isLevelGiven(0), isLevelGiven(1), isLevelGiven(2), isLevelGiven(3)};
    const int maxRounds = 12;
    const double rounding = 1e-6,
                 negligible = 1e-4;    // px; of the robot's noise: sums of squares may not differ too much
    const double smallestShare = 1e-3; // of what image noise alone would explain: below it robot noise does not matter
    setUnknowns();
    for (int round = 0; round < maxRounds; ++round)
    {
        problem_.updateClipping();
        const LeastSquaresSummary solution = solveLeastSquares(problem_, params_.maxIterations, tolerance);
        iterations_ += solution.iterations;
        converged_ = solution.converged;
        if (problem_.updateClipping())
            problem_.linearizeData(); // else as the solver left it
        const double angle = problem_.noise.point / problem_.state.calibration.camera.K(0, 0);
        const double smallest = std::max(rounding, negligible * robotNoiseInImage());
        const double floors[] = {smallest, smallest, smallestShare * angle * workingDistance(), smallestShare * angle};
        components_.reset(new VarianceComponents(problem_, isFixed, floors));
        const double change = components_->estimate(), farStep = 1; // standard deviation: the solver was stuck before
        converged_ = converged_ && components_->squaredStep() < farStep * farStep;
        problem_.noise = components_->levels();
        if (change < 1e-3)
            break;
    }
}

void HandEyeRefinement::fitPoints()
{
    fitWithoutWrongMatches();
    const bool otherViews = doubtViews(), otherLens = chooseLens();
    if (otherViews || otherLens)
    {
        fitWithoutWrongMatches();
        doubtViews();
    }
    fit(1e-12);
    testLens();
    testAspect();
}

double HandEyeRefinement::workingDistance() const
{
    const CameraViews views = problem_.state.views();
    std::vector<double> depths;
    for (int track = 0; track < tracks_.count(); ++track)
        if (tracks_.isUsed(track))
            for (int i = tracks_.first[track]; i < tracks_.first[track + 1]; ++i)
                if (tracks_.observations[i].used)
                    depths.push_back(views[tracks_.observations[i].view].toCamera(problem_.state.points[track]).z());
    std::nth_element(depths.begin(), depths.begin() + depths.size() / 2, depths.end());
    return depths[depths.size() / 2];
}

double HandEyeRefinement::rms() const
{
    const std::vector<double> errors = normalizedErrors(tracks_, problem_.state);
    double squares = 0;
    int used = 0;
    for (int track = 0; track < tracks_.count(); ++track)
        for (int i = tracks_.first[track]; tracks_.isUsed(track) && i < tracks_.first[track + 1]; ++i)
            if (tracks_.observations[i].used)
            {
                squares += std::pow(errors[i] / tracks_.observations[i].inverseSigma, 2);
                ++used;
            }
    return std::sqrt(squares / std::max(used, 1));
}

}} // namespace cv::active_handeye
