// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "track_fit.hpp"
#include "opencv2/core/utils/logger.hpp"

namespace cv { namespace active_handeye {

namespace {

const double gateInSigmas = 5;

template <int Q>
class Fitter
{
public:
    explicit Fitter(TrackProblem<Q>& problem)
        : problem_(problem), size_(problem.tracks.observations.size()), depth_(size_, 1.), weight_(size_, 1.),
          excluded_(problem.models.size(), 0), observed_(problem.models.size(), 0)
    {
        for (const Observation& observation : problem.tracks.observations)
            observed_[observation.view] = 1;
    }

    //! Passes of elimination until the set of inliers no longer changes.
    void run()
    {
        std::fill(depth_.begin(), depth_.end(), 1.);
        std::fill(weight_.begin(), weight_.end(), 1.);
        p_.setZero();
        const int maxPasses = 15, softPasses = 4;
        const double smallChange = 1e-6;
        for (int pass = 0; pass < maxPasses; ++pass)
        {
            const Eigen::Matrix<double, Q, 1> previous = p_;
            solve();
            const std::vector<double> before = weight_;
            const bool soft = pass < softPasses && hasOutliers();
            reweight(soft);
            if (pass > 0 && !soft && weight_ == before && (p_ - previous).norm() <= smallChange * p_.norm())
                break;
        }
    }

    //! Leaves out the view whose absence lowers the residuals most, again and again while that helps decisively.
    void excludeContradictingViews()
    {
        const double decisive = 0.3;
        const int maxExcluded = int(usedViews()) / 3;
        for (int round = 0; round < maxExcluded && viewIsSuspect(); ++round)
        {
            const double before = typicalResidual();
            int best = -1;
            double bestResidual = std::numeric_limits<double>::infinity();
            for (int view = 0; view < int(excluded_.size()); ++view)
            {
                if (excluded_[view] || !observed_[view])
                    continue;
                excluded_[view] = 1;
                run();
                if (typicalResidual() < bestResidual)
                    bestResidual = typicalResidual(), best = view;
                excluded_[view] = 0;
            }
            if (best < 0 || bestResidual > decisive * before)
            {
                run();
                return;
            }
            excluded_[best] = 1;
            run();
        }
    }

    TrackFit<Q> result() const
    {
        TrackFit<Q> fit;
        fit.p = p_;
        fit.S = S_;
        fit.weights = eliminationWeights();
        fit.cost = 0;
        fit.used = fit.redundancy = 0;
        for (int j = 0; j < problem_.tracks.count(); ++j)
        {
            int used = 0;
            for (int o = problem_.tracks.first[j]; o < problem_.tracks.first[j + 1]; ++o)
                if (fit.weights[o] > 0 && residuals_.residual[o].allFinite())
                {
                    fit.cost += residuals_.residual[o].squaredNorm();
                    ++used;
                }
            fit.used += used;
            fit.redundancy += used >= 2 ? 2 * used - 3 : 0;
        }
        for (int view = 0; view < int(excluded_.size()); ++view)
            if (observed_[view] && (excluded_[view] || outlierShare(view) > 0.5))
                fit.rejectedViews.push_back(view);
        return fit;
    }

    bool isBehindCamera() const
    {
        size_t behind = 0, known = 0;
        for (double depth : residuals_.depth)
            if (std::isfinite(depth))
                ++known, behind += depth <= 0;
        return 2 * behind >= known;
    }

    //! Median length of the residuals of all observations, used or not.
    double typicalResidual() const
    {
        std::vector<double> lengths;
        for (size_t o = 0; o < size_; ++o)
            if (residuals_.residual[o].allFinite() && !excluded_[problem_.tracks.observations[o].view])
                lengths.push_back(residuals_.residual[o].norm());
        if (lengths.empty())
            return std::numeric_limits<double>::infinity();
        std::nth_element(lengths.begin(), lengths.begin() + lengths.size() / 2, lengths.end());
        return lengths[lengths.size() / 2];
    }

private:
    std::vector<double> eliminationWeights() const
    {
        std::vector<double> weights(size_);
        for (size_t o = 0; o < size_; ++o)
            weights[o] = excluded_[problem_.tracks.observations[o].view] ? 0 : weight_[o] / (depth_[o] * depth_[o]);
        return weights;
    }

    void solve()
    {
        const std::vector<double> weights = eliminationWeights();
        S_ = eliminateTracks<Q>(problem_.tracks, problem_.models, weights);
        p_ = problem_.minimize(S_);
        residuals_ = trackResiduals<Q>(problem_.tracks, problem_.models, weights, p_);
        if (isBehindCamera() && problem_.mirror(p_))
            for (double& depth : residuals_.depth)
                depth = -depth;
        problem_.updateModels(p_);
        // Redundancy shrinks residuals: with n used numbers and r redundant ones the noise is sqrt(n / r) times larger.
        const TrackFit<Q> fit = result();
        const double shrink = fit.redundancy > Q ? std::sqrt(2. * fit.used / (fit.redundancy - Q)) : 1.;
        const double rayleighMedian = 1.1774;
        sigma_ = std::max(typicalResidual() * shrink / rayleighMedian, 1e-7 / problem_.pixelsPerUnit);
    }

    bool isOutlier(size_t o) const
    {
        return !(residuals_.depth[o] > 0) || !(residuals_.residual[o].norm() <= gateInSigmas * sigma_);
    }

    bool hasOutliers() const
    {
        for (size_t o = 0; o < size_; ++o)
            if (isOutlier(o))
                return true;
        return false;
    }

    //! Soft: Cauchy weights, which let a bad start recover; hard: in or out, which costs no efficiency.
    void reweight(bool soft)
    {
        const double cauchyScale = 2.385;
        for (size_t o = 0; o < size_; ++o)
        {
            const bool inFront = residuals_.depth[o] > 0;
            const double r = residuals_.residual[o].norm() / (cauchyScale * sigma_);
            weight_[o] = !inFront ? 0 : soft ? 1 / (1 + r * r) : isOutlier(o) ? 0 : 1;
            depth_[o] = inFront ? residuals_.depth[o] : 1;
        }
    }

    size_t usedViews() const
    {
        size_t used = 0;
        for (int view = 0; view < int(excluded_.size()); ++view)
            used += observed_[view] && !excluded_[view];
        return used;
    }

    double outlierShare(int view) const
    {
        int outliers = 0, all = 0;
        for (size_t o = 0; o < size_; ++o)
            if (problem_.tracks.observations[o].view == view)
                ++all, outliers += isOutlier(o);
        return all ? outliers / double(all) : 0;
    }

    //! Either one view is mostly outliers, or the residuals are no small part of the parallax.
    bool viewIsSuspect() const
    {
        if (typicalResidual() > 0.02 * medianParallax(problem_.tracks))
            return true;
        for (int view = 0; view < int(excluded_.size()); ++view)
            if (!excluded_[view] && outlierShare(view) > 0.5)
                return true;
        return false;
    }

    TrackProblem<Q>& problem_;
    size_t size_;
    std::vector<double> depth_, weight_;
    std::vector<char> excluded_, observed_;
    Eigen::Matrix<double, Q, Q> S_;
    Eigen::Matrix<double, Q, 1> p_;
    TrackResiduals residuals_;
    double sigma_ = 0;
};

std::string listOf(const std::vector<int>& numbers)
{
    std::string text;
    for (size_t i = 0; i < numbers.size(); ++i)
        text += cv::format("%s%d", i ? ", " : "", numbers[i]);
    return text;
}

} // namespace

template <int Q>
TrackFit<Q> fitTracks(TrackProblem<Q>& problem)
{
    const char* function = problem.function.c_str();
    const double parallax = medianParallax(problem.tracks), pixels = problem.pixelsPerUnit;
    if (!(parallax * pixels > 1e-6))
        CV_Error(Error::StsNoConv, cv::format("%s: imagePoints have no parallax; needed points that move between the views, given a median "
                                              "displacement of %.3g px in %d tracks", function, parallax * pixels, problem.tracks.count()));
    Fitter<Q> fitter(problem);
    fitter.run();
    fitter.excludeContradictingViews();
    const double residual = fitter.typicalResidual();
    if (fitter.isBehindCamera())
        CV_Error(Error::StsNoConv, cv::format("%s: most scene points come out behind the camera; needed poses R_gripper2base, t_gripper2base that "
                                              "belong to imagePoints: are they inverted (base2gripper), or in another order?", function));
    const double maxResidualShare = 0.25;
    if (!(residual <= maxResidualShare * parallax))
        CV_Error(Error::StsNoConv, cv::format("%s: imagePoints do not fit the poses, or have no parallax; needed a residual below %g of the parallax, given a "
                                              "median residual of %.3g px at a median parallax of %.3g px: translate farther, or check the order "
                                              "of the poses", function, maxResidualShare, residual * pixels, parallax * pixels));
    const TrackFit<Q> fit = fitter.result();
    if (!fit.rejectedViews.empty())
        CV_LOG_WARNING(NULL, function << ": views " << listOf(fit.rejectedViews) << " contradict the other views and were not used: check their "
                                      << "R_gripper2base, t_gripper2base and imagePoints");
    return fit;
}

template TrackFit<9> fitTracks<9>(TrackProblem<9>&);
template TrackFit<4> fitTracks<4>(TrackProblem<4>&);

}} // namespace cv::active_handeye
