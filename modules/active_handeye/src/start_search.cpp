// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "closed_forms.hpp"
#include "motion_groups.hpp"
#include "observability.hpp"
#include "start_search.hpp"
#include "translations_problem.hpp"

#include <iterator>
#include <numeric>

namespace cv { namespace active_handeye {

namespace {

int translationsFlags(const RefineParams& params)
{
    int flags = params.flags & REFINE_FIX_K ? TRANSLATIONS_FIX_K : 0;
    if (!(params.flags & (REFINE_FIX_K | REFINE_SKEW)))
        flags |= params.flags & REFINE_FIX_ASPECT ? TRANSLATIONS_SQUARE_PIXELS : TRANSLATIONS_ZERO_SKEW;
    return flags;
}

void requireGiven(const Mat& argument, const char* name, const RefineParams& params, int flag, const char* flagName)
{
    if (argument.empty() && params.flags & flag)
        CV_Error(Error::StsBadArg, cv::format("%s: needed with %s, given none", name, flagName));
}

//! What no start can replace: translations for the scale, turns for t, and without turns translations in enough directions.
void requireMotion(const RefineMeasurements& measurements, const RefineParams& params, const TurnDirections& turns)
{
    const AlignedVector<Pose>& poses = measurements.gripper2base;
    const double smallestShare = 1e-4; // less is a robot's noise
    double farthest = 0;
    for (const Pose& pose : poses)
        farthest = std::max(farthest, (pose.t - poses[0].t).norm());
    const bool stayed = !(farthest > smallestShare * poses[0].t.norm());
    if (stayed && turns.observed.cols() == 0)
        CV_Error(Error::StsNoConv,
                 "R_gripper2base, t_gripper2base: the gripper did not move; needed views at different "
                 "places and of different orientations, given one pose in all views");
    if (stayed && measurements.objectPoints.empty())
        CV_Error(
            Error::StsNoConv,
            "t_gripper2base: the gripper only turned, which leaves the scale of t_cam2gripper open; needed views at "
            "different places, given one place: add a translation");
    const bool isKnown = (params.flags & REFINE_FIX_K) != 0;
    if (turns.observed.cols() == 0)
        GroupTranslations(poses, params.orientationTolerance)
            .requireDirections(isKnown ? 2 : 3, isKnown ? "two that are not parallel"
                                                        : "three that are not coplanar (two with REFINE_FIX_K)");
    if (turns.observed.cols() < 3 && !(params.flags & (REFINE_FIX_TRANSLATION | REFINE_ALLOW_PARTIAL)))
        CV_Error(Error::StsNoConv, "R_gripper2base: the turns do not determine t_cam2gripper: " +
                                       unobservedTranslation(turns.axis, turns) + ", or set REFINE_ALLOW_PARTIAL");
}

//! K and R from the pure translations, t from the turns, as far as the caller gives no start.
HandEyeCalibration startOf(const StartArguments& given, const RefineParams& params, const TurnDirections& turns,
                           ViewDoubts& doubts)
{
    Mat K = given.cameraMatrix, R = given.R_cam2gripper, t = given.t_cam2gripper.clone();
    if (K.empty() || R.empty())
    {
        Mat startK = K.clone(), startR;
        const int flags = K.empty() ? translationsFlags(params) : int(TRANSLATIONS_FIX_K);
        translationsClosedForm(given.R_gripper2base, given.t_gripper2base, given.imagePoints, startK, given.distCoeffs,
                               startR, noArray(), TRANSLATIONS_METRIC, flags, params.orientationTolerance, doubts);
        K = std::move(startK);
        R = R.empty() ? startR : R;
    }
    HandEyeCalibration start;
    start.camera = readCamera(K, given.distCoeffs);
    start.cam2gripper.R = readRotation(R, "R_cam2gripper");
    const bool allowPartial = (params.flags & REFINE_ALLOW_PARTIAL) != 0;
    if (t.empty() && allowPartial && turns.observed.cols() == 0)
        return start;
    if (t.empty())
    {
        const std::vector<int> doubtedBefore = doubts.rejectedViews;
        rotationClosedForm(given.R_gripper2base, given.t_gripper2base, given.imagePoints, K, given.distCoeffs, R, t,
                           noArray(), allowPartial ? ROTATION_ALLOW_PARTIAL : 0, doubts);
        doubts.rejectedViews.insert(doubts.rejectedViews.end(), doubtedBefore.begin(), doubtedBefore.end());
    }
    start.cam2gripper.t = readVector3(t, "t_cam2gripper");
    return start;
}

} // namespace

StartSearch::StartSearch(const StartArguments& given, const RefineMeasurements& measurements,
                         const RefineParams& params)
    : given_(given), measurements_(measurements), params_(params), turns_(measurements.gripper2base)
{
    requireGiven(given.cameraMatrix, "cameraMatrix", params, REFINE_FIX_K, "REFINE_FIX_K");
    requireGiven(given.R_cam2gripper, "R_cam2gripper", params, REFINE_FIX_ROTATION, "REFINE_FIX_ROTATION");
    requireGiven(given.t_cam2gripper, "t_cam2gripper", params, REFINE_FIX_TRANSLATION, "REFINE_FIX_TRANSLATION");
    requireMotion(measurements, params, turns_);
}

//! Refines from a start that some of the views give. Returns whether it answered and had no doubts about views.
bool StartSearch::attempt(const std::vector<int>& views, double threshold, const std::vector<int>& doubted)
{
    ViewDoubts doubts = {threshold, {}};
    given_.setViews(measurements_, views);
    try
    {
        std::unique_ptr<HandEyeRefinement> candidate(new HandEyeRefinement(measurements_, params_,
                                                                           startOf(given_, params_, turns_, doubts),
                                                                           doubted));
        candidate->findScene();
        candidate->fitPoints();
        const double decisive = doubted.empty() ? 1 : 0.3; // to leave out a whole group must be worth it
        if (!best_ || candidate->misfit() < decisive * best_->misfit())
            best_ = std::move(candidate);
        return doubts.rejectedViews.empty();
    }
    catch (const cv::Exception& e)
    {
        if (e.code != Error::StsNoConv)
            throw;
        refusal_ = refusal_ ? refusal_ : std::current_exception();
        return false;
    }
}

//! Attempts without each group of views, or each two of them.
void StartSearch::attemptWithoutGroups(bool two)
{
    std::vector<int> all(measurements_.gripper2base.size());
    std::iota(all.begin(), all.end(), 0);
    const std::vector<MotionGroup> groups =
        groupByOrientation(measurements_.gripper2base, params_.orientationTolerance);
    for (size_t a = 0; a < groups.size(); ++a)
        for (size_t b = two ? a + 1 : a; b < (two ? groups.size() : a + 1); ++b)
        {
            std::vector<int> without = groups[a].views, others;
            if (two)
                without.insert(without.end(), groups[b].views.begin(), groups[b].views.end());
            std::sort(without.begin(), without.end());
            std::set_difference(all.begin(), all.end(), without.begin(), without.end(), std::back_inserter(others));
            if (groups[a].views.size() > 1 && groups[b].views.size() > 1 && others.size() > 3)
                attempt(others, largeImageNoise, two ? std::vector<int>() : without);
        }
}

std::unique_ptr<HandEyeRefinement> StartSearch::refinePoints()
{
    const double largeMisfit = 2; // px: more than a good robot's noise moves the image
    std::vector<int> all(measurements_.gripper2base.size());
    std::iota(all.begin(), all.end(), 0);
    if (!attempt(all, largeImageNoise, std::vector<int>()))
        attempt(all, std::numeric_limits<double>::max(), std::vector<int>());
    if (!best_ || best_->misfit() > largeMisfit)
        attemptWithoutGroups(false);
    if (!best_)
        attemptWithoutGroups(true);
    if (!best_)
        std::rethrow_exception(refusal_);
    return std::move(best_);
}

}} // namespace cv::active_handeye
