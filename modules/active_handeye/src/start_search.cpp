// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "closed_forms.hpp"
#include "motion_groups.hpp"
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

//! Without turns the translations alone determine K and R, whatever the start.
void requireDirections(const StartArguments& given, const RefineParams& params)
{
    const bool isKnown = (params.flags & REFINE_FIX_K) != 0;
    const GroupTranslations motion(readRobotPoses(given.R_gripper2base, given.t_gripper2base),
                                   params.orientationTolerance);
    motion.requireDirections(isKnown ? 2 : 3, isKnown ? "two that are not parallel"
                                                      : "three that are not coplanar (two with REFINE_FIX_K)");
}

//! K and R from the pure translations, t from the turns, as far as the caller gives no start.
HandEyeCalibration startOf(const StartArguments& given, const RefineParams& params, const TurnDirections& turns,
                           ViewDoubts& doubts)
{
    if (given.cameraMatrix.empty() && params.flags & REFINE_FIX_K)
        CV_Error(Error::StsBadArg, "cameraMatrix: needed with REFINE_FIX_K, given none");
    if (turns.observed.cols() == 0)
        requireDirections(given, params);
    Mat K = given.cameraMatrix, R = given.R_cam2gripper, t = given.t_cam2gripper.clone();
    if (K.empty() || R.empty())
    {
        Mat startK = K.clone(), startR;
        const int flags = K.empty() ? translationsFlags(params) : int(TRANSLATIONS_FIX_K);
        translationsClosedForm(given.R_gripper2base, given.t_gripper2base, given.imagePoints, startK, given.distCoeffs,
                               startR, noArray(), TRANSLATIONS_METRIC, flags, params.orientationTolerance, doubts);
        K = startK;
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
{}

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

void StartSearch::attemptWithoutGroups()
{
    std::vector<int> all(measurements_.gripper2base.size());
    std::iota(all.begin(), all.end(), 0);
    for (const MotionGroup& group : groupByOrientation(measurements_.gripper2base, params_.orientationTolerance))
    {
        std::vector<int> others;
        std::set_difference(all.begin(), all.end(), group.views.begin(), group.views.end(), std::back_inserter(others));
        if (group.views.size() > 1 && others.size() > 3)
            attempt(others, largeImageNoise, group.views);
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
        attemptWithoutGroups();
    if (!best_)
        std::rethrow_exception(refusal_);
    return std::move(best_);
}

}} // namespace cv::active_handeye
