// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "dense_model.hpp"

#include "../src/decompositions.hpp"

namespace opencv_test {

MatrixXd differentiate(const std::function<VectorXd(const VectorXd&)>& f, const VectorXd& steps)
{
    MatrixXd J(f(VectorXd::Zero(steps.size())).size(), steps.size());
    for (int i = 0; i < steps.size(); ++i)
    {
        const VectorXd h = steps(i) * VectorXd::Unit(steps.size(), i);
        J.col(i) = (8 * (f(h) - f(-h)) - (f(2 * h) - f(-2 * h))) / (12 * steps(i));
    }
    return J;
}

VectorXd calibrationSteps()
{
    CalibrationStep steps;
    steps << 0.1, 0.1, 0.1, 0.1, 0.1, 1e-3, 1e-2, 1e-4, 1e-4, 1e-1, Vector3d::Constant(1e-4), Vector3d::Constant(1e-4),
        1e-4, 1e-4, 1e-4;
    return steps;
}

DataTerm eliminated(const DenseModel& model, const MatrixXd& J, const VectorXd& errors)
{
    DataTerm term;
    const int n = model.reduced(), m = 3 * model.free();
    const MatrixXd H = J.transpose() * J;
    const VectorXd b = J.transpose() * errors;
    const MatrixXd A = inverseOfSymmetric(H.bottomRightCorner(m, m));
    term.JtJ = H.topLeftCorner(n, n) - H.topRightCorner(n, m) * A * H.bottomLeftCorner(m, n);
    term.Jtr = b.head(n) - H.topRightCorner(n, m) * A * b.tail(m);
    term.squares = errors.squaredNorm() - b.tail(m).dot(A * b.tail(m));
    term.redundancy = int(errors.size()) - m;
    return term;
}

void expectSameTerm(const DataTerm& expected, const DataTerm& term, double tolerance)
{
    ASSERT_EQ(expected.JtJ.rows(), term.JtJ.rows());
    ASSERT_EQ(expected.JtJ.cols(), term.JtJ.cols());
    const VectorXd scale =
        expected.JtJ.diagonal().cwiseMax(1e-6 * expected.JtJ.diagonal().maxCoeff()).cwiseSqrt().cwiseInverse();
    const MatrixXd difference = scale.asDiagonal() * (term.JtJ - expected.JtJ) * scale.asDiagonal();
    int row, column;
    EXPECT_LE(difference.cwiseAbs().maxCoeff(&row, &column), tolerance) << "at (" << row << ", " << column << ")";
    EXPECT_LE((term.JtJ - term.JtJ.transpose()).norm(), 1e-14 * term.JtJ.norm());
    const double length = std::sqrt(expected.squares);
    EXPECT_LE((term.Jtr - expected.Jtr).cwiseProduct(scale).cwiseAbs().maxCoeff(&row), tolerance * length)
        << "Jtr at " << row;
    EXPECT_NEAR(expected.squares, term.squares, tolerance * expected.squares);
    EXPECT_EQ(expected.redundancy, term.redundancy);
}

DenseModel::DenseModel(const RefineProblem& problem) : problem_(problem), reduced_(problem.unknowns.count())
{
    for (int track = 0; track < problem.tracks.count(); ++track)
        column_.push_back(problem.tracks.isUsed(track) && !problem.tracks.isKnown(track) ? 3 * free_++ : -1);
    const VectorXd zero = VectorXd::Zero(size());
    pointErrors = points(zero);
    stripeErrors = stripes(zero);
    byPoints = differentiate([this](const VectorXd& step) { return points(step); }, steps());
    byStripes = differentiate([this](const VectorXd& step) { return stripes(step); }, steps());
}

void DenseModel::priors(VectorXd& corrections, std::vector<int>& columns, std::vector<bool>& isRotation) const
{
    corrections.resize(0);
    for (int view = 0; view < int(problem_.reported.size()); ++view)
        for (int i = 0; i < 6 && problem_.unknowns.poses[view] == POSE_PRIOR; ++i)
        {
            corrections.conservativeResize(corrections.size() + 1);
            corrections(corrections.size() - 1) = problem_.correction(view)(i);
            columns.push_back(problem_.unknowns.poseColumn(view) + i);
            isRotation.push_back(i < 3);
        }
}

VectorXd DenseModel::steps() const
{
    VectorXd result = VectorXd::Constant(size(), 1e-4);
    const MatrixXd& B = problem_.unknowns.calibration;
    for (int i = 0; i < B.cols(); ++i) // a column may mix parameters: the shortest step of those it has
        result(i) = (calibrationSteps().array() / (B.col(i).array().abs() + 1e-12)).minCoeff();
    return result;
}

CalibrationState DenseModel::moved(const VectorXd& step) const
{
    const RefineUnknowns& unknowns = problem_.unknowns;
    CalibrationState state = problem_.state;
    const CalibrationStep calibrationStep = unknowns.calibration * step.head(unknowns.calibration.cols());
    state.calibration = state.calibration.moved(calibrationStep);
    if (unknowns.object)
        state.object2base = cv::active_handeye::moved(state.object2base, step.segment<6>(unknowns.objectColumn()));
    for (int s = 0; s < unknowns.surfaces; ++s)
        state.surfaces[s] += surfaceTangent(state.surfaces[s]) * step.segment<3>(unknowns.surfaceColumn(s));
    for (size_t view = 0; view < state.gripper2base.size(); ++view)
        if (unknowns.poses[view] != POSE_EXACT)
            state.gripper2base[view] =
                cv::active_handeye::moved(state.gripper2base[view], step.segment<6>(unknowns.poseColumn(int(view))));
    for (int track = 0; track < problem_.tracks.count(); ++track)
    {
        const Pose& object = state.object2base;
        if (problem_.tracks.isKnown(track))
            state.points[track] = object.R * problem_.tracks.known[track] + object.t;
        else if (column_[track] >= 0)
            state.points[track] += step.segment<3>(reduced_ + column_[track]);
    }
    return state;
}

VectorXd DenseModel::points(const VectorXd& step) const
{
    const CalibrationState state = moved(step);
    const CameraViews views = state.views();
    std::vector<double> errors;
    for (int track = 0; track < problem_.tracks.count(); ++track)
        for (int i = problem_.tracks.first[track]; i < problem_.tracks.first[track + 1]; ++i)
        {
            const PointObservation& o = problem_.tracks.observations[i];
            if (!o.used || !problem_.tracks.isUsed(track))
                continue;
            const Vector2d seen = state.calibration.camera.project(views[o.view].toCamera(state.points[track]));
            errors.push_back(o.inverseSigma * (seen.x() - o.pixel.x()));
            errors.push_back(o.inverseSigma * (seen.y() - o.pixel.y()));
        }
    return Eigen::Map<const VectorXd>(errors.data(), int(errors.size()));
}

VectorXd DenseModel::stripes(const VectorXd& step) const
{
    const CalibrationState state = moved(step);
    const CameraViews views = state.views();
    const HandEyeCalibration& c = state.calibration;
    const Eigen::Matrix2d toIdeal = problem_.state.calibration.camera.K.topLeftCorner<2, 2>().inverse();
    std::vector<double> errors;
    for (const StripeSegment& segment : problem_.segments)
        for (int end = 0; segment.used && end < 2; ++end)
        {
            const CameraView& view = views[segment.view];
            const Vector4d& surface = state.surfaces[segment.surface];
            const Vector3d w = view.R_base2cam * surface.head<3>();
            const double e = surface(3) - surface.head<3>().dot(view.centre);
            const Vector3d line = e * c.light.n - c.light.d * w;
            const double distance =
                line.dot(c.camera.ray(segment.ends[end])) / (toIdeal.transpose() * line.head<2>()).norm();
            errors.push_back(segment.inverseSigma * distance);
        }
    return Eigen::Map<const VectorXd>(errors.data(), int(errors.size()));
}

} // namespace opencv_test
