// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// Noise levels against the restricted likelihood, written down for one dense linear model.
#include "dense_model.hpp"

#include "../src/decompositions.hpp"
#include "../src/noise_levels.hpp"

namespace opencv_test { namespace {

const bool allFree[] = {false, false, false, false};
const double noFloors[] = {1e-12, 1e-12, 1e-12, 1e-12};

/** y = X u + noise, the variance of each row being that of its component. Restricted likelihood of the variances:

l = -(log |V| + log |X^T V^-1 X| + y^T P y) / 2,  P = V^-1 - V^-1 X (X^T V^-1 X)^-1 X^T V^-1.
*/
class RestrictedLikelihood
{
public:
    explicit RestrictedLikelihood(const RefineProblem& problem)
    {
        const DenseModel model(problem);
        VectorXd corrections;
        std::vector<int> columns;
        std::vector<bool> isRotation;
        model.priors(corrections, columns, isRotation);
        const int m = int(model.pointErrors.size()), s = int(model.stripeErrors.size()), p = int(corrections.size());
        y_.resize(m + s + p);
        y_ << -model.pointErrors, -model.stripeErrors, -corrections;
        X_ = MatrixXd::Zero(m + s + p, model.size());
        X_.topRows(m) = model.byPoints;
        X_.middleRows(m, s) = model.byStripes;
        component_.assign(m, NOISE_POINT);
        component_.insert(component_.end(), s, NOISE_STRIPE);
        for (int i = 0; i < p; ++i)
        {
            X_(m + s + i, columns[i]) = 1;
            component_.push_back(isRotation[i] ? NOISE_ROTATION : NOISE_TRANSLATION);
        }
        for (int i = 0; i < X_.cols(); ++i) // does not change the derivatives of l
            X_.col(i) /= X_.col(i).norm();
    }

    double value(const Vector4d& logVariances) const
    {
        const VectorXd weight = weights(logVariances);
        const MatrixXd WX = weight.asDiagonal() * X_;
        const MatrixXd H = X_.transpose() * WX;
        const VectorXd b = WX.transpose() * y_;
        const double squares = y_.dot(weight.cwiseProduct(y_)) - b.dot(solveSymmetric(H, b));
        return -0.5 * (-weight.array().log().sum() + H.ldlt().vectorD().array().log().sum() + squares);
    }

    Vector4d score(const Vector4d& logVariances) const
    {
        const MatrixXd slope =
            differentiate([&](const VectorXd& step) { return VectorXd::Constant(1, value(logVariances + step)); },
                          VectorXd::Constant(4, 1e-3));
        return slope.transpose();
    }

    //! tr(P V_k P V_l) / 2, V_k the part of V that component k makes.
    Eigen::Matrix4d information(const Vector4d& logVariances) const
    {
        const VectorXd weight = weights(logVariances);
        const MatrixXd WX = weight.asDiagonal() * X_;
        const MatrixXd W = weight.asDiagonal();
        const MatrixXd P = W - WX * solveSymmetric<MatrixXd>(X_.transpose() * WX, WX.transpose());
        Eigen::Matrix4d result = Eigen::Matrix4d::Zero();
        for (int i = 0; i < P.rows(); ++i)
            for (int j = 0; j < P.cols(); ++j)
                result(component_[i], component_[j]) += 0.5 * P(i, j) * P(i, j) / (weight(i) * weight(j));
        return result;
    }

private:
    VectorXd weights(const Vector4d& logVariances) const
    {
        VectorXd result(y_.size());
        for (int i = 0; i < y_.size(); ++i)
            result(i) = std::exp(-logVariances(component_[i]));
        return result;
    }

    VectorXd y_;
    MatrixXd X_;
    std::vector<int> component_;
};

Vector4d logVariances(const NoiseLevels& levels)
{
    return 2 * Vector4d(levels.point, levels.stripe, levels.translation, levels.rotation).array().log().matrix();
}

Vector4d scoreOf(const VarianceComponents& components)
{
    const Vector4d variances = logVariances(components.levels()).array().exp();
    Vector4d score = Vector4d::Zero();
    for (int k = 0; k < NOISE_COMPONENTS; ++k)
        if (components.isPresent(k))
            score(k) = 0.5 * (components.sumOfSquares(k) / variances(k) - components.effectiveRedundancy(k));
    return score;
}

Contents everything()
{
    Contents contents;
    contents.knownPoints = 5;
    contents.surfaces = 3;
    contents.sameSigmas = false;
    contents.views = 8;
    contents.translationNoise = contents.rotationNoise = 5e-4;
    return contents;
}

//! Levels that are wrong, one way and the other.
void startAway(RefineProblem& problem)
{
    const NoiseLevels& n = problem.noise;
    problem.noise = NoiseLevels{1.4 * n.point, 0.7 * n.stripe, 0.6 * n.translation, 1.5 * n.rotation};
    problem.unknowns.poses[1] = POSE_FREE;
    problem.unknowns.poses[3] = POSE_EXACT;
    problem.linearizeData();
}

TEST(ActiveHandEye_NoiseLevels, score_and_information_are_those_of_the_restricted_likelihood)
{
    SmallProblem small(everything());
    startAway(small.problem);
    const VarianceComponents components(small.problem, allFree, noFloors);
    const RestrictedLikelihood likelihood(small.problem);
    const Vector4d at = logVariances(small.problem.noise);
    const Eigen::Matrix4d information = likelihood.information(at);
    const Vector4d difference = scoreOf(components) - likelihood.score(at);
    for (int k = 0; k < NOISE_COMPONENTS; ++k)
        EXPECT_LE(std::abs(difference(k)), 1e-4 * std::sqrt(information(k, k))) << k;
    const Vector4d scale = information.diagonal().cwiseSqrt().cwiseInverse();
    const Eigen::Matrix4d found = components.logVarianceCovariance().inverse();
    EXPECT_LE((scale.asDiagonal() * (found - information) * scale.asDiagonal()).cwiseAbs().maxCoeff(), 1e-4)
        << found << "\nexpected\n"
        << information;
}

TEST(ActiveHandEye_NoiseLevels, differences_of_the_deviance_are_those_of_the_restricted_likelihood)
{
    SmallProblem small(everything());
    startAway(small.problem);
    const NoiseLevels first = small.problem.noise;
    const VarianceComponents components(small.problem, allFree, noFloors);
    const RestrictedLikelihood likelihood(small.problem);
    for (const NoiseLevels& levels :
         {NoiseLevels{2 * first.point, first.stripe, first.translation, first.rotation},
          NoiseLevels{first.point, 0.5 * first.stripe, first.translation, first.rotation},
          NoiseLevels{first.point, first.stripe, 0.01 * first.translation, 3 * first.rotation}})
    {
        small.problem.noise = levels;
        const double change = VarianceComponents(small.problem, allFree, noFloors).deviance() - components.deviance();
        const double expected = -2 * (likelihood.value(logVariances(levels)) - likelihood.value(logVariances(first)));
        EXPECT_NEAR(expected, change, 1e-3 * std::abs(expected));
    }
}

TEST(ActiveHandEye_NoiseLevels, the_estimate_is_where_the_restricted_likelihood_is_largest)
{
    SmallProblem small(everything());
    startAway(small.problem);
    const NoiseLevels start = small.problem.noise;
    VarianceComponents components(small.problem, allFree, noFloors);
    const double change = components.estimate();
    const RestrictedLikelihood likelihood(small.problem);
    const Vector4d best = logVariances(components.levels()), from = logVariances(start);
    const Vector4d score = likelihood.score(best);
    const Eigen::Matrix4d information = likelihood.information(best);
    for (int k = 0; k < NOISE_COMPONENTS; ++k)
    {
        EXPECT_LE(std::abs(score(k)), 1e-3 * std::sqrt(information(k, k))) << k;
        for (double aside : {-0.1, 0.1})
            EXPECT_LT(likelihood.value(best + aside * Vector4d::Unit(k)), likelihood.value(best)) << k;
    }
    EXPECT_NEAR((best - from).cwiseAbs().maxCoeff() / 2, change, 1e-12);
}

TEST(ActiveHandEye_NoiseLevels, fixed_levels_stay_and_the_others_take_the_rest)
{
    SmallProblem small(everything());
    startAway(small.problem);
    const NoiseLevels start = small.problem.noise;
    const bool isFixed[] = {true, false, false, true};
    VarianceComponents components(small.problem, isFixed, noFloors);
    components.estimate();
    EXPECT_EQ(start.point, components.levels().point);
    EXPECT_EQ(start.rotation, components.levels().rotation);
    const RestrictedLikelihood likelihood(small.problem);
    const Vector4d best = logVariances(components.levels());
    const Eigen::Matrix4d information = likelihood.information(best);
    Eigen::Matrix4d covariance = Eigen::Matrix4d::Zero();
    covariance.block<2, 2>(1, 1) = information.block<2, 2>(1, 1).inverse();
    EXPECT_LE((components.logVarianceCovariance() - covariance).cwiseAbs().maxCoeff(),
              1e-4 * covariance.cwiseAbs().maxCoeff());
    for (int k : {1, 2})
        EXPECT_LE(std::abs(likelihood.score(best)(k)), 1e-3 * std::sqrt(information(k, k))) << k;
}

TEST(ActiveHandEye_NoiseLevels, a_level_that_wants_to_be_zero_stays_at_its_floor)
{
    Contents contents;
    contents.translationNoise = 0;
    SmallProblem small(contents, 7);
    small.problem.noise.translation = 1e-4;
    small.problem.linearizeData();
    const double floors[] = {1e-12, 1e-12, 2e-6, 1e-12};
    VarianceComponents components(small.problem, allFree, floors);
    components.estimate();
    EXPECT_NEAR(2e-6, components.levels().translation, 1e-18);
    EXPECT_LT(RestrictedLikelihood(small.problem).score(logVariances(components.levels()))(NOISE_TRANSLATION), 0);
    EXPECT_EQ(0, components.logVarianceCovariance()(NOISE_TRANSLATION, NOISE_TRANSLATION));
    EXPECT_GT(components.logVarianceCovariance()(NOISE_POINT, NOISE_POINT), 0);
    EXPECT_FALSE(components.isPresent(NOISE_STRIPE));
}

TEST(ActiveHandEye_NoiseLevels, covariance_and_step_are_those_of_the_dense_model)
{
    SmallProblem small(everything());
    RefineProblem& problem = small.problem;
    problem.linearizeData();
    const VarianceComponents components(problem, allFree, noFloors);
    const DenseModel model(problem);
    const NoiseLevels& noise = problem.noise;
    MatrixXd H = model.byPoints.transpose() * model.byPoints / (noise.point * noise.point) +
                 model.byStripes.transpose() * model.byStripes / (noise.stripe * noise.stripe);
    VectorXd b = model.byPoints.transpose() * model.pointErrors / (noise.point * noise.point) +
                 model.byStripes.transpose() * model.stripeErrors / (noise.stripe * noise.stripe);
    VectorXd corrections;
    std::vector<int> columns;
    std::vector<bool> isRotation;
    model.priors(corrections, columns, isRotation);
    for (size_t i = 0; i < columns.size(); ++i)
    {
        const double variance = std::pow(isRotation[i] ? noise.rotation : noise.translation, 2);
        H(columns[i], columns[i]) += 1 / variance;
        b(columns[i]) += corrections(i) / variance;
    }
    const VectorXd scale = H.diagonal().cwiseSqrt().cwiseInverse();
    const MatrixXd inverse =
        scale.asDiagonal() * inverseOfSymmetric(scale.asDiagonal() * H * scale.asDiagonal()) * scale.asDiagonal();
    const int n = problem.unknowns.count();
    const VectorXd deviation = inverse.diagonal().head(n).cwiseSqrt(), units = deviation.cwiseInverse();
    const MatrixXd difference =
        units.asDiagonal() * (components.covariance() - inverse.topLeftCorner(n, n)) * units.asDiagonal();
    EXPECT_LE(difference.cwiseAbs().maxCoeff(), 1e-4);
    EXPECT_LE((components.step() + (inverse * b).head(n)).cwiseProduct(units).cwiseAbs().maxCoeff(), 1e-3);
}

}} // namespace opencv_test
