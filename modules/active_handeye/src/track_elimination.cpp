// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "track_elimination.hpp"

namespace cv { namespace active_handeye {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

Eigen::Matrix<double, 3, 9> TranslationModel::D() const
{
    Eigen::Matrix<double, 3, 9> product = Eigen::Matrix<double, 3, 9>::Zero();
    addProduct(Matrix3d::Identity(), product);
    return product;
}

Vector3d TranslationModel::shift(const Vector9d& p) const
{
    return Vector3d(-b.dot(p.segment<3>(0)), -b.dot(p.segment<3>(3)), -b.dot(p.segment<3>(6)));
}

void TranslationModel::addProduct(const Matrix3d& M, Eigen::Matrix<double, 3, 9>& sum) const
{
    for (int row = 0; row < 3; ++row)
        for (int k = 0; k < 3; ++k)
            sum.col(3 * row + k) -= b[k] * M.col(row);
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
                                                   Matrix3d::Zero()});
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
        Eigen::Matrix<double, 2, 3> rows = A.topRows<2>();
        rows.noalias() -= observation.x * A.row(2);
        observation.form.noalias() = rows.transpose() * rows;
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

void EliminatedPoint::set(const Matrix3d& A, int observations)
{
    const double d0 = A(0, 0);
    l00_ = 1 / std::sqrt(d0);
    l10_ = A(1, 0) * l00_;
    l20_ = A(2, 0) * l00_;
    const double d1 = A(1, 1) - l10_ * l10_;
    l11_ = 1 / std::sqrt(d1);
    l21_ = (A(2, 1) - l20_ * l10_) * l11_;
    const double d2 = A(2, 2) - l20_ * l20_ - l21_ * l21_;
    l22_ = 1 / std::sqrt(d2);
    const double minimumPivotRatio = 1e-14;
    usable_ = observations >= 2 && std::min(d0, std::min(d1, d2)) > minimumPivotRatio * std::max(d0, std::max(d1, d2));
}

Vector3d EliminatedPoint::solve(const Vector3d& b) const
{
    Vector3d x = b;
    solveLower(x);
    x[2] *= l22_;
    x[1] = (x[1] - l21_ * x[2]) * l11_;
    x[0] = (x[0] - l10_ * x[1] - l20_ * x[2]) * l00_;
    return x;
}

template <class Model>
Eigen::Matrix<double, Model::parameters, Model::parameters>
eliminateTracks(const Tracks& tracks, const AlignedVector<Model>& models, const std::vector<double>& weights,
                AlignedVector<EliminatedPoint>& points)
{
    enum
    {
        Q = Model::parameters
    };
    Eigen::Matrix<double, Q, Q> S = Eigen::Matrix<double, Q, Q>::Zero();
    AlignedVector<Matrix3d> perView(models.size(), Matrix3d::Zero());
    points.resize(tracks.count());
    for (int j = 0; j < tracks.count(); ++j)
    {
        Matrix3d ZZ = Matrix3d::Zero();
        Eigen::Matrix<double, 3, Q> Zp = Eigen::Matrix<double, 3, Q>::Zero();
        int used = 0;
        for (int o = tracks.first[j]; o < tracks.first[j + 1]; ++o)
        {
            const Observation& observation = tracks.observations[o];
            const Matrix3d M = weights[o] * observation.form;
            ZZ += M;
            models[observation.view].addProduct(M, Zp);
            used += weights[o] > 0;
        }
        points[j].set(ZZ, used);
        if (!points[j].usable())
            continue;
        points[j].solveLower(Zp);
        for (int i = 0; i < Q; ++i)
            for (int k = 0; k < Q; ++k)
                S(k, i) -= Zp(0, k) * Zp(0, i) + Zp(1, k) * Zp(1, i) + Zp(2, k) * Zp(2, i);
        for (int o = tracks.first[j]; o < tracks.first[j + 1]; ++o)
            perView[tracks.observations[o].view] += weights[o] * tracks.observations[o].form;
    }
    for (size_t view = 0; view < models.size(); ++view)
        S.noalias() += models[view].D().transpose() * perView[view] * models[view].D();
    return S;
}

template <class Model>
void evaluateTracks(const Tracks& tracks, const AlignedVector<Model>& models, const AlignedVector<Matrix3d>& toImage,
                    const std::vector<double>& weights, const AlignedVector<EliminatedPoint>& points,
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
        Vector3d Zp = Vector3d::Zero();
        for (int o = tracks.first[j]; o < tracks.first[j + 1]; ++o)
            Zp.noalias() += weights[o] * (tracks.observations[o].form * shift[tracks.observations[o].view]);
        const Vector3d Z = -points[j].solve(Zp);
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
                                                    const std::vector<double>&, AlignedVector<EliminatedPoint>&);
template Eigen::Matrix4d eliminateTracks<RotationModel>(const Tracks&, const AlignedVector<RotationModel>&,
                                                        const std::vector<double>&, AlignedVector<EliminatedPoint>&);
template void evaluateTracks<TranslationModel>(const Tracks&, const AlignedVector<TranslationModel>&,
                                               const AlignedVector<Matrix3d>&, const std::vector<double>&,
                                               const AlignedVector<EliminatedPoint>&, const Vector9d&, TrackResiduals&);
template void evaluateTracks<RotationModel>(const Tracks&, const AlignedVector<RotationModel>&,
                                            const AlignedVector<Matrix3d>&, const std::vector<double>&,
                                            const AlignedVector<EliminatedPoint>&, const Eigen::Vector4d&,
                                            TrackResiduals&);

}} // namespace cv::active_handeye
