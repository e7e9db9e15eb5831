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
    observations.reserve(observations.size() + views.size() * points);
    for (size_t point = 0; point < points; ++point)
    {
        for (int view : views)
            if (!std::isnan(pixels[view][point].x()))
                observations.push_back(Observation{view, int(point), pixels[view][point], Matrix3d()});
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

double Tracks::medianParallax() const
{
    std::vector<double> parallax;
    for (int j = 0; j < count(); ++j)
    {
        Eigen::AlignedBox2d box;
        for (int o = first[j]; o < first[j + 1]; ++o)
            box.extend(observations[o].x);
        parallax.push_back(box.diagonal().norm());
    }
    if (parallax.empty())
        return 0;
    std::nth_element(parallax.begin(), parallax.begin() + parallax.size() / 2, parallax.end());
    return parallax[parallax.size() / 2];
}

//! Cholesky with a check that the track does not leave its point open.
static bool factorize(const Matrix3d& ZZ, Eigen::LLT<Matrix3d>& factor)
{
    const double minimumPivotRatio = 1e-14;
    factor.compute(ZZ);
    const Vector3d pivots = factor.matrixLLT().diagonal().array().square();
    return factor.info() == Eigen::Success && pivots.minCoeff() > minimumPivotRatio * pivots.maxCoeff();
}

template <class Model>
Eigen::Matrix<double, Model::parameters, Model::parameters> eliminateTracks(const Tracks& tracks, const AlignedVector<Model>& models,
                                                                           const std::vector<double>& weights,
                                                                           AlignedVector<EliminatedPoint>& points)
{
    enum { Q = Model::parameters };
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
        points[j].usable = used >= 2 && factorize(ZZ, points[j].factor);
        if (!points[j].usable)
            continue;
        points[j].factor.matrixL().solveInPlace(Zp);
        S.template selfadjointView<Eigen::Lower>().rankUpdate(Zp.transpose(), -1);
        for (int o = tracks.first[j]; o < tracks.first[j + 1]; ++o)
            perView[tracks.observations[o].view] += weights[o] * tracks.observations[o].form;
    }
    S = Eigen::Matrix<double, Q, Q>(S.template selfadjointView<Eigen::Lower>());
    for (size_t view = 0; view < models.size(); ++view)
        S.noalias() += models[view].D().transpose() * perView[view] * models[view].D();
    return S;
}

template <class Model>
void pointsOf(const Tracks& tracks, const AlignedVector<Model>& models, const std::vector<double>& weights,
              const AlignedVector<EliminatedPoint>& points, const Eigen::Matrix<double, Model::parameters, 1>& p, AlignedVector<Vector3d>& Y)
{
    Y.assign(tracks.observations.size(), Vector3d::Constant(std::numeric_limits<double>::quiet_NaN()));
    AlignedVector<Vector3d> shift;
    for (const Model& model : models)
        shift.push_back(model.shift(p));
    for (int j = 0; j < tracks.count(); ++j)
    {
        if (!points[j].usable)
            continue;
        Vector3d Zp = Vector3d::Zero();
        for (int o = tracks.first[j]; o < tracks.first[j + 1]; ++o)
            Zp.noalias() += weights[o] * (tracks.observations[o].form * shift[tracks.observations[o].view]);
        const Vector3d Z = -points[j].factor.solve(Zp);
        for (int o = tracks.first[j]; o < tracks.first[j + 1]; ++o)
            Y[o] = Z + shift[tracks.observations[o].view];
    }
}

template Matrix9d eliminateTracks<TranslationModel>(const Tracks&, const AlignedVector<TranslationModel>&, const std::vector<double>&,
                                                    AlignedVector<EliminatedPoint>&);
template Eigen::Matrix4d eliminateTracks<RotationModel>(const Tracks&, const AlignedVector<RotationModel>&, const std::vector<double>&,
                                                        AlignedVector<EliminatedPoint>&);
template void pointsOf<TranslationModel>(const Tracks&, const AlignedVector<TranslationModel>&, const std::vector<double>&,
                                         const AlignedVector<EliminatedPoint>&, const Vector9d&, AlignedVector<Vector3d>&);
template void pointsOf<RotationModel>(const Tracks&, const AlignedVector<RotationModel>&, const std::vector<double>&,
                                      const AlignedVector<EliminatedPoint>&, const Eigen::Vector4d&, AlignedVector<Vector3d>&);

}} // namespace cv::active_handeye
