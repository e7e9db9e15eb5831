// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// The joint refinement as a least-squares problem: which unknowns are free and which residuals are present is data.
#ifndef OPENCV_ACTIVE_HANDEYE_REFINE_PROBLEM_HPP
#define OPENCV_ACTIVE_HANDEYE_REFINE_PROBLEM_HPP

#include "least_squares.hpp"
#include "scene_tracks.hpp"
#include "stripe_lines.hpp"

namespace cv { namespace active_handeye {

//! Standard deviations; see RefineParams.
struct NoiseLevels
{
    double point, stripe, translation, rotation;
};

enum PoseFreedom
{
    POSE_EXACT, //!< as the robot reports
    POSE_PRIOR, //!< corrected within the robot's noise
    POSE_FREE   //!< the report is not believed
};

//! One straight piece of a stripe, as its two ends in the recorded image.
struct StripeSegment
{
    int segment; //!< of the caller
    int view, surface;
    Eigen::Vector2d ends[2];
    double inverseSigma; //!< relative to the common noise level
    bool used;
};

typedef AlignedVector<StripeSegment> StripeSegments;

//! Orthonormal basis of the directions in which a surface (w, e) of length 1 can move.
Eigen::Matrix<double, 4, 3> surfaceTangent(const Eigen::Vector4d& surface);

//! Which columns the reduced system has, in this order.
struct RefineUnknowns
{
    Eigen::MatrixXd calibration;    //!< CALIBRATION_COLUMNS x f: directions in which the calibration may move
    bool object = false;            //!< the pose of the known points
    int surfaces = 0;               //!< planes with stripes
    std::vector<PoseFreedom> poses; //!< per view

    int objectColumn() const { return int(calibration.cols()); }
    int surfaceColumn(int surface) const { return objectColumn() + (object ? 6 : 0) + 3 * surface; }
    int poseColumn(int view) const; //!< -1 for POSE_EXACT
    int count() const;
};

//! Half the derivatives of a sum of squares over the reduced unknowns, the scene points eliminated; noise level 1.
struct DataTerm
{
    Eigen::MatrixXd JtJ;
    Eigen::VectorXd Jtr;
    double squares = 0;
    int redundancy = 0; //!< residuals minus eliminated unknowns
};

//! Which second derivative of the points' loss a step takes, where Huber's clips.
enum LossCurvature
{
    CURVATURE_SQUARE,  //!< that of the unclipped square: the step of least squares
    CURVATURE_WEIGHTS, //!< that of iteratively reweighted least squares: a safe bound, slow near the optimum
    CURVATURE_LOSS     //!< its own: Newton's step
};

//! Cost of a track at a scene point, and where the point should go.
struct PointStep
{
    Eigen::Vector3d next;
    double cost;
    bool isClipped; //!< by Huber's loss
};

/** Points, stripes and pose priors.

The points' loss is Huber's. Where it clips, the residual is replaced by psi(r) / mean(psi'), which leaves the solution where it is and
makes J^T J over these residuals the information (Huber's modified residuals).
*/
class RefineProblem : public LeastSquaresProblem
{
public:
    RefineProblem(SceneTracks& tracks, StripeSegments& segments, const AlignedVector<Pose>& reported,
                  const CalibrationState& start, double huberThreshold);

    double linearize(Eigen::MatrixXd& JtJ, Eigen::VectorXd& Jtr) CV_OVERRIDE;
    double costAfter(const Eigen::VectorXd& step) const CV_OVERRIDE;
    void apply(const Eigen::VectorXd& step) CV_OVERRIDE;
    double negligibleDecrease() const CV_OVERRIDE { return 1e-10; } //!< a step of 1e-5 standard deviations

    //! Updates the share of residuals that Huber's loss clips; before every solution. Returns whether it changed.
    bool updateClipping();

    //! Rotation vector and translation by which a view's pose is corrected.
    Vector6d correction(int view) const;

    //! Data terms of the last linearize() or linearizeData().
    const DataTerm& points() const { return points_; }
    const DataTerm& stripes() const { return stripes_; }

    //! Derivatives of all point and stripe residuals at the present state.
    void linearizeData();

    //! The same for other unknowns of the calibration.
    void restrictData();

    SceneTracks& tracks;
    StripeSegments& segments;
    const AlignedVector<Pose>& reported; //!< gripper2base
    CalibrationState state;
    RefineUnknowns unknowns;
    NoiseLevels noise;

private:
    void linearizePoints();
    void linearizeStripes();
    double pointCost(const CalibrationState& state) const;
    double stripeCost(const CalibrationState& state) const;
    double priorCost(const CalibrationState& state) const;
    double cost(const CalibrationState& state) const;
    CalibrationState moved(const Eigen::VectorXd& step) const;
    PointStep stepOfPoint(int track, const CameraViews& views, const Camera& camera, const Eigen::Vector3d& X,
                          LossCurvature curvature) const;
    double movePoint(int track, const CameraViews& views, const Camera& camera, Eigen::Vector3d& X) const;
    double trackCost(int track, const CameraViews& views, const Camera& camera, const Eigen::Vector3d& X) const;
    double huberCost(double r) const;

    double huberThreshold_, meanSlope_ = 1;
    DataTerm points_, stripes_, allPoints_, allStripes_; //!< for the free and for all calibration columns
    mutable CalibrationState trial_;
};

}} // namespace cv::active_handeye

#endif
