// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "track_fit.hpp"
#include "opencv2/core/utils/logger.hpp"

namespace cv { namespace active_handeye {

namespace {

const double gateInSigmas = 5;

template <class Model>
class Fitter
{
public:
    typedef typename TrackProblem<Model>::Parameters Parameters;

    explicit Fitter(TrackProblem<Model>& problem)
        : problem_(problem), observations_(problem.tracks.observations), parallax_(problem.tracks.medianParallax()),
          observed_(problem.models.size(), 0), excluded_(problem.models.size(), 0)
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
        {
            const std::vector<char> before = excluded_;
            if (!excludeBest(1) && !excludeBest(2))
            {
                excluded_ = before;
                run();
                return;
            }
        }
    }

    TrackFit<Model> result() const
    {
        TrackFit<Model> fit;
        fit.p = p_;
        fit.S = S_;
        fit.cost = 0;
        fit.used = fit.redundancy = 0;
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
    //! Tries every set of `size` views; keeps the best one when it lowers the typical residual decisively.
    bool excludeBest(int size)
    {
        const double decisive = 0.3;
        const std::vector<char> before = excluded_;
        std::vector<char> best;
        double bestResidual = decisive * typicalResidual_;
        const auto attempt = [&]
        {
            run();
            if (typicalResidual_ < bestResidual)
                bestResidual = typicalResidual_, best = excluded_;
        };
        for (size_t a = 0; a < before.size(); ++a)
            for (size_t b = size == 1 ? a : a + 1; b < (size == 1 ? a + 1 : before.size()); ++b)
                if (observed_[a] && observed_[b] && !before[a] && !before[b])
                {
                    excluded_ = before;
                    excluded_[a] = excluded_[b] = 1;
                    attempt();
                }
        excluded_ = best.empty() ? before : best;
        run();
        return !best.empty();
    }

    void solve()
    {
        weights_.resize(observations_.size());
        for (size_t o = 0; o < weights_.size(); ++o)
            weights_[o] = excluded_[observations_[o].view] ? 0 : robust_[o] / (depth_[o] * depth_[o]);
        S_ = eliminateTracks(problem_.tracks, problem_.models, weights_, points_);
        p_ = problem_.minimize(S_);
        evaluate();
        if (isBehindCamera() && problem_.mirror(p_))
            evaluate();
        findOutliers();
    }

    //! Depths and residuals of all observations for the present p.
    void evaluate()
    {
        evaluateTracks(problem_.tracks, problem_.models, problem_.toImage, weights_, points_, p_, residuals_);
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
        const double rayleighMedian = 1.1774, rounding = 1e-7 / problem_.pixelsPerUnit;
        const double gate = gateInSigmas * std::max(typicalResidual_ * absorbed / rayleighMedian, rounding);
        gateSquared_ = gate * gate;
        outliers_ = 0;
        outliersOfView_.assign(observed_.size(), 0);
        for (size_t o = 0; o < residuals_.squared.size(); ++o)
            if (isOutlier(o))
                ++outliers_, ++outliersOfView_[observations_[o].view];
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

    bool mostlyOutliers(size_t view) const { return 2 * outliersOfView_[view] > observed_[view]; }

    //! Either one view is mostly outliers, or the residuals are larger than image noise is.
    bool aViewIsSuspect() const
    {
        const double largeNoise = 0.5, largeShare = 0.02; // pixels; part of the parallax
        bool suspect =
            typicalResidual_ * problem_.pixelsPerUnit > largeNoise || typicalResidual_ > largeShare * parallax_;
        for (size_t view = 0; view < excluded_.size(); ++view)
            suspect = suspect || (observed_[view] && !excluded_[view] && mostlyOutliers(view));
        return suspect;
    }

    TrackProblem<Model>& problem_;
    const AlignedVector<Observation>& observations_;
    double parallax_;
    std::vector<int> observed_, outliersOfView_; // observations per view
    std::vector<char> excluded_;
    std::vector<double> depth_, robust_, weights_;
    AlignedVector<EliminatedPoint> points_;
    TrackResiduals residuals_;
    typename TrackProblem<Model>::Form S_ = TrackProblem<Model>::Form::Zero();
    Parameters p_ = Parameters::Zero();
    double typicalResidual_ = 0, gateSquared_ = 0;
    size_t outliers_ = 0, known_ = 0, behind_ = 0;
};

std::string listOf(const std::vector<int>& numbers)
{
    std::string text;
    for (size_t i = 0; i < numbers.size(); ++i)
        text += cv::format("%s%d", i ? ", " : "", numbers[i]);
    return text;
}

} // namespace

template <class Model>
TrackFit<Model> fitTracks(TrackProblem<Model>& problem)
{
    const char* function = problem.function.c_str();
    Fitter<Model> fitter(problem);
    const double parallax = fitter.parallax(), pixels = problem.pixelsPerUnit;
    if (!(parallax * pixels > 1e-6))
        CV_Error(
            Error::StsNoConv,
            cv::format("%s: imagePoints have no parallax; needed points that move between the views, given a median "
                       "displacement of %.3g px in %d tracks",
                       function, parallax * pixels, problem.tracks.count()));
    fitter.run();
    fitter.excludeContradictingViews();
    const double residual = fitter.typicalResidual(), maxShare = 0.25;
    if (fitter.isBehindCamera())
        CV_Error(
            Error::StsNoConv,
            cv::format(
                "%s: most scene points come out behind the camera; needed poses R_gripper2base, t_gripper2base that "
                "belong to imagePoints: are they inverted (base2gripper), or in another order?",
                function));
    if (!(residual <= maxShare * parallax))
        CV_Error(
            Error::StsNoConv,
            cv::format(
                "%s: imagePoints do not fit the poses, or have no parallax; needed a residual below %g of the parallax, "
                "given a median residual of %.3g px at a median parallax of %.3g px: translate farther, or check the "
                "order of the poses",
                function, maxShare, residual * pixels, parallax * pixels));
    const TrackFit<Model> fit = fitter.result();
    if (3 * fit.rejectedViews.size() > size_t(fitter.viewCount()))
        CV_Error(
            Error::StsNoConv,
            cv::format(
                "%s: imagePoints and poses contradict each other; needed two thirds of the views to agree, given %d of %d "
                "views that disagree: %s (no parallax, wrong matches, or poses of other images)",
                function, int(fit.rejectedViews.size()), fitter.viewCount(), listOf(fit.rejectedViews).c_str()));
    if (!fit.rejectedViews.empty())
        CV_LOG_WARNING(NULL, function << ": views " << listOf(fit.rejectedViews)
                                      << " contradict the other views and were not used: check their "
                                      << "R_gripper2base, t_gripper2base and imagePoints");
    return fit;
}

template TrackFit<TranslationModel> fitTracks<TranslationModel>(TrackProblem<TranslationModel>&);
template TrackFit<RotationModel> fitTracks<RotationModel>(TrackProblem<RotationModel>&);

}} // namespace cv::active_handeye
