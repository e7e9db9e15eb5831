// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// Normal equations of the joint refinement with the scene points eliminated.
#include "precomp.hpp"
#include "point_equations.hpp"
#include "residuals.hpp"

#include "opencv2/core/utility.hpp"

namespace cv { namespace active_handeye {

using Eigen::MatrixXd;
using Eigen::VectorXd;

//! Upper triangle with 19 calibration columns -> symmetric, with the free directions only.
static DataTerm restrict(const RefineUnknowns& unknowns, const DataTerm& all)
{
    const MatrixXd& B = unknowns.calibration;
    const int rest = int(all.JtJ.rows()) - CALIBRATION_COLUMNS, n = int(B.cols()) + rest;
    const Eigen::Matrix<double, CALIBRATION_COLUMNS, CALIBRATION_COLUMNS> calibration =
        all.JtJ.topLeftCorner<CALIBRATION_COLUMNS, CALIBRATION_COLUMNS>().selfadjointView<Eigen::Upper>();
    DataTerm term;
    term.squares = all.squares;
    term.redundancy = all.redundancy;
    term.JtJ.resize(n, n);
    term.JtJ.topLeftCorner(B.cols(), B.cols()) = B.transpose() * calibration * B;
    term.JtJ.topRightCorner(B.cols(), rest) = B.transpose() * all.JtJ.topRightCorner(CALIBRATION_COLUMNS, rest);
    term.JtJ.bottomLeftCorner(rest, B.cols()) = term.JtJ.topRightCorner(B.cols(), rest).transpose();
    term.JtJ.bottomRightCorner(rest, rest) = all.JtJ.bottomRightCorner(rest, rest).selfadjointView<Eigen::Upper>();
    term.Jtr.resize(n);
    term.Jtr << B.transpose() * all.Jtr.head<CALIBRATION_COLUMNS>(), all.Jtr.tail(rest);
    return term;
}

Eigen::Matrix<double, 4, 3> surfaceTangent(const Eigen::Vector4d& surface)
{
    const Eigen::Vector4d u =
        (surface + (surface(0) < 0 ? -1 : 1) * Eigen::Vector4d::Unit(0)).normalized(); // Householder
    return (Eigen::Matrix4d::Identity() - 2 * u * u.transpose()).rightCols<3>();
}

void RefineProblem::linearizePoints()
{
    std::vector<int> used;
    for (int track = 0; track < tracks.count(); ++track)
        if (tracks.isUsed(track))
            used.push_back(track);
    const int count = int(used.size()), pointsOfPart = 2000;
    const int parts = std::max(1, std::min(8, count / pointsOfPart)); // does not depend on the number of threads
    const AllColumns columns(unknowns);
    const CameraViews views = state.views();
    std::vector<DataTerm> sums(parts);
    parallel_for_(Range(0, parts),
                  [&](const Range& range)
                  {
                      for (int part = range.start; part < range.end; ++part)
                      {
                          PointEquations equations(tracks, state, views, columns, huberThreshold_ * noise.point,
                                                   meanSlope_);
                          for (int i = count * part / parts; i < count * (part + 1) / parts; ++i)
                              equations.addTrack(used[i]);
                          equations.finish();
                          sums[part] = equations.term;
                      }
                  });
    allPoints_ = sums[0];
    for (int part = 1; part < parts; ++part)
    {
        allPoints_.JtJ += sums[part].JtJ;
        allPoints_.Jtr += sums[part].Jtr;
        allPoints_.squares += sums[part].squares;
        allPoints_.redundancy += sums[part].redundancy;
    }
}

void RefineProblem::linearizeStripes()
{
    const AllColumns columns(unknowns);
    allStripes_ = DataTerm();
    allStripes_.JtJ.setZero(columns.size, columns.size);
    allStripes_.Jtr.setZero(columns.size);
    const CameraViews views = state.views();
    for (const StripeSegment& segment : segments)
        for (int end = 0; segment.used && end < 2; ++end)
        {
            const Eigen::Vector4d& surface = state.surfaces[segment.surface];
            StripeResidual residual;
            if (!residual.linearize(state.calibration, views[segment.view], surface, segment.ends[end]))
                continue;
            VectorXd J = VectorXd::Zero(columns.size);
            J.head<CALIBRATION_COLUMNS>() = residual.byCalibration;
            J.segment<3>(unknowns.surfaceColumn(segment.surface) + columns.shift) =
                residual.bySurface * surfaceTangent(surface);
            if (columns.pose[segment.view] >= 0)
                J.segment<6>(columns.pose[segment.view]) = residual.byPose;
            J *= segment.inverseSigma;
            const double r = residual.error * segment.inverseSigma;
            allStripes_.JtJ.selfadjointView<Eigen::Upper>().rankUpdate(J);
            allStripes_.Jtr += r * J;
            allStripes_.squares += r * r;
            ++allStripes_.redundancy;
        }
}

void RefineProblem::linearizeData()
{
    linearizePoints();
    if (unknowns.surfaces > 0)
        linearizeStripes();
    restrictData();
}

void RefineProblem::restrictData()
{
    points_ = restrict(unknowns, allPoints_);
    if (unknowns.surfaces > 0)
        stripes_ = restrict(unknowns, allStripes_);
}

}} // namespace cv::active_handeye
