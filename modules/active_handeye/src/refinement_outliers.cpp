// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// Wrong matches, views whose pose is wrong, and the first noise levels.
#include "precomp.hpp"
#include "distributions.hpp"
#include "decompositions.hpp"
#include "refinement.hpp"
#include "view_pose.hpp"

namespace cv { namespace active_handeye {

using Eigen::VectorXd;

typedef Eigen::Matrix<double, 6, 6> Matrix6d;

static double median(std::vector<double> values)
{
    if (values.empty())
        return 0;
    std::nth_element(values.begin(), values.begin() + values.size() / 2, values.end());
    return values[values.size() / 2];
}

//! Points that two views see well: without them there is nothing to refine.
void HandEyeRefinement::requireTracks() const
{
    int used = 0, equations = 0;
    for (int track = 0; track < tracks_.count(); ++track)
        if (tracks_.isUsed(track))
        {
            ++used;
            equations += 2 * tracks_.usedIn(track) - (tracks_.isKnown(track) ? 0 : 3);
        }
    const int needed = int(problem_.unknowns.calibration.cols());
    if (used < 2 || equations <= needed)
        CV_Error(
            Error::StsNoConv,
            cv::format(
                "imagePoints: too few points agree with the poses; needed 2 or more points with more than %d equations (2 "
                "per image point - 3 per scene point), given %d such points with %d equations out of %d",
                needed, used, equations, int(measurements_.imagePoints[0].size())));
}

static const double medianOfRayleigh = 1.1774; // of the length of two coordinates of standard deviation 1
static const double wildError = 6;             // sigmas

std::vector<double> HandEyeRefinement::usedErrors() const
{
    const std::vector<double> errors = normalizedErrors(tracks_, problem_.state);
    std::vector<double> used;
    for (size_t i = 0; i < errors.size(); ++i)
        if (tracks_.observations[i].used)
            used.push_back(errors[i]);
    return used;
}

void HandEyeRefinement::findScene()
{
    CalibrationState& state = problem_.state;
    for (PointObservation& o : tracks_.observations)
        o.used = !isDoubted(o.view); // its pose is found from what the others see
    triangulate(tracks_, std::numeric_limits<double>::infinity(), state);
    double scale = median(usedErrors()) / medianOfRayleigh;
    triangulate(tracks_, wildError * scale, state);
    for (PointObservation& o : tracks_.observations)
        o.used = true;

    AlignedVector<Pose> poses = state.gripper2base;
    if (problem_.unknowns.poses[0] != POSE_EXACT)
        for (int view = 0; view < int(poses.size()); ++view)
            poses[view] = resectView(tracks_, state, view, scale);
    state.gripper2base.swap(poses);
    triangulate(tracks_, wildError * scale, state);
    if (problem_.unknowns.object)
        placeObject(tracks_, state);
    const std::vector<double> errors = normalizedErrors(tracks_, state);
    scale = std::max(median(errors) / medianOfRayleigh, 1e-9);
    leaveOutUnseenViews(errors, wildError * scale);
    leaveOut(wildError * scale);
    setUnknowns();
    requireTracks();

    firstNoiseLevels(scale);
}

//! Typical corrections of the poses, and views whose correction is far from typical: these are doubted until a fit says otherwise.
void HandEyeRefinement::firstNoiseLevels(double scale)
{
    const int views = int(measurements_.gripper2base.size());
    std::vector<double> turns, shifts;
    for (int view = 0; view < views; ++view)
    {
        const Vector6d correction = problem_.correction(view);
        turns.push_back(correction.head<3>().norm());
        shifts.push_back(correction.tail<3>().norm());
    }
    const double angle = scale / problem_.state.calibration.camera.K(0, 0), medianOfMaxwell = 1.538;
    const double turn = std::max(median(turns) / medianOfMaxwell, angle),
                 shift = std::max(median(shifts) / medianOfMaxwell, angle * workingDistance());
    const double first[] = {scale, 1, shift, turn};
    const double given[] = {params_.pointSigma, params_.stripeSigma, params_.robotTranslationSigma,
                            params_.robotRotationSigma};
    double levels[NOISE_COMPONENTS];
    for (int k = 0; k < NOISE_COMPONENTS; ++k)
        levels[k] = given[k] >= 0 ? given[k] : first[k];
    problem_.noise = NoiseLevels{levels[0], levels[1], levels[2], levels[3]};

    const double farFromTypical = 15;
    for (int view = 0; view < views; ++view)
        if (problem_.unknowns.poses[view] == POSE_PRIOR && int(doubtedViews_.size()) < views / 3 && !isDoubted(view) &&
            (turns[view] > farFromTypical * turn || shifts[view] > farFromTypical * shift))
        {
            problem_.unknowns.poses[view] = POSE_FREE;
            doubtedViews_.push_back(view);
        }
}

bool HandEyeRefinement::isDoubted(int view) const
{
    return std::count(doubtedViews_.begin(), doubtedViews_.end(), view) > 0;
}

//! Views that most of their image points contradict, whatever their pose.
void HandEyeRefinement::leaveOutUnseenViews(const std::vector<double>& errors, double limit)
{
    const int views = int(measurements_.gripper2base.size());
    std::vector<int> seen(views), wrong(views);
    for (size_t i = 0; i < tracks_.observations.size(); ++i)
    {
        ++seen[tracks_.observations[i].view];
        wrong[tracks_.observations[i].view] += !(errors[i] <= limit);
    }
    for (int view = 0; view < views; ++view)
    {
        if (wrong[view] * 2 <= seen[view])
            continue;
        if (!isDoubted(view))
            doubtedViews_.push_back(view);
        if (problem_.unknowns.poses[view] == POSE_FREE)
            problem_.unknowns.poses[view] = POSE_PRIOR;
        culprits_.push_back(
            cv::format("view %d: %d of its %d image points contradict the other views; it is left out (a "
                       "wrong pose or a wrong image?)",
                       view, wrong[view], seen[view]));
        problem_.state.gripper2base[view] = measurements_.gripper2base[view];
    }
}

//! Uses the observations within the limit. Returns whether that changed anything.
bool HandEyeRefinement::leaveOut(double limit)
{
    const std::vector<double> errors = normalizedErrors(tracks_, problem_.state);
    bool changed = false;
    for (size_t i = 0; i < errors.size(); ++i)
    {
        PointObservation& o = tracks_.observations[i];
        const bool isLeftOut = isDoubted(o.view) && problem_.unknowns.poses[o.view] != POSE_FREE;
        const bool use = errors[i] <= limit && !isLeftOut;
        changed = changed || use != o.used;
        o.used = use;
    }
    return changed;
}

void HandEyeRefinement::fitWithoutWrongMatches()
{
    const int maxRounds = 4;
    for (int round = 0; round < maxRounds; ++round)
    {
        fit(1e-6);
        const bool changed = leaveOut(params_.rejectThreshold * problem_.noise.point);
        requireTracks();
        if (!changed)
            break;
    }
}

Matrix6d HandEyeRefinement::priorCovariance() const
{
    Vector6d variance;
    variance << Eigen::Vector3d::Constant(std::pow(problem_.noise.rotation, 2)),
        Eigen::Vector3d::Constant(std::pow(problem_.noise.translation, 2));
    return variance.asDiagonal();
}

Matrix6d HandEyeRefinement::poseCovariance(int view) const
{
    const int column = problem_.unknowns.poseColumn(view);
    return components_->covariance().block<6, 6>(column, column);
}

//! Squared length of a view's correction in units of its predicted covariance.
double HandEyeRefinement::viewStatistic(int view, const Matrix6d& predicted) const
{
    const Vector6d prior = priorCovariance().diagonal().cwiseSqrt();
    const Matrix6d scaled = prior.cwiseInverse().asDiagonal() * predicted * prior.cwiseInverse().asDiagonal();
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen = symmetricEigen<Eigen::MatrixXd>(scaled);
    const Vector6d along = eigen.eigenvectors().transpose() * problem_.correction(view).cwiseQuotient(prior);
    double sum = 0;
    for (int i = 0; i < 6; ++i)
        if (eigen.eigenvalues()(i) > 1e-3)
            sum += along(i) * along(i) / eigen.eigenvalues()(i);
    return sum;
}

//! Deviance were the pose of a view, which is free, the robot's noise about a shifted mean.
double HandEyeRefinement::devianceOfShift(int view) const
{
    const Eigen::LLT<Matrix6d> llt(Matrix6d(priorCovariance() + poseCovariance(view)));
    return components_->deviance() + 2 * Matrix6d(llt.matrixLLT()).diagonal().array().log().sum();
}

double HandEyeRefinement::robotRedundancy() const
{
    return components_->effectiveRedundancy(NOISE_TRANSLATION) + components_->effectiveRedundancy(NOISE_ROTATION);
}

/** P-value of the robot's noise as the reason of a view's correction, from the deviances of that reason and of a shift.

Each has the noise levels that suit it best, so that no level is held for known which the other views do not know. With one level alone the ratio r of the
likelihoods of n residuals is Fisher's test: F = (r^(2/n) - 1) (n - 6) / 6.
*/
double HandEyeRefinement::beliefInNoise(double devianceOfNoise, double redundancy, double devianceOfShift) const
{
    const double ratio = devianceOfNoise - devianceOfShift;
    if (isLevelGiven(NOISE_TRANSLATION) && isLevelGiven(NOISE_ROTATION))
        return chiSquareTail(ratio, 6);
    const double rest = std::max(redundancy - 6, 1.);
    return fTail(std::max(std::expm1(ratio / (rest + 6)), 0.) * rest / 6, 6, rest);
}

//! Whether the views that are believed know the robot's noise, so that the correction of another can be held against it.
bool HandEyeRefinement::areRobotLevelsKnown() const
{
    const double enough = 6;
    const int levels[] = {NOISE_TRANSLATION, NOISE_ROTATION};
    return std::all_of(levels, levels + 2,
                       [&](int k) { return isLevelGiven(k) || components_->effectiveRedundancy(k) >= enough; });
}

//! P-value of the correction of a view whose pose is free, were it the robot's noise at its present levels.
double HandEyeRefinement::beliefInView(int view) const
{
    const double statistic = viewStatistic(view, priorCovariance() + poseCovariance(view));
    return isLevelGiven(NOISE_ROTATION) ? chiSquareTail(statistic, 6)
                                        : fTail(statistic / 6, 6, std::max(robotRedundancy(), 1.));
}

//! Believes a view, whose pose is free, if the robot's noise explains its correction after all. Returns whether it does.
bool HandEyeRefinement::rehabilitate(int view, double level)
{
    if (beliefInView(view) < level && areRobotLevelsKnown())
        return false;
    const double shifted = devianceOfShift(view);
    const CalibrationState state = problem_.state;
    const NoiseLevels noise = problem_.noise;
    problem_.unknowns.poses[view] = POSE_PRIOR;
    fit(1e-6);
    if (beliefInNoise(components_->deviance(), robotRedundancy(), shifted) >= level)
        return true;
    problem_.unknowns.poses[view] = POSE_FREE;
    problem_.state = state;
    problem_.noise = noise;
    fit(1e-6);
    return false;
}

//! Believes a view again whose correction the robot's noise explains after all. Returns whether there was one.
bool HandEyeRefinement::rehabilitateView(double level)
{
    for (size_t i = 0; i < doubtedViews_.size(); ++i)
        if (problem_.unknowns.poses[doubtedViews_[i]] == POSE_FREE && rehabilitate(doubtedViews_[i], level))
        {
            doubtedViews_.erase(doubtedViews_.begin() + i);
            return true;
        }
    return false;
}

//! Frees the pose of a view whose correction the robot's noise does not explain, one at a time. Returns whether that changed
//! anything.
bool HandEyeRefinement::doubtViews()
{
    const int views = int(measurements_.gripper2base.size());
    const double level = 1e-3 / views;
    const std::vector<int> doubtedBefore = doubtedViews_;
    while (rehabilitateView(level))
    {
    }
    while (int(doubtedViews_.size()) < views / 3)
    {
        int worst = -1;
        double largest = 0;
        for (int view = 0; view < views; ++view)
            if (problem_.unknowns.poses[view] == POSE_PRIOR)
            {
                const double statistic = viewStatistic(view, priorCovariance() - poseCovariance(view));
                if (statistic > largest)
                    largest = statistic, worst = view;
            }
        if (worst < 0 || chiSquareTail(largest, 6) > level)
            break;
        const double deviance = components_->deviance(), redundancy = robotRedundancy();
        problem_.unknowns.poses[worst] = POSE_FREE;
        fit(1e-6);
        const bool isBelieved = beliefInNoise(deviance, redundancy, devianceOfShift(worst)) > level;
        if (isBelieved)
            problem_.unknowns.poses[worst] = POSE_PRIOR;
        else
        {
            doubtedViews_.push_back(worst);
            leaveOut(params_.rejectThreshold * problem_.noise.point);
            requireTracks();
        }
        fit(1e-6);
        if (isBelieved)
            break;
    }
    return doubtedViews_ != doubtedBefore;
}

}} // namespace cv::active_handeye
