// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// Stripes in the joint refinement: segments as pairs of ends, surfaces fixed in the base frame.
#include "precomp.hpp"
#include "refinement.hpp"
#include "residuals.hpp"

#include <map>

namespace cv { namespace active_handeye {

using Eigen::Vector3d;
using Eigen::Vector4d;

static const double associationTolerance = 5; // px: a first light plane and first poses predict a stripe to this
static const int minSegments = 2;             // of a surface: each gives two equations for three unknowns

//! Ends of the lines of all segments whose surface is known.
void HandEyeRefinement::addSegments()
{
    const Camera& camera = calibration().camera;
    std::map<int, int> indexOfId;
    std::vector<double> sigmas;
    for (int i = 0; i < int(measurements_.stripes.size()); ++i)
    {
        const int id = measurements_.surfaceIds[i];
        if (id < 0)
            continue;
        const StripeLine line = readStripeLine(measurements_.stripes[i], camera, i);
        const int surface = indexOfId.insert(std::make_pair(id, int(indexOfId.size()))).first->second;
        StripeSegment segment = {i, measurements_.stripeViews[i], surface, {}, 1, true};
        for (int end = 0; end < 2; ++end)
            segment.ends[end] = recordedEnd(line, camera, end);
        sigmas.push_back(measurements_.stripeSigmas.empty() ? line.sigma : measurements_.stripeSigmas[i]);
        segments_.push_back(segment);
    }
    std::vector<double> sorted = sigmas;
    std::sort(sorted.begin(), sorted.end());
    const double unit = measurements_.stripeSigmas.empty() && !sorted.empty() ? sorted[sorted.size() / 2] : 1;
    for (size_t i = 0; i < segments_.size(); ++i)
        segments_[i].inverseSigma = unit / sigmas[i];
    if (!isLevelGiven(NOISE_STRIPE))
        problem_.noise.stripe = unit;
    problem_.state.surfaces.assign(indexOfId.size(), Vector4d::UnitW());
}

namespace {

//! Plane nearest to points of the base frame, as (w, e) of length 1.
Vector4d fitPlane(const AlignedVector<Vector3d>& points)
{
    Vector3d centre = Vector3d::Zero();
    for (const Vector3d& X : points)
        centre += X / double(points.size());
    Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
    for (const Vector3d& X : points)
        scatter += (X - centre) * (X - centre).transpose();
    const Vector3d w = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(scatter).eigenvectors().col(0);
    Vector4d plane;
    plane << w, w.dot(centre);
    return plane.normalized();
}

double segmentError(const CalibrationState& state, const CameraViews& views, const StripeSegment& segment,
                    const Vector4d& surface)
{
    double worst = 0;
    for (int end = 0; end < 2; ++end)
    {
        StripeResidual residual;
        if (!residual.linearize(state.calibration, views[segment.view], surface, segment.ends[end]))
            return std::numeric_limits<double>::infinity();
        worst = std::max(worst, std::abs(residual.error));
    }
    return worst;
}

//! Where the ends of a segment lie on the light plane, base frame.
void appendEnds(const CalibrationState& state, const CameraViews& views, const StripeSegment& segment,
                AlignedVector<Vector3d>& points)
{
    const CameraView& view = views[segment.view];
    const LightPlane& light = state.calibration.light;
    for (int end = 0; end < 2; ++end)
    {
        const Vector3d m = state.calibration.camera.ray(segment.ends[end]);
        points.push_back(view.R_cam2base * (m * (light.d / light.n.dot(m))) + view.centre);
    }
}

} // namespace

//! Puts every surface where most of its segments agree, and leaves the others out.
void HandEyeRefinement::placeSurfaces()
{
    const CameraViews views = problem_.state.views();
    for (int surface = 0; surface < int(problem_.state.surfaces.size()); ++surface)
    {
        std::vector<StripeSegment*> own;
        for (StripeSegment& segment : segments_)
            if (segment.surface == surface && segment.used)
                own.push_back(&segment);
        int most = 0;
        Vector4d best = Vector4d::UnitW();
        for (size_t a = 0; a < own.size(); ++a)
            for (size_t b = a + 1; b < own.size(); ++b)
            {
                AlignedVector<Vector3d> points;
                appendEnds(problem_.state, views, *own[a], points);
                appendEnds(problem_.state, views, *own[b], points);
                const Vector4d plane = fitPlane(points);
                int agreeing = 0;
                for (const StripeSegment* segment : own)
                    agreeing += segmentError(problem_.state, views, *segment, plane) < associationTolerance;
                if (agreeing > most)
                    most = agreeing, best = plane;
            }
        AlignedVector<Vector3d> points;
        for (StripeSegment* segment : own)
        {
            segment->used = segmentError(problem_.state, views, *segment, best) < associationTolerance;
            if (segment->used)
                appendEnds(problem_.state, views, *segment, points);
        }
        problem_.state.surfaces[surface] = points.empty() ? best : fitPlane(points);
    }
}

//! Forgets surfaces with too few segments, whose planes nothing determines.
void HandEyeRefinement::compactSurfaces()
{
    std::vector<int> count(problem_.state.surfaces.size()), index(count.size(), -1);
    for (const StripeSegment& segment : segments_)
        count[segment.surface] += segment.used;
    AlignedVector<Vector4d> kept;
    for (size_t s = 0; s < count.size(); ++s)
        if (count[s] >= minSegments)
        {
            index[s] = int(kept.size());
            kept.push_back(problem_.state.surfaces[s]);
        }
    StripeSegments remaining;
    for (StripeSegment segment : segments_)
    {
        const int surface = index[segment.surface];
        if (!segment.used || surface < 0)
        {
            leftOutSegments_.push_back(segment.segment);
            continue;
        }
        segment.surface = surface;
        remaining.push_back(segment);
    }
    segments_.swap(remaining);
    problem_.state.surfaces.swap(kept);
    setUnknowns();
}

//! Leaves out segments far from where the fit predicts them. Returns whether there were any.
bool HandEyeRefinement::leaveOutSegments()
{
    const double limit = 6; // times the median of the larger errors of the two ends, which is 1.2 sigma
    const CameraViews views = problem_.state.views();
    std::vector<double> errors;
    for (const StripeSegment& segment : segments_)
        errors.push_back(segmentError(problem_.state, views, segment, problem_.state.surfaces[segment.surface]) *
                         segment.inverseSigma);
    std::vector<double> sorted = errors;
    std::sort(sorted.begin(), sorted.end());
    bool any = false;
    for (size_t i = 0; i < segments_.size(); ++i)
        if (errors[i] > limit * std::max(sorted[sorted.size() / 2], 1e-6))
        {
            segments_[i].used = false;
            any = true;
        }
    return any;
}

void HandEyeRefinement::fitStripes(const LightPlane& start)
{
    problem_.state.calibration.light = start;
    addSegments();
    useStripes_ = true;
    placeSurfaces();
    compactSurfaces();
    const int maxRounds = 5;
    for (int round = 0; round < maxRounds; ++round)
    {
        if (segments_.empty())
            CV_Error(Error::StsNoConv,
                     "refineHandEye: stripePoints do not agree on any surface; needed two or more segments "
                     "for one id in surfaceIds that lie on one plane fixed in the base frame");
        fit(1e-10);
        if (!leaveOutSegments())
            break;
        compactSurfaces();
    }
    testLens();
}

void HandEyeRefinement::summarizeStripes(RefineSummary& summary) const
{
    const double NaN = std::numeric_limits<double>::quiet_NaN();
    Eigen::MatrixXd residuals = Eigen::MatrixXd::Constant(measurements_.stripes.size(), 2, NaN);
    const CameraViews views = problem_.state.views();
    for (const StripeSegment& segment : segments_)
        for (int end = 0; end < 2; ++end)
        {
            StripeResidual residual;
            residual.linearize(calibration(), views[segment.view], problem_.state.surfaces[segment.surface],
                               segment.ends[end]);
            residuals(segment.segment, end) = residual.error;
        }
    writeMatrix(residuals, summary.stripeResiduals);
    summary.rejectedSegments = leftOutSegments_;
    std::sort(summary.rejectedSegments.begin(), summary.rejectedSegments.end());
}

}} // namespace cv::active_handeye
