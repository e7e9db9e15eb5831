// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// Normal equations with the points eliminated against the same from one dense Jacobian.
#include "dense_model.hpp"

#include "opencv2/core/utility.hpp"

namespace opencv_test { namespace {

//! Schur complement over the free points.
DataTerm eliminated(const DenseModel& model, const MatrixXd& J, const VectorXd& errors)
{
    DataTerm term;
    const int n = model.reduced(), m = 3 * model.free();
    const MatrixXd H = J.transpose() * J;
    const VectorXd b = J.transpose() * errors;
    MatrixXd A = H.bottomRightCorner(m, m).inverse();
    term.JtJ = H.topLeftCorner(n, n) - H.topRightCorner(n, m) * A * H.bottomLeftCorner(m, n);
    term.Jtr = b.head(n) - H.topRightCorner(n, m) * A * b.tail(m);
    term.squares = errors.squaredNorm() - b.tail(m).dot(A * b.tail(m));
    term.redundancy = int(errors.size()) - m;
    return term;
}

//! Entries in units of the geometric mean of their diagonal elements.
void expectSameTerm(const DataTerm& expected, const DataTerm& term, double tolerance)
{
    ASSERT_EQ(expected.JtJ.rows(), term.JtJ.rows());
    ASSERT_EQ(expected.JtJ.cols(), term.JtJ.cols());
    const VectorXd scale = expected.JtJ.diagonal().cwiseMax(1e-6 * expected.JtJ.diagonal().maxCoeff()).cwiseSqrt().cwiseInverse();
    const MatrixXd difference = scale.asDiagonal() * (term.JtJ - expected.JtJ) * scale.asDiagonal();
    int row, column;
    EXPECT_LE(difference.cwiseAbs().maxCoeff(&row, &column), tolerance) << "at (" << row << ", " << column << ")";
    EXPECT_LE((term.JtJ - term.JtJ.transpose()).norm(), 1e-14 * term.JtJ.norm());
    const double length = std::sqrt(expected.squares);
    EXPECT_LE((term.Jtr - expected.Jtr).cwiseProduct(scale).cwiseAbs().maxCoeff(&row), tolerance * length) << "Jtr at " << row;
    EXPECT_NEAR(expected.squares, term.squares, tolerance * expected.squares);
    EXPECT_EQ(expected.redundancy, term.redundancy);
}

void expectDenseEquations(RefineProblem& problem, double tolerance = 1e-7)
{
    problem.linearizeData();
    const DenseModel model(problem);
    expectSameTerm(eliminated(model, model.byPoints, model.pointErrors), problem.points(), tolerance);
    if (problem.unknowns.surfaces == 0)
        return;
    DataTerm stripes;
    const MatrixXd J = model.byStripes.leftCols(model.reduced());
    stripes.JtJ = J.transpose() * J;
    stripes.Jtr = J.transpose() * model.stripeErrors;
    stripes.squares = model.stripeErrors.squaredNorm();
    stripes.redundancy = int(model.stripeErrors.size());
    expectSameTerm(stripes, problem.stripes(), tolerance);
}

TEST(ActiveHandEye_NormalEquations, of_free_points)
{
    SmallProblem small;
    expectDenseEquations(small.problem);
}

TEST(ActiveHandEye_NormalEquations, of_known_points_alone)
{
    Contents contents;
    contents.freePoints = 0;
    contents.knownPoints = 8;
    SmallProblem small(contents);
    expectDenseEquations(small.problem);
}

TEST(ActiveHandEye_NormalEquations, of_everything_at_once)
{
    Contents contents;
    contents.knownPoints = 4;
    contents.surfaces = 3;
    contents.sameSigmas = false;
    SmallProblem small(contents);
    RefineUnknowns& unknowns = small.problem.unknowns;
    unknowns.poses = {POSE_PRIOR, POSE_EXACT, POSE_FREE, POSE_PRIOR, POSE_PRIOR, POSE_EXACT};
    MatrixXd B = MatrixXd::Zero(CALIBRATION_COLUMNS, 14); // fx and fy together, p1, p2, k3 and one direction of t fixed
    B(COLUMN_FX, 0) = 1;
    B(COLUMN_FY, 0) = 1.005;
    const int free[] = {COLUMN_CX, COLUMN_CY, COLUMN_SKEW, COLUMN_DISTORTION, COLUMN_DISTORTION + 1, COLUMN_ROTATION, COLUMN_ROTATION + 1,
                        COLUMN_ROTATION + 2};
    for (int i = 0; i < 8; ++i)
        B(free[i], 1 + i) = 1;
    B.block<3, 2>(COLUMN_TRANSLATION, 9) = tangentBasis(Vector3d(1, 2, 3).normalized());
    B.bottomRightCorner<3, 3>().setIdentity();
    unknowns.calibration = B;
    small.tracks().observations[3].used = false;
    const int shortTrack = small.tracks().first[5];
    for (int i = shortTrack; i < small.tracks().first[6] - 1; ++i) // one view left: the point is not used
        small.tracks().observations[i].used = false;
    small.segments()[4].used = false;
    EXPECT_EQ(14 + 6 + 9 + 4 * 6, unknowns.count());
    expectDenseEquations(small.problem);
}

TEST(ActiveHandEye_NormalEquations, unknowns_have_columns_in_order)
{
    RefineUnknowns unknowns;
    unknowns.calibration = MatrixXd::Identity(CALIBRATION_COLUMNS, 7);
    unknowns.poses = {POSE_EXACT, POSE_PRIOR, POSE_EXACT, POSE_FREE};
    EXPECT_EQ(7 + 12, unknowns.count());
    EXPECT_EQ(-1, unknowns.poseColumn(0));
    EXPECT_EQ(7, unknowns.poseColumn(1));
    EXPECT_EQ(-1, unknowns.poseColumn(2));
    EXPECT_EQ(13, unknowns.poseColumn(3));
    unknowns.object = true;
    unknowns.surfaces = 2;
    EXPECT_EQ(7, unknowns.objectColumn());
    EXPECT_EQ(13, unknowns.surfaceColumn(0));
    EXPECT_EQ(16, unknowns.surfaceColumn(1));
    EXPECT_EQ(19, unknowns.poseColumn(1));
    EXPECT_EQ(7 + 6 + 6 + 12, unknowns.count());
}

TEST(ActiveHandEye_NormalEquations, priors_and_weights_are_added)
{
    Contents contents;
    contents.surfaces = 2;
    SmallProblem small(contents);
    RefineProblem& problem = small.problem;
    problem.unknowns.poses[2] = POSE_FREE;
    problem.unknowns.poses[4] = POSE_EXACT;
    problem.noise = NoiseLevels{0.2, 0.05, 3e-4, 2e-4};
    MatrixXd JtJ;
    VectorXd Jtr;
    problem.linearize(JtJ, Jtr);
    MatrixXd expected = problem.points().JtJ / (0.2 * 0.2) + problem.stripes().JtJ / (0.05 * 0.05);
    VectorXd pull = problem.points().Jtr / (0.2 * 0.2) + problem.stripes().Jtr / (0.05 * 0.05);
    for (int view : {0, 1, 3, 5})
        for (int i = 0; i < 6; ++i)
        {
            const int column = problem.unknowns.poseColumn(view) + i;
            const double sigma = i < 3 ? 2e-4 : 3e-4;
            expected(column, column) += 1 / (sigma * sigma);
            pull(column) += problem.correction(view)(i) / (sigma * sigma);
        }
    EXPECT_LE((JtJ - expected).cwiseAbs().maxCoeff(), 1e-12 * expected.cwiseAbs().maxCoeff());
    EXPECT_LE((Jtr - pull).cwiseAbs().maxCoeff(), 1e-9 * pull.cwiseAbs().maxCoeff());
}

//! More than 4000 tracks are added in parts: the sum is that of its halves, and the same bits on any number of threads.
TEST(ActiveHandEye_NormalEquations, many_points_in_parts)
{
    Contents contents;
    contents.freePoints = 4500;
    SmallProblem all(contents), firstHalf(contents), secondHalf(contents);
    for (int track = 0; track < all.tracks().count(); ++track)
        for (int i = all.tracks().first[track]; i < all.tracks().first[track + 1]; ++i)
            (track % 2 ? firstHalf : secondHalf).tracks().observations[i].used = false;
    const int threads = cv::getNumThreads();
    for (SmallProblem* one : {&all, &firstHalf, &secondHalf})
        one->problem.linearizeData();
    const DataTerm parallel = all.problem.points();
    const DataTerm &a = firstHalf.problem.points(), &b = secondHalf.problem.points();
    DataTerm sum;
    sum.JtJ = a.JtJ + b.JtJ;
    sum.Jtr = a.Jtr + b.Jtr;
    sum.squares = a.squares + b.squares;
    sum.redundancy = a.redundancy + b.redundancy;
    expectSameTerm(sum, parallel, 1e-12);
    cv::setNumThreads(1);
    all.problem.linearizeData();
    cv::setNumThreads(threads);
    EXPECT_EQ(parallel.JtJ, all.problem.points().JtJ);
    EXPECT_EQ(parallel.Jtr, all.problem.points().Jtr);
    EXPECT_EQ(parallel.squares, all.problem.points().squares);
}

}} // namespace opencv_test
