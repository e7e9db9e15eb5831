// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "hand_eye_fit.hpp"
#include "hand_eye_closed_forms.hpp"
#include "numbers.hpp"

namespace cv { namespace active_handeye {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

const double medianOfThree = 1.538; // of the length of a vector of three standard normal numbers

//! Three views of one sample; all there are when they are few, else drawn with a fixed seed.
std::vector<Vec3i> samplesOfViews(int n)
{
    const int most = 500;
    std::vector<Vec3i> samples;
    if (n * (n - 1.) * (n - 2.) / 6 <= most)
    {
        for (int i = 0; i < n; ++i)
            for (int j = i + 1; j < n; ++j)
                for (int k = j + 1; k < n; ++k)
                    samples.push_back(Vec3i(i, j, k));
        return samples;
    }
    RNG rng(1);
    while (int(samples.size()) < most)
    {
        const Vec3i sample(rng.uniform(0, n), rng.uniform(0, n), rng.uniform(0, n));
        if (sample[0] != sample[1] && sample[1] != sample[2] && sample[2] != sample[0])
            samples.push_back(sample);
    }
    return samples;
}

//! The mean of what the views say of the target.
Pose targetOf(const HandEyeViews& views, const Pose& cam2gripper)
{
    Matrix3d R = Matrix3d::Zero();
    Vector3d t = Vector3d::Zero();
    for (int view = 0; view < views.count(); ++view)
    {
        const Pose target = views.target2base(view, cam2gripper);
        R += target.R;
        t += target.t / views.count();
    }
    return Pose{nearestRotation(R), t};
}

HandEyeState stateOf(const HandEyeViews& views, const HandEyeMotions& motions)
{
    const Matrix3d R = rotationFromLogarithms(motions);
    const Pose cam2gripper = {R, translationOf(motions, R)};
    return HandEyeState{cam2gripper, targetOf(views, cam2gripper)};
}

HandEyeViews pick(const HandEyeViews& views, const Vec3i& sample)
{
    HandEyeViews few;
    for (int i = 0; i < 3; ++i)
    {
        few.gripper2base.push_back(views.gripper2base[sample[i]]);
        few.target2cam.push_back(views.target2cam[sample[i]]);
    }
    return few;
}

struct Distances
{
    std::vector<double> angles, lengths;

    Distances(const HandEyeViews& views, const HandEyeState& state)
    {
        for (int view = 0; view < views.count(); ++view)
        {
            const Vector6d residual = residualOf(views, view, state);
            angles.push_back(residual.head<3>().norm());
            lengths.push_back(residual.tail<3>().norm());
        }
    }

    //! Least median of squares; the product does not depend on units.
    double score() const { return std::max(median(angles), 1e-15) * median(lengths); }
};

} // namespace

HandEyeStart findHandEyeStart(const HandEyeViews& views)
{
    HandEyeStart start;
    start.state = stateOf(views, motionsOf(views));
    double best = Distances(views, start.state).score();
    for (const Vec3i& sample : samplesOfViews(views.count()))
    {
        const HandEyeViews few = pick(views, sample);
        const HandEyeState state = stateOf(few, motionsOf(few));
        const double score = Distances(views, state).score();
        if (score < best)
        {
            best = score;
            start.state = state;
        }
    }
    // Standard deviations; generous, since a sample of three views is not accurate. Few views: Rousseeuw and Leroy 1987.
    const double largest = 6 * (1 + 5. / (views.count() - 2));
    const Distances found(views, start.state);
    std::vector<int> all;
    const double angle = largest * median(found.angles) / medianOfThree,
                 length = largest * median(found.lengths) / medianOfThree;
    for (int view = 0; view < views.count(); ++view)
    {
        all.push_back(view);
        if (found.angles[view] <= std::max(angle, 1e-9) && found.lengths[view] <= length)
            start.views.push_back(view);
    }
    if (start.views.size() < 3 || int(start.views.size()) == views.count() - 1) // one wrong view cannot hide itself
        start.views = std::move(all);
    return start;
}

}} // namespace cv::active_handeye
