// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "closed_forms.hpp"
#include "track_fitter.hpp"
#include "opencv2/core/utils/logger.hpp"

namespace cv { namespace active_handeye {

namespace {

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
    TrackFitter<Model> fitter(problem);
    const double parallax = fitter.parallax(), pixels = problem.pixelsPerUnit;
    if (!(parallax * pixels > 1e-6))
        CV_Error(
            Error::StsNoConv,
            cv::format("%s: imagePoints have no parallax; needed points that move between the views, given a median "
                       "displacement of %.3g px in %d tracks",
                       function, parallax * pixels, problem.tracks.count()));
    fitter.run();
    fitter.excludeContradictingViews();
    if (!fitter.isBehindCamera() && fitter.viewsJitter())
        fitter.estimateJitter();
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
    return fit;
}

void warnOfRejectedViews(const char* function, const ViewDoubts& doubts)
{
    if (!doubts.rejectedViews.empty())
        CV_LOG_WARNING(NULL, function << ": views " << listOf(doubts.rejectedViews)
                                      << " contradict the other views and were not used: check their "
                                      << "R_gripper2base, t_gripper2base and imagePoints");
}

template <class Model>
double rmsOfTracks(TrackProblem<Model>& problem)
{
    TrackFitter<Model> fitter(problem);
    fitter.run();
    return fitter.result().rms();
}

template double rmsOfTracks<TranslationModel>(TrackProblem<TranslationModel>&);
template TrackFit<TranslationModel> fitTracks<TranslationModel>(TrackProblem<TranslationModel>&);
template TrackFit<RotationModel> fitTracks<RotationModel>(TrackProblem<RotationModel>&);

}} // namespace cv::active_handeye
