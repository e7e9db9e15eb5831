// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// Maximum likelihood of poses with errors, in steps: a robust start, the solution, views that contradict it.
#ifndef OPENCV_ACTIVE_HANDEYE_HAND_EYE_FIT_HPP
#define OPENCV_ACTIVE_HANDEYE_HAND_EYE_FIT_HPP

#include "hand_eye_variances.hpp"

namespace cv { namespace active_handeye {

//! A state that most views agree on, from the best of many samples of three views, and these views.
struct HandEyeStart
{
    HandEyeState state;
    std::vector<int> views;
};

HandEyeStart findHandEyeStart(const HandEyeViews& views);

class HandEyeFit
{
public:
    //! given: standard deviations, negative = estimated. length: of the arrangement, for the smallest noise that is told from rounding.
    HandEyeFit(const HandEyeViews& views, const NoiseVariances& given, double length);

    //! Refines the start and exchanges views until none that is used contradicts the others and none that is left out agrees.
    void run(const HandEyeStart& start);

    const HandEyeState& state() const { return state_; }
    const HandEyeVariances& variances() const { return *variances_; }
    bool isEstimated(int noise) const { return isFree_[noise]; }
    bool isUsed(int view) const { return std::binary_search(used_.begin(), used_.end(), view); }
    int usedViews() const { return int(used_.size()); }
    int iterations() const { return iterations_; }

    //! p-values of the orientation and the position of a view, against the other views.
    Eigen::Vector2d pValues(int view) const;

private:
    void solve();
    void linearize();
    double pValue(const HandEyeResidual& residual, int row, bool isUsed) const;
    bool exchangeView(std::vector<bool>& wasLeftOut);

    const HandEyeViews& views_;
    NoiseVariances variance_, floors_;
    bool isFree_[HAND_EYE_NOISES];
    HandEyeState state_;
    std::vector<int> used_; //!< ascending
    HandEyeResiduals residuals_;
    Ptr<HandEyeVariances> variances_;
    int iterations_;
};

}} // namespace cv::active_handeye

#endif
