// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// What the data determine badly, by name, and which motion would cure it.
#ifndef OPENCV_ACTIVE_HANDEYE_OBSERVABILITY_HPP
#define OPENCV_ACTIVE_HANDEYE_OBSERVABILITY_HPP

#include "calibration_state.hpp"
#include "turn_directions.hpp"

namespace cv { namespace active_handeye {

//! A direction of the calibration's tangent space with its standard deviation in units in which 1 = nothing is known.
struct WeakDirection
{
    CalibrationStep direction; //!< in natural units: focal lengths, working distances, radians
    double deviation;          //!< infinite when it is not observed
    std::string text;
};

//! Size of each column that would mean that nothing is known about it.
CalibrationStep naturalUnits(const HandEyeCalibration& calibration, double workingDistance, double imageRadius);

//! Units of the columns of a basis, which have one each, apart from those of equal units.
Eigen::VectorXd unitsOf(const Eigen::MatrixXd& basis, const CalibrationStep& units);

/** Directions with a standard deviation above `limit`, the worst first.

information: of the free directions (columns of `basis`), everything else eliminated. imageRadius: largest distance of an image point from
the principal point, in focal lengths.
*/
std::vector<WeakDirection> findWeakDirections(const Eigen::MatrixXd& information, const Eigen::MatrixXd& basis,
                                              const HandEyeCalibration& calibration, double workingDistance,
                                              double imageRadius, const TurnDirections& turns, double limit);

//! Text for a direction of t_cam2gripper (gripper frame) that the turns do not show.
std::string unobservedTranslation(const Eigen::Vector3d& direction, const TurnDirections& turns);

}} // namespace cv::active_handeye

#endif
