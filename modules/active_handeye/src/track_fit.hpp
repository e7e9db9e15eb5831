// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// Robust solution of one track problem (track_elimination.hpp): weights by depth, wrong observations found by their residuals, a view that
// contradicts all others found by leaving it out.
#ifndef OPENCV_ACTIVE_HANDEYE_TRACK_FIT_HPP
#define OPENCV_ACTIVE_HANDEYE_TRACK_FIT_HPP

#include "track_elimination.hpp"

namespace cv { namespace active_handeye {

template <int Q>
class TrackProblem
{
public:
    typedef Eigen::Matrix<double, Q, 1> Parameters;
    typedef Eigen::Matrix<double, Q, Q> Form;

    virtual ~TrackProblem() {}

    //! p that minimises p^T S p on the manifold of the problem.
    virtual Parameters minimize(const Form& S) = 0;

    //! Sets the view models, as far as they depend on the present p.
    virtual void updateModels(const Parameters& p) = 0;

    //! Replaces p by the other answer with the same residuals and depths of opposite sign; false when there is none.
    virtual bool mirror(Parameters& p) = 0;

    Tracks tracks;
    AlignedVector<ViewModel<Q> > models;
    double pixelsPerUnit = 1;       //!< pixels per unit of Observation::x
    std::string function;           //!< names the caller in error texts
};

template <int Q>
struct TrackFit
{
    Eigen::Matrix<double, Q, 1> p;
    Eigen::Matrix<double, Q, Q> S;     //!< p^T S p is the sum of squared residuals, in units of Observation::x
    std::vector<double> weights;       //!< 1 / depth^2 of the observations used, 0 of the others
    std::vector<int> rejectedViews;    //!< views that contradict the others
    double cost;                       //!< sum of squared residuals used, in units of Observation::x
    int used;                          //!< observations used
    int redundancy;                    //!< 2 x observations used - 3 x tracks used, before the parameters

    double sigma(int parameters) const { return std::sqrt(cost / std::max(redundancy - parameters, 1)); }
    double rms() const { return std::sqrt(cost / used); }
    EIGEN_MAKE_ALIGNED_OPERATOR_NEW
};

//! Throws StsNoConv when the tracks have no parallax, lie behind the camera, or contradict the poses.
template <int Q>
TrackFit<Q> fitTracks(TrackProblem<Q>& problem);

}} // namespace cv::active_handeye

#endif
