// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// P = K R_cam2gripper^T: its parameters, and the minimum of a quadratic form p^T S p over them, p = vec(P) row by row.
#ifndef OPENCV_ACTIVE_HANDEYE_PROJECTION_HPP
#define OPENCV_ACTIVE_HANDEYE_PROJECTION_HPP

#include "normalization.hpp"

namespace cv { namespace active_handeye {

enum
{
    PROJECTION_PARAMETERS = 8
}; //!< fx, fy, cx, cy, skew, rotation error vector in the gripper frame

//! K and R with P ~ K R^T, det P > 0.
struct Projection
{
    Eigen::Matrix3d K = Eigen::Matrix3d::Identity();
    Eigen::Matrix3d R = Eigen::Matrix3d::Identity(); //!< R_cam2gripper

    //! RQ decomposition.
    static Projection decompose(const Eigen::Matrix3d& P);

    //! vec(T K R^T) / |.|, and its derivative by the 8 parameters.
    Vector9d vector(const Eigen::Matrix3d& T, Eigen::Matrix<double, 9, PROJECTION_PARAMETERS>* jacobian = 0) const;

    void apply(const Eigen::Matrix<double, PROJECTION_PARAMETERS, 1>& step);
};

Eigen::Matrix3d toMatrix(const Vector9d& p);

//! Columns: the directions in parameter space that `flags` (TranslationsFlags) leave free.
Eigen::MatrixXd freeParameters(int flags);

class ProjectionSolver
{
public:
    //! directions: 3 x r basis (r = 2 or 3) of the translations in the gripper frame; K counts for TRANSLATIONS_FIX_K.
    ProjectionSolver(const Normalization& T, const Eigen::MatrixXd& directions, int flags, const Eigen::Matrix3d& K);

    //! Minimum of p^T S p over what is free, |p| = 1.
    Projection minimize(const Matrix9d& S) const;

    //! The minimum that descent from `start` reaches.
    Projection minimizeFrom(const Projection& start, const Matrix9d& S) const;

    //! Covariance of the 8 parameters when S holds residuals of standard deviation sigma.
    Eigen::MatrixXd covariance(const Projection& projection, const Matrix9d& S, double sigma) const;

    //! With two directions only, R and R turned by 180 degrees about their normal differ in the sign of all depths. False with three.
    bool mirror(Projection& projection) const;

    //! Derivative of vector() by the free parameters.
    Eigen::MatrixXd tangent(const Projection& projection) const;

    int freeCount() const { return int(free_.cols()); }
    Vector9d vector(const Projection& projection) const { return projection.vector(T_); }

private:
    Projection linearStart(const Matrix9d& S) const;

    Eigen::Matrix3d T_;
    Eigen::MatrixXd directions_;
    int flags_;
    Eigen::Matrix3d K_;
    Eigen::MatrixXd free_;
};

}} // namespace cv::active_handeye

#endif
