// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// Normal equations with the points eliminated against the same from one dense Jacobian.
#include "dense_model.hpp"

#include "opencv2/core/utility.hpp"

namespace opencv_test { namespace {

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
    const int free[] = {
        COLUMN_CX,       COLUMN_CY,           COLUMN_SKEW,        COLUMN_DISTORTION, COLUMN_DISTORTION + 1,
        COLUMN_ROTATION, COLUMN_ROTATION + 1, COLUMN_ROTATION + 2};
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
