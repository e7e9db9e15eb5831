// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// Which lens distortion the data show.
#include "precomp.hpp"
#include "distributions.hpp"
#include "decompositions.hpp"
#include "refinement.hpp"

namespace cv { namespace active_handeye {

using Eigen::MatrixXd;
using Eigen::VectorXd;

//! Wald tests of all five coefficients from one step of a fit that frees them, at the present solution.
void HandEyeRefinement::testLens()
{
    const int chosen = lensModel_, first = COLUMN_DISTORTION;
    const bool allFixed[] = {true, true, true, true};
    const double noFloors[] = {0, 0, 0, 0};
    lensModel_ = LENS_K3;
    setUnknowns();
    problem_.restrictData();
    const VarianceComponents full(problem_, allFixed, noFloors);
    const MatrixXd& B = problem_.unknowns.calibration;
    const MatrixXd J = B.middleRows<5>(first);
    const Eigen::Matrix<double, 5, 5> covariance =
        J * full.covariance().topLeftCorner(B.cols(), B.cols()) * J.transpose();
    Eigen::Matrix<double, 5, 1> coefficients = J * full.step().head(B.cols());
    for (int i = 0; i < 5; ++i)
        coefficients(i) += problem_.state.calibration.camera.D[i] - start_.camera.D[i];
    for (int model = 0; model < LENS_MODELS; ++model)
    {
        const int lacking = 5 - lensCoefficients(model);
        LensTest& test = lensTests_[model];
        test.lacking = lacking;
        test.statistic =
            coefficients.tail(lacking).dot(solveSymmetric<VectorXd>(covariance.bottomRightCorner(lacking, lacking),
                                                                    coefficients.tail(lacking)));
        test.pValue = lacking ? chiSquareTail(test.statistic, lacking) : 1;
    }
    lensModel_ = chosen;
    setUnknowns();
    problem_.restrictData();
}

//! Wald test of fy / fx from one step of a fit that frees it.
void HandEyeRefinement::testAspect()
{
    if (!(params_.flags & REFINE_FIX_ASPECT) || params_.flags & REFINE_FIX_K)
        return;
    const bool allFixed[] = {true, true, true, true};
    const double noFloors[] = {0, 0, 0, 0};
    setUnknowns(true);
    problem_.restrictData();
    const VarianceComponents full(problem_, allFixed, noFloors);
    const MatrixXd& B = problem_.unknowns.calibration;
    const Eigen::Matrix3d& K = problem_.state.calibration.camera.K;
    const VectorXd J = (B.row(COLUMN_FY) / K(1, 1) - B.row(COLUMN_FX) / K(0, 0)).transpose();
    const double change = J.dot(full.step().head(B.cols()));
    const double variance = J.dot(full.covariance().topLeftCorner(B.cols(), B.cols()) * J);
    aspectPValue_ = chiSquareTail(change * change / variance, 1);
    setUnknowns();
    problem_.restrictData();
}

//! The smallest model that the data do not contradict.
int HandEyeRefinement::lensOfTests() const
{
    const double level = 0.01;
    int model = 0;
    while (lensTests_[model].pValue < level)
        ++model;
    return model;
}

bool HandEyeRefinement::chooseLens()
{
    const bool isOpen = params_.lensModel == LENS_AUTO && !(params_.flags & REFINE_FIX_K);
    const int maxRounds = 3, before = lensModel_;
    for (int round = 0; round < maxRounds && isOpen; ++round)
    {
        testLens();
        const int model = lensOfTests();
        if (model == lensModel_)
            break;
        lensModel_ = model;
        for (int i = lensCoefficients(model); i < 5; ++i)
            problem_.state.calibration.camera.D[i] = start_.camera.D[i];
        fit(1e-6);
    }
    return lensModel_ != before;
}

}} // namespace cv::active_handeye
