// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_ACTIVE_HANDEYE_TRACK_FITTER_HPP
#define OPENCV_ACTIVE_HANDEYE_TRACK_FITTER_HPP

#include "track_fit.hpp"
#include "track_jitter.hpp"

namespace cv { namespace active_handeye {

//! The iteration behind fitTracks().
template <class Model>
class TrackFitter
{
public:
    typedef typename TrackProblem<Model>::Parameters Parameters;

    explicit TrackFitter(TrackProblem<Model>& problem)
        : problem_(problem), observations_(problem.tracks.observations), parallax_(problem.tracks.medianParallax()),
          observed_(problem.models.size(), 0), excluded_(problem.models.size(), 0),
          still_(Eigen::VectorXd::Zero(JITTER_NUMBERS * int(problem.models.size())))
    {
        for (const Observation& observation : observations_)
            ++observed_[observation.view];
    }

    //! Passes of elimination until the set of inliers no longer changes.
    void run()
    {
        depth_.assign(observations_.size(), 1.);
        robust_.assign(observations_.size(), 1.);
        const int maxPasses = 15, softPasses = 4;
        const double smallChange = 1e-6;
        problem_.tracks.setForms(problem_.toImage);
        for (int pass = 0; pass < maxPasses; ++pass)
        {
            const Parameters previous = p_;
            solve();
            const bool imagesMoved = problem_.updateImages(p_);
            const bool soft = pass < softPasses && outliers_ > 0;
            const bool sameInliers = reweight(soft);
            if (pass > 0 && !soft && sameInliers && (!imagesMoved || (p_ - previous).norm() <= smallChange * p_.norm()))
                break;
            if (imagesMoved)
                problem_.tracks.setForms(problem_.toImage);
        }
    }

    //! Leaves out the one or two views whose absence lowers the residuals decisively, again while views are suspect.
    void excludeContradictingViews()
    {
        while (3 * std::count(excluded_.begin(), excluded_.end(), 1) < viewCount() && aViewIsSuspect())
            if (!excludeBest())
                return;
    }

    //! The image of some view moved as a whole, clearly more than independent noise explains, but not so far that the pose must be wrong.
    bool viewsJitter() const
    {
        if (typicalResidual_ > contradiction())
            return false;
        const TrackFit<Model> fit = result();
        const double variance = std::pow(std::max(fit.sigma(Model::parameters), rounding()), 2);
        double chiSquare = 0;
        for (const ViewMean& mean : viewMeans())
            chiSquare += mean.count * mean.residual.squaredNorm() / variance;
        const double degrees = 2 * viewCount();
        return chiSquare > degrees + 4 * std::sqrt(2 * degrees);
    }

    //! Goes on from run() with a jitter of every view; image noise and jitter by restricted maximum likelihood.
    void estimateJitter()
    {
        const int maxPasses = 12;
        const double settled = 1e-3;
        double variance = std::pow(std::max(result().sigma(Model::parameters), rounding()), 2), jitterVariance = 0;
        for (const ViewMean& mean : viewMeans())
            jitterVariance += mean.residual.squaredNorm() / (2 * viewCount());
        for (int pass = 0; pass < maxPasses; ++pass)
        {
            const double before = jitterVariance, precision = variance / jitterVariance;
            const JitterForm<Model::parameters> form = solveWithJitter(precision);
            determinedJitter_ = std::max(form.determined(problem_.tangent(), precision), 1.);
            variance = std::pow(std::max(result().sigma(int(problem_.tangent().cols())), rounding()), 2);
            jitterVariance = std::max(jitter_.squaredNorm() / determinedJitter_, 1e-12 * variance);
            jitterSigma_ = std::sqrt(jitterVariance);
            if (reweight(false) && std::abs(jitterVariance - before) <= settled * before)
                break;
        }
    }

    TrackFit<Model> result() const
    {
        TrackFit<Model> fit;
        fit.p = p_;
        fit.S = S_;
        fit.cost = 0;
        fit.used = 0;
        fit.redundancy = -determinedJitter_;
        fit.jitterSigma = jitterSigma_;
        fit.medianDepth = medianOf(residuals_.depth);
        for (int j = 0; j < problem_.tracks.count(); ++j)
        {
            if (!points_[j].usable())
                continue;
            int used = 0;
            for (int o = problem_.tracks.first[j]; o < problem_.tracks.first[j + 1]; ++o)
                if (weights_[o] > 0)
                    ++used, fit.cost += residuals_.squared[o];
            fit.used += used;
            fit.redundancy += 2 * used - 3;
        }
        for (size_t view = 0; view < excluded_.size(); ++view)
            if (observed_[view] && (excluded_[view] || mostlyOutliers(view)))
                fit.rejectedViews.push_back(int(view));
        return fit;
    }

    bool isBehindCamera() const { return 2 * behind_ >= known_; }
    double typicalResidual() const { return typicalResidual_; } //!< median length
    double parallax() const { return parallax_; }
    int viewCount() const
    {
        return int(observed_.size() - std::count(observed_.begin(), observed_.end(), 0));
    } //!< with observations

private:
    struct ViewMean
    {
        Eigen::Vector2d residual;
        int count;
    };

    //! Mean residual of every view over the observations used.
    AlignedVector<ViewMean> viewMeans() const
    {
        AlignedVector<ViewMean> means(observed_.size(), ViewMean{Eigen::Vector2d::Zero(), 0});
        for (size_t o = 0; o < observations_.size(); ++o)
            if (weights_[o] > 0 && !std::isnan(residuals_.squared[o]))
            {
                means[observations_[o].view].residual += residuals_.residual[o];
                ++means[observations_[o].view].count;
            }
        for (ViewMean& mean : means)
            mean.residual /= std::max(mean.count, 1);
        return means;
    }

    double rounding() const { return 1e-7 / problem_.pixelsPerUnit; }
    double contradiction() const { return problem_.largeResidual / problem_.pixelsPerUnit; } //!< more than noise

    //! Median residual without these views too. Leaves them excluded.
    double residualWithout(const std::vector<char>& before, size_t a, size_t b)
    {
        excluded_ = before;
        excluded_[a] = excluded_[b] = 1;
        run();
        return typicalResidual_;
    }

    //! Excludes the view, or the two of the most suspect views, whose absence lowers the typical residual decisively.
    bool excludeBest()
    {
        const double decisive = 0.3;
        const size_t suspects = 12;
        const std::vector<char> before = excluded_;
        std::vector<char> best;
        double bestResidual = decisive * typicalResidual_;
        const auto attempt = [&](size_t a, size_t b)
        {
            const double residual = residualWithout(before, a, b);
            if (residual < bestResidual)
                bestResidual = residual, best = excluded_;
            return residual;
        };
        std::vector<std::pair<double, size_t>> byResidual;
        for (size_t view = 0; view < before.size(); ++view)
            if (observed_[view] && !before[view])
                byResidual.push_back(std::make_pair(attempt(view, view), view));
        std::sort(byResidual.begin(), byResidual.end());
        byResidual.resize(std::min(byResidual.size(), suspects));
        const bool oneSuffices = !best.empty();
        for (size_t a = 0; !oneSuffices && a < byResidual.size(); ++a)
            for (size_t b = a + 1; b < byResidual.size(); ++b)
                attempt(byResidual[a].second, byResidual[b].second);
        excluded_ = best.empty() ? before : best;
        run();
        return !best.empty();
    }

    //! Of two mirrored answers the one near the last.
    void keepNear(const Parameters& previous)
    {
        Parameters other = p_;
        if (!problem_.mirror(S_, other))
            return;
        const bool otherIsNearer = (other - previous).norm() < (p_ - previous).norm();
        p_ = other;
        if (!otherIsNearer)
            problem_.mirror(S_, p_);
    }

    void setWeights()
    {
        weights_.resize(observations_.size());
        for (size_t o = 0; o < weights_.size(); ++o)
            weights_[o] = excluded_[observations_[o].view] ? 0 : robust_[o] / (depth_[o] * depth_[o]);
    }

    void solve()
    {
        setWeights();
        S_ = eliminateTracks(problem_.tracks, problem_.models, weights_, points_);
        p_ = problem_.minimize(S_);
        evaluate();
        if (isBehindCamera() && problem_.mirror(S_, p_))
            evaluate();
        findOutliers();
    }

    JitterForm<Model::parameters> solveWithJitter(double precision)
    {
        setWeights();
        problem_.tracks.removeJitter(still_);
        problem_.tracks.setForms(problem_.toImage);
        const JitterForm<Model::parameters> form =
            eliminateTracksWithJitter(problem_.tracks, problem_.models, problem_.toImage, weights_, depth_, points_);
        S_ = form.withoutJitter(precision);
        const Parameters previous = p_;
        p_ = problem_.minimize(S_);
        keepNear(previous);
        jitter_ = form.jitter(p_, precision);
        problem_.updateImages(p_);
        problem_.tracks.removeJitter(jitter_);
        problem_.tracks.setForms(problem_.toImage);
        eliminateTracks(problem_.tracks, problem_.models, weights_, points_);
        evaluate();
        findOutliers();
        return form;
    }

    //! Depths and residuals of all observations for the present p.
    void evaluate()
    {
        evaluateTracks(problem_.tracks, problem_.models, problem_.toImage, points_, p_, residuals_);
        known_ = behind_ = 0;
        for (double depth : residuals_.depth)
            if (!std::isnan(depth))
                ++known_, behind_ += depth <= 0;
    }

    void findOutliers()
    {
        typicalResidual_ = std::sqrt(medianOf(residuals_.squared));
        // The fit absorbs a part of the noise: of n numbers only r are redundant, which makes residuals sqrt(r / n) of it.
        const double redundant =
            double(2 * observations_.size()) - 3 * problem_.tracks.count() - double(Model::parameters);
        const double absorbed = std::sqrt(2 * observations_.size() / std::max(redundant, 1.));
        const double rayleighMedian = 1.1774;
        const double gate = gateInSigmas * std::max(typicalResidual_ * absorbed / rayleighMedian, rounding());
        gateSquared_ = gate * gate;
        outliers_ = 0;
        contradictionsOfView_.assign(observed_.size(), 0);
        const double far = std::pow(contradiction(), 2);
        for (size_t o = 0; o < residuals_.squared.size(); ++o)
            if (isOutlier(o))
            {
                ++outliers_;
                contradictionsOfView_[observations_[o].view] +=
                    !(residuals_.depth[o] > 0 && residuals_.squared[o] < far);
            }
    }

    //! Over the observations of the views not excluded, a thousand of them are enough; one without a value counts as infinite.
    double medianOf(const std::vector<double>& values) const
    {
        const double infinity = std::numeric_limits<double>::infinity();
        std::vector<double> present;
        const size_t stride = 1 + values.size() / 1000;
        present.reserve(values.size() / stride + 1);
        for (size_t o = 0; o < values.size(); o += stride)
            if (!excluded_[observations_[o].view])
                present.push_back(std::isnan(values[o]) ? infinity : values[o]);
        if (present.empty())
            return infinity;
        std::nth_element(present.begin(), present.begin() + present.size() / 2, present.end());
        return present[present.size() / 2];
    }

    bool isOutlier(size_t o) const { return !(residuals_.depth[o] > 0) || !(residuals_.squared[o] <= gateSquared_); }

    //! Soft: Cauchy weights, which let a bad start recover; hard: in or out, which costs no efficiency. True when nothing changed.
    bool reweight(bool soft)
    {
        const double cauchySquared = std::pow(2.385 / gateInSigmas, 2) * gateSquared_;
        bool same = true;
        for (size_t o = 0; o < residuals_.squared.size(); ++o)
        {
            const bool inFront = residuals_.depth[o] > 0;
            const double weight = !inFront       ? 0
                                  : soft         ? 1 / (1 + residuals_.squared[o] / cauchySquared)
                                  : isOutlier(o) ? 0
                                                 : 1;
            same = same && weight == robust_[o];
            robust_[o] = weight;
            depth_[o] = inFront ? residuals_.depth[o] : 1;
        }
        return same;
    }

    bool mostlyOutliers(size_t view) const { return 2 * contradictionsOfView_[view] > observed_[view]; }

    //! Either one view is mostly far off, or the residuals of all are large.
    bool aViewIsSuspect() const
    {
        const double largeShare = 0.02;
        bool suspect = typicalResidual_ > contradiction() || typicalResidual_ > largeShare * parallax_;
        for (size_t view = 0; view < excluded_.size(); ++view)
            suspect = suspect || (observed_[view] && !excluded_[view] && mostlyOutliers(view));
        return suspect;
    }

    enum
    {
        gateInSigmas = 5
    };

    TrackProblem<Model>& problem_;
    const AlignedVector<Observation>& observations_;
    double parallax_;
    std::vector<int> observed_, contradictionsOfView_; // observations per view
    std::vector<char> excluded_;
    std::vector<double> depth_, robust_, weights_;
    AlignedVector<EliminatedPoint<Model::parameters>> points_;
    TrackResiduals residuals_;
    typename TrackProblem<Model>::Form S_ = TrackProblem<Model>::Form::Zero();
    Parameters p_ = Parameters::Zero();
    Eigen::VectorXd still_, jitter_; // JITTER_NUMBERS per view; still_ is zero
    double determinedJitter_ = 0, jitterSigma_ = 0;
    double typicalResidual_ = 0, gateSquared_ = 0;
    size_t outliers_ = 0, known_ = 0, behind_ = 0;
};

}} // namespace cv::active_handeye

#endif
