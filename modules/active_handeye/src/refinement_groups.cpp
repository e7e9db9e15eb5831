// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// What the stripes of each group of equal orientation contribute to the light plane.
#include "precomp.hpp"
#include "motion_groups.hpp"
#include "refinement.hpp"

#include <set>

namespace cv { namespace active_handeye {

using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector4d;

static bool isAmong(const std::vector<int>& views, int view)
{
    return std::find(views.begin(), views.end(), view) != views.end();
}

//! Segments of other views, on the surfaces whose planes they still determine, renumbered; `surfaces` are these.
static StripeSegments segmentsWithout(const std::vector<int>& views, const StripeSegments& segments,
                                      AlignedVector<Vector4d>& surfaces)
{
    std::vector<int> count(surfaces.size()), index(surfaces.size(), -1);
    for (const StripeSegment& segment : segments)
        count[segment.surface] += !isAmong(views, segment.view);
    AlignedVector<Vector4d> kept;
    for (size_t s = 0; s < surfaces.size(); ++s)
        if (count[s] >= 2)
        {
            index[s] = int(kept.size());
            kept.push_back(surfaces[s]);
        }
    surfaces.swap(kept);
    StripeSegments remaining;
    for (StripeSegment segment : segments)
        if (!isAmong(views, segment.view) && index[segment.surface] >= 0)
        {
            segment.surface = index[segment.surface];
            remaining.push_back(segment);
        }
    return remaining;
}

//! Of normal (rad) and offset; infinite when the other stripes do not determine the light plane.
Vector2d HandEyeRefinement::lightPlaneDeviationsWithout(const std::vector<int>& views) const
{
    Vector2d unknown = Vector2d::Constant(std::numeric_limits<double>::infinity());
    CalibrationState state = problem_.state;
    StripeSegments segments = segmentsWithout(views, segments_, state.surfaces);
    if (segments.empty())
        return unknown;
    SceneTracks tracks = tracks_;
    RefineProblem others(tracks, segments, measurements_.gripper2base, state, params_.huberThreshold);
    others.unknowns = problem_.unknowns;
    others.unknowns.surfaces = int(state.surfaces.size());
    others.noise = problem_.noise;
    others.updateClipping();
    others.linearizeData();
    const bool allFixed[] = {true, true, true, true};
    const double noFloors[] = {0, 0, 0, 0};
    const VarianceComponents components(others, allFixed, noFloors);
    const MatrixXd& B = problem_.unknowns.calibration;
    const double largestInflation = 1e11;
    if (!(components.varianceInflation(int(B.cols())) < largestInflation))
        return unknown;
    const MatrixXd J = B.bottomRows(3); // tangent of the normal (2), offset
    const Eigen::Matrix3d covariance = J * components.covariance().topLeftCorner(B.cols(), B.cols()) * J.transpose();
    return Vector2d(std::sqrt(covariance(0, 0) + covariance(1, 1)), std::sqrt(covariance(2, 2)));
}

void HandEyeRefinement::summarizeStripeGroups(RefineSummary& summary) const
{
    std::vector<Eigen::Matrix<double, 1, 6>, Eigen::aligned_allocator<Eigen::Matrix<double, 1, 6>>> rows;
    for (const MotionGroup& group : groupByOrientation(measurements_.gripper2base, params_.orientationTolerance))
    {
        std::set<int> views, surfaces;
        int count = 0;
        for (const StripeSegment& segment : segments_)
            if (isAmong(group.views, segment.view))
            {
                views.insert(segment.view);
                surfaces.insert(segment.surface);
                ++count;
            }
        if (count == 0)
            continue;
        const Vector2d deviations = lightPlaneDeviationsWithout(group.views);
        Eigen::Matrix<double, 1, 6> row;
        row << group.views[0], double(views.size()), count, double(surfaces.size()), deviations(0), deviations(1);
        rows.push_back(row);
    }
    MatrixXd table(rows.size(), 6);
    for (size_t i = 0; i < rows.size(); ++i)
        table.row(i) = rows[i];
    writeMatrix(table, summary.stripeGroups);
}

}} // namespace cv::active_handeye
