// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "view_choice.hpp"
#include "decompositions.hpp"
#include "opencv2/core/utility.hpp"

namespace cv { namespace active_handeye {

using Eigen::MatrixXd;

static const double infinity = std::numeric_limits<double>::infinity();

bool GroupDemand::spread(const MotionGroup& group, const std::vector<int>& views,
                         const AlignedVector<Pose>& gripper2base) const
{
    const double leastShare = 0.25; // of the longest extent
    MatrixXd moved(3, views.size());
    for (size_t i = 0; i < views.size(); ++i)
        moved.col(i) = group.displacement(gripper2base[views[0]], gripper2base[views[i]]);
    moved.colwise() -= moved.rowwise().mean().eval();
    const int rank = std::min(dimensions, int(views.size()) - 1);
    const Eigen::VectorXd extents = thinSVD(moved).singularValues();
    return rank <= 0 || (extents(0) > 0 && extents(rank - 1) >= leastShare * extents(0));
}

ViewChoice::ViewChoice(const AlignedVector<Pose>& gripper2base, const ViewInformation& information,
                       const GroupDemand& demand, const MatrixXd& prior, const std::vector<int>& taken,
                       const std::vector<bool>& isPossible, double orientationTolerance)
    : poses_(gripper2base), views_(information), demand_(demand),
      groups_(groupByOrientation(gripper2base, orientationTolerance)), sum_(prior), isPossible_(isPossible),
      isUsed_(gripper2base.size()), taken_(taken.size())
{
    for (int view : taken)
        add(view);
}

std::vector<int> ViewChoice::possibleViews() const
{
    std::vector<int> views;
    for (int view = 0; view < int(poses_.size()); ++view)
        if (isPossible_[view] && !isUsed_[view])
            views.push_back(view);
    return views;
}

void ViewChoice::add(int view)
{
    chosen_.push_back(view);
    isUsed_[view] = true;
    sum_ += views_.of(view);
}

std::vector<int> ViewChoice::membersOf(int group) const
{
    std::vector<int> members;
    for (int view : groups_[group].views)
        if (isUsed_[view])
            members.push_back(view);
    return members;
}

bool ViewChoice::isSatisfied(int group) const
{
    const std::vector<int> members = membersOf(group);
    return int(members.size()) >= demand_.viewsPerGroup && demand_.spread(groups_[group], members, poses_);
}

int ViewChoice::satisfiedGroups() const
{
    int count = 0;
    for (int group = 0; group < int(groups_.size()); ++group)
        count += isSatisfied(group);
    return count;
}

double ViewChoice::varianceWith(int view) const
{
    MatrixXd information = sum_ + views_.of(view);
    return views_.variance(information);
}

//! The view that lowers the variance most; -1 when there is none.
int ViewChoice::best(const std::vector<int>& from, double& variance) const
{
    std::vector<double> variances(from.size());
    parallel_for_(Range(0, int(from.size())),
                  [&](const Range& range)
                  {
                      for (int i = range.start; i < range.end; ++i)
                          variances[i] = varianceWith(from[i]);
                  });
    const auto least = std::min_element(variances.begin(), variances.end());
    if (least == variances.end())
        return -1;
    variance = *least;
    return from[least - variances.begin()];
}

//! The views that a group needs to meet the demand, and the variance with them; empty when it cannot.
std::vector<int> ViewChoice::completion(int group, double& variance) const
{
    ViewChoice trial = *this;
    variance = infinity;
    std::vector<int> added;
    while (!trial.isSatisfied(group))
    {
        const std::vector<int> members = trial.membersOf(group);
        std::vector<int> possible;
        for (int view : groups_[group].views)
        {
            std::vector<int> with = members;
            with.push_back(view);
            if (isPossible_[view] && !trial.isUsed_[view] && demand_.spread(groups_[group], with, poses_))
                possible.push_back(view);
        }
        const int view = trial.best(possible, variance);
        if (view < 0)
            return std::vector<int>();
        trial.add(view);
        added.push_back(view);
    }
    return added;
}

void ViewChoice::addGroups(int stops)
{
    while (satisfiedGroups() < demand_.groups)
    {
        double least = infinity;
        std::vector<int> best;
        for (int group = 0; group < int(groups_.size()); ++group)
        {
            double variance = infinity;
            const std::vector<int> views = isSatisfied(group) ? std::vector<int>() : completion(group, variance);
            if (!views.empty() && variance < least)
                least = variance, best = views;
        }
        if (best.empty())
            CV_Error(Error::StsNoConv,
                     cv::format(
                         "R_gripper2base, t_gripper2base: needed %d orientations with %d views each whose "
                         "translations span %d dimensions, the possible views, which see enough of the scene, hold %d",
                         demand_.groups, demand_.viewsPerGroup, demand_.dimensions, satisfiedGroups()));
        if (chosen_.size() + best.size() > size_t(stops))
            CV_Error(Error::StsOutOfRange,
                     cv::format("stops: needed %d or more for %d groups of %d views (planParams), given %d",
                                int(chosen_.size() + best.size()), demand_.groups, demand_.viewsPerGroup, stops));
        for (int view : best)
            add(view);
    }
}

bool ViewChoice::keepsGroups(size_t place, int view)
{
    isUsed_[chosen_[place]] = false;
    isUsed_[view] = true;
    const bool keeps = satisfiedGroups() >= demand_.groups;
    isUsed_[chosen_[place]] = true;
    isUsed_[view] = false;
    return keeps;
}

//! Exchanges one view for the best that keeps the groups. Returns whether that helped.
bool ViewChoice::exchange(size_t place)
{
    const double worthIt = 0.999;
    const int old = chosen_[place];
    MatrixXd information = sum_;
    const double before = views_.variance(information);
    sum_ -= views_.of(old);
    std::vector<int> possible;
    for (int view : possibleViews())
        if (keepsGroups(place, view))
            possible.push_back(view);
    double variance = infinity;
    const int better = best(possible, variance);
    const bool helps = better >= 0 && variance < worthIt * before;
    const int view = helps ? better : old;
    isUsed_[old] = false;
    isUsed_[view] = true;
    chosen_[place] = view;
    sum_ += views_.of(view);
    return helps;
}

void ViewChoice::choose(int stops, int exchanges)
{
    addGroups(stops);
    while (int(chosen_.size()) < stops)
    {
        const std::vector<int> possible = possibleViews();
        if (possible.empty())
            CV_Error(Error::StsNoConv, cv::format("stops: needed %d, but only %d views see enough of the scene "
                                                  "(planParams.seenShare)",
                                                  stops, int(chosen_.size())));
        double variance = infinity;
        add(best(possible, variance));
    }
    bool helped = true;
    for (int round = 0; round < exchanges && helped; ++round)
    {
        helped = false;
        for (size_t place = taken_; place < chosen_.size(); ++place)
            helped |= exchange(place);
    }
}

std::vector<int> ViewChoice::inGroups() const
{
    std::vector<std::vector<int>> members(groups_.size());
    for (size_t place = taken_; place < chosen_.size(); ++place)
        for (size_t group = 0; group < groups_.size(); ++group)
        {
            const std::vector<int>& views = groups_[group].views;
            if (std::find(views.begin(), views.end(), chosen_[place]) != views.end())
                members[group].push_back(chosen_[place]);
        }
    std::stable_sort(members.begin(), members.end(),
                     [](const std::vector<int>& a, const std::vector<int>& b) { return a.size() > b.size(); });
    std::vector<int> result;
    for (const std::vector<int>& group : members)
        result.insert(result.end(), group.begin(), group.end());
    return result;
}

}} // namespace cv::active_handeye
