// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "track_elimination.hpp"

namespace cv { namespace active_handeye {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

Matrix3d full(const SymmetricForm& form)
{
    Matrix3d M;
    M << form[0], form[1], form[2], form[1], form[3], form[4], form[2], form[4], form[5];
    return M;
}

} // namespace

Eigen::Matrix<double, 3, 9> TranslationModel::D() const
{
    Eigen::Matrix<double, 3, 9> product = Eigen::Matrix<double, 3, 9>::Zero();
    for (int row = 0; row < 3; ++row)
        product.block<1, 3>(row, 3 * row) = -b.transpose();
    return product;
}

Vector3d TranslationModel::shift(const Vector9d& p) const
{
    return Vector3d(-b.dot(p.segment<3>(0)), -b.dot(p.segment<3>(3)), -b.dot(p.segment<3>(6)));
}

inline void TranslationModel::Sums::add(const SymmetricForm& M, const TranslationModel& model)
{
    sums_.col(0) += M;
    for (int k = 0; k < 3; ++k)
        sums_.col(1 + k) += model.b[k] * M;
}

inline Matrix3d TranslationModel::Sums::M() const
{
    return full(sums_.col(0));
}

inline Eigen::Matrix<double, 3, 9, Eigen::RowMajor> TranslationModel::Sums::MD() const
{
    Eigen::Matrix<double, 3, 9, Eigen::RowMajor> product;
    for (int k = 0; k < 3; ++k)
    {
        const Matrix3d timesB = full(sums_.col(1 + k));
        for (int row = 0; row < 3; ++row)
            product.col(3 * row + k) = -timesB.col(row);
    }
    return product;
}

inline void RotationModel::Sums::add(const SymmetricForm& M, const RotationModel& model)
{
    M_ += M;
    product_.row(0) += M[0] * model.negative.row(0) + M[1] * model.negative.row(1) + M[2] * model.negative.row(2);
    product_.row(1) += M[1] * model.negative.row(0) + M[3] * model.negative.row(1) + M[4] * model.negative.row(2);
    product_.row(2) += M[2] * model.negative.row(0) + M[4] * model.negative.row(1) + M[5] * model.negative.row(2);
}

inline Matrix3d RotationModel::Sums::M() const
{
    return full(M_);
}

void Tracks::add(const std::vector<Pixels>& pixels, const std::vector<int>& views)
{
    const size_t points = pixels[0].size();
    observations.reserve(pixels.size() * points); // at once: memory that grows in steps costs as much as the solution
    for (size_t point = 0; point < points; ++point)
    {
        for (int view : views)
            if (!std::isnan(pixels[view][point].x()))
                observations.push_back(Observation{view, int(point), pixels[view][point], pixels[view][point],
                                                   SymmetricForm::Zero()});
        if (int(observations.size()) - first.back() >= 2)
            first.push_back(int(observations.size()));
        else
            observations.resize(first.back());
    }
}

void Tracks::setForms(const AlignedVector<Matrix3d>& toImage)
{
    for (Observation& observation : observations)
    {
        const Matrix3d& A = toImage[observation.view];
        const Vector3d u = A.row(0) - observation.x.x() * A.row(2), v = A.row(1) - observation.x.y() * A.row(2);
        observation.form << u[0] * u[0] + v[0] * v[0], u[0] * u[1] + v[0] * v[1], u[0] * u[2] + v[0] * v[2],
            u[1] * u[1] + v[1] * v[1], u[1] * u[2] + v[1] * v[2], u[2] * u[2] + v[2] * v[2];
    }
}

JitterMotion Tracks::jitterMotion(const Observation& observation) const
{
    const double x = observation.measured.x() / focalLength, y = observation.measured.y() / focalLength;
    JitterMotion E;
    E << 1, 0, -y, 0, 1, x;
    return E;
}

void Tracks::removeJitter(const Eigen::VectorXd& jitter)
{
    for (Observation& observation : observations)
        observation.x = observation.measured -
                        jitterMotion(observation) * jitter.segment<JITTER_NUMBERS>(JITTER_NUMBERS * observation.view);
}

double Tracks::medianParallax() const
{
    std::vector<double> parallax;
    for (int j = 0; j < count(); ++j)
    {
        Eigen::AlignedBox2d box;
        for (int o = first[j]; o < first[j + 1]; ++o)
            box.extend(observations[o].measured);
        parallax.push_back(box.diagonal().norm());
    }
    if (parallax.empty())
        return 0;
    std::nth_element(parallax.begin(), parallax.begin() + parallax.size() / 2, parallax.end());
    return parallax[parallax.size() / 2];
}

template <int Q>
inline void EliminatedPoint<Q>::set(const Matrix3d& A, const Rows& B, int observations)
{
    const double d0 = A(0, 0);
    l10_ = A(1, 0) / d0;
    l20_ = A(2, 0) / d0;
    const double d1 = A(1, 1) - l10_ * A(1, 0), below = A(2, 1) - l20_ * A(1, 0);
    l21_ = below / d1;
    const double d2 = A(2, 2) - l20_ * A(2, 0) - l21_ * below;
    inversePivots_ << 1 / d0, 1 / d1, 1 / d2;
    const double minimumPivotRatio = 1e-14;
    usable_ = observations >= 2 && std::min(d0, std::min(d1, d2)) > minimumPivotRatio * std::max(d0, std::max(d1, d2));
    reduced_ = B;
    solveLower(reduced_);
}

template <int Q>
inline Vector3d EliminatedPoint<Q>::at(const Eigen::Matrix<double, Q, 1>& p) const
{
    Vector3d Z = -inversePivots_.cwiseProduct(reduced_ * p);
    Z[1] -= l21_ * Z[2];
    Z[0] -= l10_ * Z[1] + l20_ * Z[2];
    return Z;
}

template <class Model>
Eigen::Matrix<double, Model::parameters, Model::parameters>
eliminateTracks(const Tracks& tracks, const AlignedVector<Model>& models, const std::vector<double>& weights,
                AlignedVector<EliminatedPoint<Model::parameters>>& points)
{
    enum
    {
        Q = Model::parameters
    };
    Eigen::Matrix<double, Q, Q> S = Eigen::Matrix<double, Q, Q>::Zero(); // lower triangle, until the end
    AlignedVector<SymmetricForm> perView(models.size(), SymmetricForm::Zero());
    points.resize(tracks.count());
    for (int j = 0; j < tracks.count(); ++j)
    {
        typename Model::Sums sums;
        int used = 0;
        for (int o = tracks.first[j]; o < tracks.first[j + 1]; ++o)
        {
            const Observation& observation = tracks.observations[o];
            sums.add(weights[o] * observation.form, models[observation.view]);
            used += weights[o] > 0;
        }
        points[j].set(sums.M(), sums.MD(), used);
        if (!points[j].usable())
            continue;
        const typename EliminatedPoint<Q>::Rows& B = points[j].reduced();
        for (int i = 0; i < Q; ++i)
        {
            const Vector3d column = points[j].inversePivots().cwiseProduct(B.col(i));
            for (int k = i; k < Q; ++k)
                S(k, i) -= B(0, k) * column[0] + B(1, k) * column[1] + B(2, k) * column[2];
        }
        for (int o = tracks.first[j]; o < tracks.first[j + 1]; ++o)
            perView[tracks.observations[o].view] += weights[o] * tracks.observations[o].form;
    }
    S = S.template selfadjointView<Eigen::Lower>();
    for (size_t view = 0; view < models.size(); ++view)
        S.noalias() += models[view].D().transpose() * full(perView[view]) * models[view].D();
    return S;
}

template <class Model>
void evaluateTracks(const Tracks& tracks, const AlignedVector<Model>& models, const AlignedVector<Matrix3d>& toImage,
                    const AlignedVector<EliminatedPoint<Model::parameters>>& points,
                    const Eigen::Matrix<double, Model::parameters, 1>& p, TrackResiduals& residuals)
{
    residuals.depth.assign(tracks.observations.size(), std::numeric_limits<double>::quiet_NaN());
    residuals.squared = residuals.depth;
    residuals.residual.resize(tracks.observations.size());
    AlignedVector<Vector3d> shift;
    for (const Model& model : models)
        shift.push_back(model.shift(p));
    for (int j = 0; j < tracks.count(); ++j)
    {
        if (!points[j].usable())
            continue;
        const Vector3d Z = points[j].at(p);
        for (int o = tracks.first[j]; o < tracks.first[j + 1]; ++o)
        {
            const Observation& observation = tracks.observations[o];
            const Vector3d image = toImage[observation.view] * (Z + shift[observation.view]);
            residuals.depth[o] = image.z();
            residuals.residual[o] = observation.x - image.head<2>() / image.z();
            residuals.squared[o] = residuals.residual[o].squaredNorm();
        }
    }
}

template Matrix9d eliminateTracks<TranslationModel>(const Tracks&, const AlignedVector<TranslationModel>&,
                                                    const std::vector<double>&, AlignedVector<EliminatedPoint<9>>&);
template Eigen::Matrix4d eliminateTracks<RotationModel>(const Tracks&, const AlignedVector<RotationModel>&,
                                                        const std::vector<double>&, AlignedVector<EliminatedPoint<4>>&);
template void evaluateTracks<TranslationModel>(const Tracks&, const AlignedVector<TranslationModel>&,
                                               const AlignedVector<Matrix3d>&, const AlignedVector<EliminatedPoint<9>>&,
                                               const Vector9d&, TrackResiduals&);
template void evaluateTracks<RotationModel>(const Tracks&, const AlignedVector<RotationModel>&,
                                            const AlignedVector<Matrix3d>&, const AlignedVector<EliminatedPoint<4>>&,
                                            const Eigen::Vector4d&, TrackResiduals&);

}} // namespace cv::active_handeye
