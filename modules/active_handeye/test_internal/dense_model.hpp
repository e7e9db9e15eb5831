// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// The joint refinement as one dense linear model, by numerical differentiation of the residuals' definitions; no point is eliminated.
#ifndef OPENCV_TEST_ACTIVE_HANDEYE_DENSE_MODEL_HPP
#define OPENCV_TEST_ACTIVE_HANDEYE_DENSE_MODEL_HPP

#include "small_problem.hpp"

#include <functional>

namespace opencv_test {

//! J of f at 0: central differences of fourth order.
MatrixXd differentiate(const std::function<VectorXd(const VectorXd&)>& f, const VectorXd& steps);

//! A step of each column of the calibration that moves the image by about a tenth of a pixel.
VectorXd calibrationSteps();

/** All residuals in their own units: 2 per image point, 1 per end of a segment, 6 per pose with a prior.

Unknowns are the reduced ones of RefineUnknowns, then 3 for each free point that is used.
*/
class DenseModel
{
public:
    explicit DenseModel(const RefineProblem& problem);

    int reduced() const { return reduced_; }
    int free() const { return free_; } //!< points
    int size() const { return reduced_ + 3 * free_; }

    //! Corrections of the poses with a prior, their columns, and which of them are rotations.
    void priors(VectorXd& corrections, std::vector<int>& columns, std::vector<bool>& isRotation) const;

    VectorXd pointErrors, stripeErrors; //!< times inverseSigma
    MatrixXd byPoints, byStripes;       //!< derivatives of these

private:
    VectorXd steps() const;
    CalibrationState moved(const VectorXd& step) const;
    VectorXd points(const VectorXd& step) const;
    //! Distance of the ideal ray from the line in which the planes of laser and surface meet, in pixels as large as K says at the start.
    VectorXd stripes(const VectorXd& step) const;

    const RefineProblem& problem_;
    const int reduced_;
    int free_ = 0;
    std::vector<int> column_; //!< of each track among the free points, -1 = not free
};

//! Schur complement over the free points.
DataTerm eliminated(const DenseModel& model, const MatrixXd& J, const VectorXd& errors);

//! Entries in units of the geometric mean of their diagonal elements.
void expectSameTerm(const DataTerm& expected, const DataTerm& term, double tolerance);

} // namespace opencv_test

#endif
