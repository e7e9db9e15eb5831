// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "track_elimination.hpp"

namespace cv { namespace active_handeye {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

void Tracks::closeTrack()
{
    const int size = int(observations.size());
    if (size - first.back() >= 2)
        first.push_back(size);
    else
        observations.resize(first.back());
}

void addTracks(const std::vector<Pixels>& pixels, const std::vector<int>& views, Tracks& tracks)
{
    const int points = int(pixels[0].size());
    for (int point = 0; point < points; ++point)
    {
        for (int view : views)
            if (pixels[view][point].allFinite())
                tracks.observations.push_back(Observation{view, point, pixels[view][point]});
        tracks.closeTrack();
    }
}

double medianParallax(const Tracks& tracks)
{
    std::vector<double> parallax;
    for (int j = 0; j < tracks.count(); ++j)
    {
        double largest = 0;
        for (int a = tracks.first[j]; a < tracks.first[j + 1]; ++a)
            for (int b = tracks.first[j]; b < a; ++b)
                largest = std::max(largest, (tracks.observations[a].x - tracks.observations[b].x).squaredNorm());
        parallax.push_back(std::sqrt(largest));
    }
    if (parallax.empty())
        return 0;
    std::nth_element(parallax.begin(), parallax.begin() + parallax.size() / 2, parallax.end());
    return parallax[parallax.size() / 2];
}

namespace {

//! L^T L for the two rows L = (1, 0, -u; 0, 1, -v) that an image point (u, v) gives.
Matrix3d pointForm(const Vector2d& x)
{
    Matrix3d M;
    M << 1, 0, -x.x(), 0, 1, -x.y(), -x.x(), -x.y(), x.squaredNorm();
    return M;
}

//! Blocks of the normal equations that belong to one track.
template <int Q>
struct TrackBlocks
{
    Matrix3d ZZ;
    Eigen::Matrix<double, 3, Q> Zp;
    int used;
};

template <int Q>
TrackBlocks<Q> accumulate(const Tracks& tracks, int track, const AlignedVector<ViewModel<Q> >& models, const std::vector<double>& weights)
{
    TrackBlocks<Q> blocks;
    blocks.ZZ.setZero();
    blocks.Zp.setZero();
    blocks.used = 0;
    for (int o = tracks.first[track]; o < tracks.first[track + 1]; ++o)
    {
        if (weights[o] <= 0)
            continue;
        const Observation& observation = tracks.observations[o];
        const ViewModel<Q>& model = models[observation.view];
        const Matrix3d GtM = model.G.transpose() * (weights[o] * pointForm(observation.x));
        blocks.ZZ.noalias() += GtM * model.G;
        blocks.Zp.noalias() += GtM * model.D;
        ++blocks.used;
    }
    return blocks;
}

//! Cholesky factor of ZZ; false when the track leaves its point open (no parallax).
bool factorize(const Matrix3d& ZZ, Eigen::LLT<Matrix3d>& llt)
{
    const double minimumPivotRatio = 1e-14;
    llt.compute(ZZ);
    if (llt.info() != Eigen::Success)
        return false;
    const Vector3d pivots = llt.matrixLLT().diagonal().array().square();
    return pivots.minCoeff() > minimumPivotRatio * pivots.maxCoeff();
}

} // namespace

template <int Q>
Eigen::Matrix<double, Q, Q> eliminateTracks(const Tracks& tracks, const AlignedVector<ViewModel<Q> >& models,
                                            const std::vector<double>& weights)
{
    Eigen::Matrix<double, Q, Q> S = Eigen::Matrix<double, Q, Q>::Zero();
    AlignedVector<Matrix3d> perView(models.size(), Matrix3d::Zero());
    for (int j = 0; j < tracks.count(); ++j)
    {
        const TrackBlocks<Q> blocks = accumulate(tracks, j, models, weights);
        Eigen::LLT<Matrix3d> llt;
        if (blocks.used < 2 || !factorize(blocks.ZZ, llt))
            continue;
        const Eigen::Matrix<double, 3, Q> reduced = llt.matrixL().solve(blocks.Zp);
        S.noalias() -= reduced.transpose() * reduced;
        for (int o = tracks.first[j]; o < tracks.first[j + 1]; ++o)
            if (weights[o] > 0)
                perView[tracks.observations[o].view] += weights[o] * pointForm(tracks.observations[o].x);
    }
    for (size_t view = 0; view < models.size(); ++view)
        S.noalias() += models[view].D.transpose() * perView[view] * models[view].D;
    return S;
}

template <int Q>
TrackResiduals trackResiduals(const Tracks& tracks, const AlignedVector<ViewModel<Q> >& models, const std::vector<double>& weights,
                              const Eigen::Matrix<double, Q, 1>& p)
{
    TrackResiduals result;
    const double unknown = std::numeric_limits<double>::quiet_NaN();
    result.residual.assign(tracks.observations.size(), Vector2d::Constant(unknown));
    result.depth.assign(tracks.observations.size(), unknown);
    AlignedVector<Vector3d> shift;
    for (const ViewModel<Q>& model : models)
        shift.push_back(model.D * p);
    for (int j = 0; j < tracks.count(); ++j)
    {
        const TrackBlocks<Q> blocks = accumulate(tracks, j, models, weights);
        Eigen::LLT<Matrix3d> llt;
        if (blocks.used < 2 || !factorize(blocks.ZZ, llt))
            continue;
        const Vector3d Z = -llt.solve(blocks.Zp * p);
        for (int o = tracks.first[j]; o < tracks.first[j + 1]; ++o)
        {
            const Observation& observation = tracks.observations[o];
            const Vector3d Y = models[observation.view].G * Z + shift[observation.view];
            result.residual[o] = observation.x - Y.head<2>() / Y.z();
            result.depth[o] = Y.z();
        }
    }
    return result;
}

template Matrix9d eliminateTracks<9>(const Tracks&, const AlignedVector<ViewModel<9> >&, const std::vector<double>&);
template Eigen::Matrix4d eliminateTracks<4>(const Tracks&, const AlignedVector<ViewModel<4> >&, const std::vector<double>&);
template TrackResiduals trackResiduals<9>(const Tracks&, const AlignedVector<ViewModel<9> >&, const std::vector<double>&, const Vector9d&);
template TrackResiduals trackResiduals<4>(const Tracks&, const AlignedVector<ViewModel<4> >&, const std::vector<double>&,
                                          const Eigen::Vector4d&);

}} // namespace cv::active_handeye
