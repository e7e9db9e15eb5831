// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_ACTIVE_HANDEYE_CAMERA_HPP
#define OPENCV_ACTIVE_HANDEYE_CAMERA_HPP

namespace cv { namespace active_handeye {

/** Pinhole camera with OpenCV's distortion k1, k2, p1, p2, k3.

"Ideal" means without distortion: the ideal pixel of a viewing ray m = (x, y, 1) is K m.
*/
struct Camera
{
    Eigen::Matrix3d K = Eigen::Matrix3d::Identity(); //!< upper triangular, K(2,2) = 1
    double D[5] = {0, 0, 0, 0, 0};                   //!< k1, k2, p1, p2, k3

    bool hasDistortion() const;

    //! Distorted normalised coordinates of the ideal ones.
    Eigen::Vector2d distort(const Eigen::Vector2d& ideal) const;

    //! Derivative of distort().
    Eigen::Matrix2d distortJacobian(const Eigen::Vector2d& ideal) const;

    //! Pixel of the recorded (distorted) image -> viewing ray (x, y, 1). Throws StsOutOfRange where distCoeffs cannot be inverted.
    Eigen::Vector3d ray(const Eigen::Vector2d& pixel) const;

    //! Pixel of the recorded image -> ideal pixel.
    Eigen::Vector2d idealPixel(const Eigen::Vector2d& pixel) const;

    //! Point of the camera frame -> pixel of the recorded image.
    Eigen::Vector2d project(const Eigen::Vector3d& X) const;
};

}} // namespace cv::active_handeye

#endif
