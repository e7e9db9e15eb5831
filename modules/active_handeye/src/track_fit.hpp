// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// Robust solution of one track problem (track_elimination.hpp): weights by depth, wrong observations found by their residuals, a view that
// contradicts all others found by leaving it out, jitter of whole views (track_jitter.hpp) where it is significant.
#ifndef OPENCV_ACTIVE_HANDEYE_TRACK_FIT_HPP
#define OPENCV_ACTIVE_HANDEYE_TRACK_FIT_HPP

#include "track_elimination.hpp"

namespace cv { namespace active_handeye {

template <class Model>
class TrackProblem
{
public:
    typedef Eigen::Matrix<double, Model::parameters, 1> Parameters;
    typedef Eigen::Matrix<double, Model::parameters, Model::parameters> Form;

    virtual ~TrackProblem() {}

    //! p that minimises p^T S p on the manifold of the problem.
    virtual Parameters minimize(const Form& S) = 0;

    //! Sets toImage as far as it depends on the present p; false when it does not.
    virtual bool updateImages(const Parameters& p) = 0;

    //! Replaces p by the other minimum of p^T S p, where all depths have the opposite sign; false when there is none.
    virtual bool mirror(const Form& S, Parameters& p) = 0;

    //! Directions in which the present p may move, one a column.
    virtual Eigen::MatrixXd tangent() const = 0;

    Tracks tracks;
    AlignedVector<Model> models;            //!< per view
    AlignedVector<Eigen::Matrix3d> toImage; //!< per view: it sees Y at toImage Y
    double pixelsPerUnit = 1;               //!< pixels per unit of Observation::x
    double largeResidual = 0.5;             //!< px: more than image noise and a robot's jitter explain
    std::string function;                   //!< names the caller in error texts
};

template <class Model>
struct TrackFit
{
    Eigen::Matrix<double, Model::parameters, 1> p;
    Eigen::Matrix<double, Model::parameters, Model::parameters> S; //!< p^T S p is the sum of squared residuals
    std::vector<int> rejectedViews;                                //!< views that contradict the others
    double cost;        //!< sum of squared residuals used, in units of Observation::x
    int used;           //!< observations used
    double medianDepth; //!< of the observations
    double jitterSigma; //!< of the views, in units of Observation::x at the focal length; 0 when it is not significant
    double
        redundancy; //!< 2 x observations used - 3 x tracks used - jitter numbers that the data determine, before the parameters

    //! Noise of one coordinate of an image point.
    double sigma(int freeParameters) const { return std::sqrt(cost / std::max(redundancy - freeParameters, 1.)); }
    double rms() const { return std::sqrt(cost / used); }
    EIGEN_MAKE_ALIGNED_OPERATOR_NEW
};

//! Throws StsNoConv when the tracks have no parallax, lie behind the camera, or contradict the poses.
template <class Model>
TrackFit<Model> fitTracks(TrackProblem<Model>& problem);

//! RMS residual of a p that is given (minimize() returns it), wrong observations left out; nothing is refused.
template <class Model>
double rmsOfTracks(TrackProblem<Model>& problem);

}} // namespace cv::active_handeye

#endif
