// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// Normal equations of the image points, each scene point eliminated (Schur complement).
#ifndef OPENCV_ACTIVE_HANDEYE_POINT_EQUATIONS_HPP
#define OPENCV_ACTIVE_HANDEYE_POINT_EQUATIONS_HPP

#include "refine_problem.hpp"

namespace cv { namespace active_handeye {

typedef Eigen::Matrix<double, 3, 2> Matrix32d; // derivatives of a pixel, transposed
typedef Eigen::Matrix<double, 6, 2> Matrix62d;
typedef Eigen::Matrix<double, 6, 3> Matrix63d;
typedef Eigen::Matrix<double, POINT_COLUMNS, 2> CalibrationByPixel;
typedef Eigen::Matrix<double, POINT_COLUMNS, 3> CalibrationByPoint;

//! Columns of the unknowns before the calibration is restricted to its free directions.
struct AllColumns
{
    explicit AllColumns(const RefineUnknowns& unknowns);

    int shift, object, size;
    std::vector<int> pose; //!< per view, -1 = exact
};

//! J^T J and J^T r of one robot pose or of the object's, by itself and with the calibration.
struct PoseTerm
{
    Eigen::Matrix<double, 6, 6> JtJ = Eigen::Matrix<double, 6, 6>::Zero();
    Eigen::Matrix<double, POINT_COLUMNS, 6> byCalibration = Eigen::Matrix<double, POINT_COLUMNS, 6>::Zero();
    Vector6d Jtr = Vector6d::Zero();

    void add(const Matrix62d& pose, const CalibrationByPixel& calibration, const Eigen::Vector2d& error);
    void addTo(DataTerm& term, int column) const;
};

//! J^T J (upper triangle) and J^T r of the tracks added. Sums are kept in matrices of fixed size until finish().
class PointEquations
{
public:
    PointEquations(const SceneTracks& tracks, const CalibrationState& state, const CameraViews& views,
                   const AllColumns& columns, double huberLimit, double meanSlope);

    void addTrack(int track);

    //! Brings together what was added.
    void finish();

    DataTerm term;

private:
    //! A pose that sees the track at hand.
    struct SeenBy
    {
        int view, column;
        Matrix63d W; //!< J_pose^T J_point
    };

    void addObservation(const PointObservation& o, int track);
    void eliminatePoint();

    const SceneTracks& tracks_;
    const CalibrationState& state_;
    const CameraViews& views_;
    const AllColumns& columns_;
    const double huberLimit_, meanSlope_;
    Eigen::Matrix<double, POINT_COLUMNS, POINT_COLUMNS> calibration_;
    Eigen::Matrix<double, POINT_COLUMNS, 1> calibrationPull_;
    AlignedVector<PoseTerm> poses_; //!< per view
    PoseTerm object_;

    // The track at hand: normal equations of its point A X = -b, and J^T J_point of the calibration and of the poses.
    Eigen::Matrix3d A_;
    Eigen::Vector3d b_;
    CalibrationByPoint calibrationByPoint_;
    AlignedVector<SeenBy> seenBy_;
};

}} // namespace cv::active_handeye

#endif
