// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// Many image points of unknown scene points, few parameters p that all of them share. A scene point Z has in view i the
// vector Y = Z + D_i p, and its image point says (x Y_z - Y_xy) = 0 for the coordinates in which that view sees Y. Squared this is a
// quadratic form Y^T M Y, depth^2 times the squared reprojection error. Every Z is eliminated; what remains is p^T S p.
#ifndef OPENCV_ACTIVE_HANDEYE_TRACK_ELIMINATION_HPP
#define OPENCV_ACTIVE_HANDEYE_TRACK_ELIMINATION_HPP

#include "input.hpp"

namespace cv { namespace active_handeye {

//! A symmetric 3 x 3 matrix: xx, xy, xz, yy, yz, zz.
typedef Eigen::Matrix<double, 6, 1> SymmetricForm;

//! D_i of x ~ Z - P b_i with p = vec(P), row by row: - (I kron b_i^T).
struct TranslationModel
{
    enum
    {
        parameters = 9
    };
    Eigen::Vector3d b = Eigen::Vector3d::Zero();

    Eigen::Matrix<double, 3, 9> D() const;
    Eigen::Vector3d shift(const Vector9d& p) const;

    //! Sums of M and M D over the observations of one point.
    class Sums
    {
    public:
        void add(const SymmetricForm& M, const TranslationModel& model);
        Eigen::Matrix3d M() const;
        Eigen::Matrix<double, 3, 9, Eigen::RowMajor> MD() const;

    private:
        Eigen::Matrix<double, 6, 4> sums_ = Eigen::Matrix<double, 6, 4>::Zero(); // M, and M times each coordinate of b
    };
};

//! D_i of a scene point in the base frame seen by a camera at R_i t + t_i: p = (t, 1), D_i = - (R_i, t_i).
struct RotationModel
{
    enum
    {
        parameters = 4
    };
    Eigen::Matrix<double, 3, 4, Eigen::RowMajor> negative;

    Eigen::Matrix<double, 3, 4> D() const { return -negative; }
    Eigen::Vector3d shift(const Eigen::Vector4d& p) const { return -negative * p; }

    //! Sums of M and M D over the observations of one point.
    class Sums
    {
    public:
        void add(const SymmetricForm& M, const RotationModel& model);
        Eigen::Matrix3d M() const;
        Eigen::Matrix<double, 3, 4, Eigen::RowMajor> MD() const { return -product_; }

    private:
        SymmetricForm M_ = SymmetricForm::Zero();
        Eigen::Matrix<double, 3, 4, Eigen::RowMajor> product_ = Eigen::Matrix<double, 3, 4>::Zero();
    };
};

//! A small turn of the camera of a view, as image motion at the focal length in units of x: shift x, shift y, roll.
enum
{
    JITTER_NUMBERS = 3
};
typedef Eigen::Matrix<double, 2, JITTER_NUMBERS> JitterMotion;

struct Observation
{
    int view;                 //!< view of the caller
    int point;                //!< column of imagePoints
    Eigen::Vector2d measured; //!< image point
    Eigen::Vector2d x;        //!< the same without the jitter of its view
    SymmetricForm form;       //!< M
};

//! Observations sorted by track: track j is observations[first[j]] .. observations[first[j + 1] - 1].
struct Tracks
{
    AlignedVector<Observation> observations;
    std::vector<int> first = std::vector<int>(1, 0);

    double focalLength = 1; //!< about, in units of x

    int count() const { return int(first.size()) - 1; }

    //! Adds one track for every point that two or more of the `views` see.
    void add(const std::vector<Pixels>& pixels, const std::vector<int>& views);

    //! Sets the forms of all observations for view i seeing toImage[i] Y at x.
    void setForms(const AlignedVector<Eigen::Matrix3d>& toImage);

    //! Sets x to what is measured without the jitter of the views.
    void removeJitter(const Eigen::VectorXd& jitter);

    //! How the jitter of a view moves an image point.
    JitterMotion jitterMotion(const Observation& observation) const;

    //! Median over the tracks of the size of the box around their image points.
    double medianParallax() const;
};

//! What a track says about its point Z for Q parameters p: A Z + B p = 0 with A = L D L^T, L of unit diagonal, written out since general
//! solvers are several times slower on 3 x 3.
template <int Q>
class EliminatedPoint
{
public:
    typedef Eigen::Matrix<double, 3, Q, Eigen::RowMajor> Rows;

    //! Not usable: fewer than two observations, or no parallax.
    void set(const Eigen::Matrix3d& A, const Rows& B, int observations);
    bool usable() const { return usable_; }

    //! C <- L^-1 C.
    template <class Matrix>
    void solveLower(Matrix& C) const
    {
        C.row(1) -= l10_ * C.row(0);
        C.row(2) -= l20_ * C.row(0) + l21_ * C.row(1);
    }

    //! D^-1.
    const Eigen::Vector3d& inversePivots() const { return inversePivots_; }

    //! L^-1 B.
    const Rows& reduced() const { return reduced_; }

    //! Z of given p.
    Eigen::Vector3d at(const Eigen::Matrix<double, Q, 1>& p) const;

private:
    Rows reduced_;
    Eigen::Vector3d inversePivots_;
    double l10_, l20_, l21_;
    bool usable_;
};

/** Sum of weight * Y^T M Y with all points eliminated: S of p^T S p.

Observations of weight 0 do not count. `points` receives what evaluateTracks() needs.
*/
template <class Model>
Eigen::Matrix<double, Model::parameters, Model::parameters>
eliminateTracks(const Tracks& tracks, const AlignedVector<Model>& models, const std::vector<double>& weights,
                AlignedVector<EliminatedPoint<Model::parameters>>& points);

//! Depth and reprojection error of every observation.
struct TrackResiduals
{
    Pixels residual;
    std::vector<double> depth, squared;
};

//! Residuals for given p with every point put back, in views that see Y at toImage Y; NaN for points that are not usable.
template <class Model>
void evaluateTracks(const Tracks& tracks, const AlignedVector<Model>& models,
                    const AlignedVector<Eigen::Matrix3d>& toImage,
                    const AlignedVector<EliminatedPoint<Model::parameters>>& points,
                    const Eigen::Matrix<double, Model::parameters, 1>& p, TrackResiduals& residuals);

}} // namespace cv::active_handeye

#endif
