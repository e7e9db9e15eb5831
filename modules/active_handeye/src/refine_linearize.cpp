// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// Normal equations of the joint refinement with the scene points eliminated (Schur complement).
#include "precomp.hpp"
#include "refine_problem.hpp"
#include "residuals.hpp"

#include "opencv2/core/utility.hpp"

namespace cv { namespace active_handeye {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

typedef Eigen::Matrix<double, 3, 6> Matrix36d;
typedef Eigen::Matrix<double, POINT_COLUMNS, 3> CalibrationByPoint;

namespace {

//! Columns before the calibration is restricted to its free directions.
struct Layout
{
    explicit Layout(const RefineUnknowns& unknowns) : shift(CALIBRATION_COLUMNS - int(unknowns.calibration.cols()))
    {
        object = unknowns.object ? unknowns.objectColumn() + shift : -1;
        for (int view = 0; view < int(unknowns.poses.size()); ++view)
            pose.push_back(unknowns.poses[view] == POSE_EXACT ? -1 : unknowns.poseColumn(view) + shift);
        size = unknowns.count() + shift;
    }

    int shift, object, size;
    std::vector<int> pose;
};

//! J^T J (upper triangle) and J^T r of the tracks added, each scene point eliminated.
class PointEquations
{
public:
    PointEquations(const SceneTracks& tracks, const CalibrationState& state, const CameraViews& views,
                   const Layout& layout, double huberLimit, double meanSlope)
        : tracks_(tracks), state_(state), views_(views), layout_(layout), huberLimit_(huberLimit),
          meanSlope_(meanSlope), local_(views.size(), -1)
    {
        term.JtJ.setZero(layout.size, layout.size);
        term.Jtr.setZero(layout.size);
    }

    //! Tracks that are eliminated together: the more views they share the better.
    void addChunk(const int* begin, const int* end)
    {
        chooseColumns(begin, end);
        byPoints_.setZero(rows_, 3 * (end - begin));
        pulls_.setZero(3 * (end - begin));
        int at = 0;
        for (const int* track = begin; track != end; ++track)
            at += addTrack(*track, at);
        subtractEliminated(at);
    }

    DataTerm term;

private:
    //! Gathers the columns of all views that the tracks were seen in.
    void chooseColumns(const int* begin, const int* end)
    {
        std::fill(local_.begin(), local_.end(), -1);
        for (const int* track = begin; track != end; ++track)
            for (int i = tracks_.first[*track]; i < tracks_.first[*track + 1]; ++i)
                if (tracks_.observations[i].used && layout_.pose[tracks_.observations[i].view] >= 0)
                    local_[tracks_.observations[i].view] = 0;
        columns_.clear();
        rows_ = POINT_COLUMNS;
        for (size_t view = 0; view < local_.size(); ++view)
            if (local_[view] == 0)
            {
                local_[view] = rows_;
                columns_.push_back(layout_.pose[view]);
                rows_ += 6;
            }
    }

    //! Returns how many eliminated columns the track has: 3, or 0 for a known point.
    int addTrack(int track, int at)
    {
        Matrix3d A = Matrix3d::Zero();
        Vector3d b = Vector3d::Zero();
        for (int i = tracks_.first[track]; i < tracks_.first[track + 1]; ++i)
            if (tracks_.observations[i].used)
                addObservation(tracks_.observations[i], track, at, A, b);
        if (tracks_.isKnown(track))
            return 0;
        term.redundancy -= 3;
        const Eigen::LLT<Matrix3d> llt(A); // W A^-1 W^T = (W L^-T) (W L^-T)^T
        llt.matrixU().solveInPlace<Eigen::OnTheRight>(byPoints_.middleCols<3>(at));
        pulls_.segment<3>(at) = llt.matrixL().solve(b);
        return 3;
    }

    void addObservation(const PointObservation& o, int track, int at, Matrix3d& sumA, Vector3d& sumB)
    {
        const Vector3d& X = state_.points[track];
        const CameraView& view = views_[o.view];
        PointResidual residual;
        if (!residual.linearize(state_.calibration.camera, view, X, o.pixel))
            return;
        const double information = o.inverseSigma * o.inverseSigma;
        const double pull = std::min(1., huberLimit_ / (residual.error.norm() * o.inverseSigma)) / meanSlope_;
        const Eigen::Vector2d pulled = pull * residual.error;
        const Eigen::Matrix<double, 2, 3> D = information * residual.byPoint;
        const Matrix3d A = residual.byPoint.transpose() * D;
        const CalibrationByPoint B = residual.byCalibration.transpose() * D;
        const Vector3d b = D.transpose() * pulled;
        term.squares += information * pulled.squaredNorm();
        term.redundancy += 2;
        term.JtJ.topLeftCorner<POINT_COLUMNS, POINT_COLUMNS>().noalias() +=
            information * residual.byCalibration.transpose() * residual.byCalibration;
        term.Jtr.head<POINT_COLUMNS>().noalias() += information * residual.byCalibration.transpose() * pulled;
        Matrix36d pose, object; // how a step of the robot's or the object's pose moves the point, seen from the camera
        pose << skew(X - view.gripper.t), -Matrix3d::Identity();
        const int poseColumn = layout_.pose[o.view];
        if (poseColumn >= 0)
            addRigid(pose, poseColumn, A, B, b);
        if (tracks_.isKnown(track))
        {
            object << skew(state_.object2base.t - X), Matrix3d::Identity();
            addRigid(object, layout_.object, A, B, b);
            if (poseColumn >= 0)
                term.JtJ.block<6, 6>(layout_.object, poseColumn).noalias() += object.transpose() * (A * pose);
            return;
        }
        sumA += A;
        sumB += b;
        byPoints_.block<POINT_COLUMNS, 3>(0, at) += B;
        if (poseColumn >= 0)
            byPoints_.block<6, 3>(local_[o.view], at).noalias() = pose.transpose() * A;
    }

    void addRigid(const Matrix36d& motion, int column, const Matrix3d& A, const CalibrationByPoint& B,
                  const Vector3d& b)
    {
        term.JtJ.block<6, 6>(column, column).noalias() += motion.transpose() * (A * motion);
        term.JtJ.block<POINT_COLUMNS, 6>(0, column).noalias() += B * motion;
        term.Jtr.segment<6>(column).noalias() += motion.transpose() * b;
    }

    void subtractEliminated(int eliminated)
    {
        if (eliminated == 0)
            return;
        const auto W = byPoints_.leftCols(eliminated);
        product_.setZero(rows_, rows_);
        product_.selfadjointView<Eigen::Upper>().rankUpdate(W);
        const VectorXd pull = W * pulls_.head(eliminated);
        term.squares -= pulls_.head(eliminated).squaredNorm();
        term.JtJ.topLeftCorner<POINT_COLUMNS, POINT_COLUMNS>() -=
            product_.topLeftCorner<POINT_COLUMNS, POINT_COLUMNS>();
        term.Jtr.head<POINT_COLUMNS>() -= pull.head<POINT_COLUMNS>();
        for (size_t j = 0; j < columns_.size(); ++j)
        {
            const int local = POINT_COLUMNS + 6 * int(j);
            term.Jtr.segment<6>(columns_[j]) -= pull.segment<6>(local);
            term.JtJ.block<POINT_COLUMNS, 6>(0, columns_[j]) -= product_.block<POINT_COLUMNS, 6>(0, local);
            for (size_t i = 0; i <= j; ++i)
                term.JtJ.block<6, 6>(columns_[i], columns_[j]) -=
                    product_.block<6, 6>(POINT_COLUMNS + 6 * int(i), local);
        }
    }

    const SceneTracks& tracks_;
    const CalibrationState& state_;
    const CameraViews& views_;
    const Layout& layout_;
    const double huberLimit_, meanSlope_;
    std::vector<int> local_;   //!< per view: its first row in the chunk, -1 = none
    std::vector<int> columns_; //!< of the chunk's views
    int rows_ = 0;
    MatrixXd byPoints_, product_;
    VectorXd pulls_;
};

//! Upper triangle with 19 calibration columns -> symmetric, with the free directions only.
void restrict(const RefineUnknowns& unknowns, DataTerm& term)
{
    const MatrixXd& B = unknowns.calibration;
    const int rest = int(term.JtJ.rows()) - CALIBRATION_COLUMNS, n = int(B.cols()) + rest;
    const MatrixXd full = term.JtJ.selfadjointView<Eigen::Upper>();
    MatrixXd JtJ(n, n);
    JtJ.topLeftCorner(B.cols(), B.cols()) =
        B.transpose() * full.topLeftCorner<CALIBRATION_COLUMNS, CALIBRATION_COLUMNS>() * B;
    JtJ.topRightCorner(B.cols(), rest) = B.transpose() * full.topRightCorner(CALIBRATION_COLUMNS, rest);
    JtJ.bottomLeftCorner(rest, B.cols()) = JtJ.topRightCorner(B.cols(), rest).transpose();
    JtJ.bottomRightCorner(rest, rest) = full.bottomRightCorner(rest, rest);
    VectorXd Jtr(n);
    Jtr << B.transpose() * term.Jtr.head<CALIBRATION_COLUMNS>(), term.Jtr.tail(rest);
    term.JtJ.swap(JtJ);
    term.Jtr.swap(Jtr);
}

} // namespace

Eigen::Matrix<double, 4, 3> surfaceTangent(const Eigen::Vector4d& surface)
{
    const Eigen::Vector4d u =
        (surface + (surface(0) < 0 ? -1 : 1) * Eigen::Vector4d::Unit(0)).normalized(); // Householder
    return (Eigen::Matrix4d::Identity() - 2 * u * u.transpose()).rightCols<3>();
}

//! Chunks of tracks that share most of their views.
static std::vector<int> chunkBounds(const SceneTracks& tracks, const std::vector<int>& used)
{
    const int largestChunk = 64;
    std::vector<int> bounds(1, 0);
    for (int i = 0; i < int(used.size()); ++i)
    {
        const int head = used[bounds.back()], size = i - bounds.back();
        const int lengthOfHead = tracks.first[head + 1] - tracks.first[head];
        const int length = tracks.first[used[i] + 1] - tracks.first[used[i]];
        const bool isAlike =
            length == lengthOfHead &&
            std::equal(tracks.observations.begin() + tracks.first[head],
                       tracks.observations.begin() + tracks.first[head + 1],
                       tracks.observations.begin() + tracks.first[used[i]],
                       [](const PointObservation& a, const PointObservation& b) { return a.view == b.view; });
        if (size == largestChunk || (size > 0 && !isAlike))
            bounds.push_back(i);
    }
    bounds.push_back(int(used.size()));
    return bounds;
}

void RefineProblem::linearizePoints()
{
    std::vector<int> used;
    for (int track : order_)
        if (tracks.isUsed(track))
            used.push_back(track);
    const std::vector<int> bounds = chunkBounds(tracks, used);
    const int chunks = int(bounds.size()) - 1, pointsOfPart = 2000;
    const int parts =
        std::max(1, std::min(8, int(used.size()) / pointsOfPart)); // does not depend on the number of threads
    const Layout layout(unknowns);
    const CameraViews views = state.views();
    std::vector<DataTerm> sums(parts);
    parallel_for_(Range(0, parts),
                  [&](const Range& range)
                  {
                      for (int part = range.start; part < range.end; ++part)
                      {
                          PointEquations equations(tracks, state, views, layout, huberThreshold_ * noise.point,
                                                   meanSlope_);
                          for (int c = chunks * part / parts; c < chunks * (part + 1) / parts; ++c)
                              equations.addChunk(used.data() + bounds[c], used.data() + bounds[c + 1]);
                          sums[part] = equations.term;
                      }
                  });
    points_ = sums[0];
    for (int part = 1; part < parts; ++part)
    {
        points_.JtJ += sums[part].JtJ;
        points_.Jtr += sums[part].Jtr;
        points_.squares += sums[part].squares;
        points_.redundancy += sums[part].redundancy;
    }
    restrict(unknowns, points_);
}

void RefineProblem::linearizeStripes()
{
    const Layout layout(unknowns);
    stripes_ = DataTerm();
    stripes_.JtJ.setZero(layout.size, layout.size);
    stripes_.Jtr.setZero(layout.size);
    const CameraViews views = state.views();
    for (const StripeSegment& segment : segments)
        for (int end = 0; segment.used && end < 2; ++end)
        {
            const Eigen::Vector4d& surface = state.surfaces[segment.surface];
            StripeResidual residual;
            if (!residual.linearize(state.calibration, views[segment.view], surface, segment.ends[end]))
                continue;
            VectorXd J = VectorXd::Zero(layout.size);
            J.head<CALIBRATION_COLUMNS>() = residual.byCalibration;
            J.segment<3>(unknowns.surfaceColumn(segment.surface) + layout.shift) =
                residual.bySurface * surfaceTangent(surface);
            if (layout.pose[segment.view] >= 0)
                J.segment<6>(layout.pose[segment.view]) = residual.byPose;
            J *= segment.inverseSigma;
            const double r = residual.error * segment.inverseSigma;
            stripes_.JtJ.selfadjointView<Eigen::Upper>().rankUpdate(J);
            stripes_.Jtr += r * J;
            stripes_.squares += r * r;
            ++stripes_.redundancy;
        }
    restrict(unknowns, stripes_);
}

void RefineProblem::linearizeData()
{
    linearizePoints();
    if (unknowns.surfaces > 0)
        linearizeStripes();
}

}} // namespace cv::active_handeye
