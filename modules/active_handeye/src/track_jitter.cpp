// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "track_jitter.hpp"
#include "decompositions.hpp"

namespace cv { namespace active_handeye {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::VectorXd;

static MatrixXd withPrecision(const MatrixXd& jj, double precision)
{
    return jj + precision * MatrixXd::Identity(jj.rows(), jj.cols());
}

template <int Q>
Eigen::Matrix<double, Q, Q> JitterForm<Q>::withoutJitter(double precision) const
{
    return pp - jp.transpose() * solveSymmetric<MatrixXd>(withPrecision(jj, precision), jp);
}

template <int Q>
VectorXd JitterForm<Q>::jitter(const Eigen::Matrix<double, Q, 1>& p, double precision) const
{
    return -solveSymmetric<VectorXd>(withPrecision(jj, precision), jp * p);
}

template <int Q>
double JitterForm<Q>::determined(const MatrixXd& tangent, double precision) const
{
    MatrixXd posterior = withPrecision(jj, precision);
    if (tangent.cols() > 0)
    {
        const MatrixXd cross = jp * tangent, own = tangent.transpose() * pp * tangent;
        posterior -= cross * solveSymmetric<MatrixXd>(own, cross.transpose());
    }
    return double(jj.rows()) - precision * inverseOfSymmetric(posterior).trace();
}

template <class Model>
JitterForm<Model::parameters>
eliminateTracksWithJitter(const Tracks& tracks, const AlignedVector<Model>& models,
                          const AlignedVector<Matrix3d>& toImage, const std::vector<double>& weights,
                          const std::vector<double>& depth, AlignedVector<EliminatedPoint<Model::parameters>>& points)
{
    enum
    {
        Q = Model::parameters
    };
    JitterForm<Q> form;
    form.pp = eliminateTracks(tracks, models, weights, points);
    const int J = JITTER_NUMBERS, numbers = J * int(models.size());
    form.jp = MatrixXd::Zero(numbers, int(Q));
    form.jj = MatrixXd::Zero(numbers, numbers);
    AlignedVector<Eigen::Matrix<double, 3, JITTER_NUMBERS>>
        Zj; // per observation of the track, solved by the lower factor
    for (int j = 0; j < tracks.count(); ++j)
    {
        if (!points[j].usable())
            continue;
        Zj.clear();
        for (int o = tracks.first[j]; o < tracks.first[j + 1]; ++o)
        {
            // One observation, times its depth: Y_xy - x Y_z + depth E jitter.
            const Observation& observation = tracks.observations[o];
            const int at = J * observation.view;
            const Matrix3d& A = toImage[observation.view];
            const Eigen::Matrix<double, 2, 3> rows = A.topRows<2>() - observation.x * A.row(2);
            const JitterMotion E = tracks.jitterMotion(observation);
            const Eigen::Matrix<double, 3, JITTER_NUMBERS> product = (weights[o] * depth[o]) * (rows.transpose() * E);
            form.jp.template block<JITTER_NUMBERS, Q>(at, 0) += product.transpose() * models[observation.view].D();
            form.jj.template block<JITTER_NUMBERS, JITTER_NUMBERS>(at, at) +=
                (weights[o] * depth[o] * depth[o]) * (E.transpose() * E);
            Zj.push_back(product);
            points[j].solveLower(Zj.back());
        }
        const typename EliminatedPoint<Q>::Rows& Zp = points[j].reduced();
        const Observation* track = &tracks.observations[tracks.first[j]];
        for (size_t a = 0; a < Zj.size(); ++a)
        {
            const Eigen::Matrix<double, JITTER_NUMBERS, 3> scaled =
                Zj[a].transpose() * points[j].inversePivots().asDiagonal();
            form.jp.template block<JITTER_NUMBERS, Q>(J * track[a].view, 0) -= scaled * Zp;
            for (size_t b = 0; b < Zj.size(); ++b)
                form.jj.template block<JITTER_NUMBERS, JITTER_NUMBERS>(J * track[a].view, J * track[b].view) -=
                    scaled * Zj[b];
        }
    }
    return form;
}

template struct JitterForm<9>;
template struct JitterForm<4>;
template JitterForm<9>
eliminateTracksWithJitter<TranslationModel>(const Tracks&, const AlignedVector<TranslationModel>&,
                                            const AlignedVector<Matrix3d>&, const std::vector<double>&,
                                            const std::vector<double>&, AlignedVector<EliminatedPoint<9>>&);
template JitterForm<4> eliminateTracksWithJitter<RotationModel>(const Tracks&, const AlignedVector<RotationModel>&,
                                                                const AlignedVector<Matrix3d>&,
                                                                const std::vector<double>&, const std::vector<double>&,
                                                                AlignedVector<EliminatedPoint<4>>&);

}} // namespace cv::active_handeye
