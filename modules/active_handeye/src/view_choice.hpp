// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// The search for the views that tell most.
#ifndef OPENCV_ACTIVE_HANDEYE_VIEW_CHOICE_HPP
#define OPENCV_ACTIVE_HANDEYE_VIEW_CHOICE_HPP

#include "motion_groups.hpp"
#include "planned_views.hpp"

namespace cv { namespace active_handeye {

/** What every view tells about scene points and calibration, its own pose eliminated.

The unknowns are some of the scene points, spread out, of which each stands for several, and the free directions of the calibration, those of
t_cam2gripper last. The information of a set of views is the sum over its views.
*/
class ViewInformation
{
public:
    //! problem: unknowns.calibration, noise and reported poses are used. pointLimit: the most scene points.
    ViewInformation(const RefineProblem& problem, const AssumedScene& scene, int pointLimit);

    const Eigen::MatrixXd& of(int view) const { return information_[view]; }

    //! What is known beforehand: hardly anything.
    Eigen::MatrixXd prior(double workingDistance, double imageRadius) const;

    //! Sum of the variances of t_cam2gripper. The matrix is destroyed.
    double variance(Eigen::MatrixXd& information) const;

private:
    Eigen::MatrixXd informationOf(int view) const;

    const RefineProblem& problem_;
    const AssumedScene& scene_;
    std::vector<int> points_;
    double pointSigma_;
    int translations_; //!< columns of t_cam2gripper
    std::vector<Eigen::MatrixXd> information_;
};

//! What a set of views has to have for the closed forms.
struct GroupDemand
{
    int groups, viewsPerGroup;
    int dimensions; //!< that the translations of a group span

    //! Whether these views of one group translate in as many directions as so few can.
    bool spread(const MotionGroup& group, const std::vector<int>& views, const AlignedVector<Pose>& gripper2base) const;
};

//! Greedy choice and exchange.
class ViewChoice
{
public:
    //! isPossible: which views may be chosen.
    ViewChoice(const AlignedVector<Pose>& gripper2base, const ViewInformation& information, const GroupDemand& demand,
               const Eigen::MatrixXd& prior, const std::vector<int>& taken, const std::vector<bool>& isPossible,
               double orientationTolerance);

    //! Throws StsNoConv when the demand cannot be met with so many views.
    void choose(int stops, int exchanges);

    //! Without those taken; by group, those with most views first.
    std::vector<int> inGroups() const;

private:
    bool isSatisfied(int group) const;
    int satisfiedGroups() const;
    std::vector<int> membersOf(int group) const;
    std::vector<int> possibleViews() const;
    std::vector<int> completion(int group, double& variance) const;
    void addGroups(int stops);
    int best(const std::vector<int>& from, double& variance) const;
    double varianceWith(int view) const;
    void add(int view);
    bool exchange(size_t place);
    bool keepsGroups(size_t place, int view);

    const AlignedVector<Pose>& poses_;
    const ViewInformation& views_;
    const GroupDemand demand_;
    const std::vector<MotionGroup> groups_;
    Eigen::MatrixXd sum_;
    std::vector<int> chosen_;
    const std::vector<bool> isPossible_;
    std::vector<bool> isUsed_;
    size_t taken_;
};

}} // namespace cv::active_handeye

#endif
