// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_ACTIVE_HANDEYE_START_SEARCH_HPP
#define OPENCV_ACTIVE_HANDEYE_START_SEARCH_HPP

#include "refinement.hpp"

#include <exception>

namespace cv { namespace active_handeye {

//! What a start is computed from: some of the views, and what the caller gave of the calibration.
struct StartArguments
{
    std::vector<Mat> R_gripper2base, t_gripper2base, imagePoints;
    Mat cameraMatrix, distCoeffs, R_cam2gripper, t_cam2gripper;

    void setViews(const RefineMeasurements& measurements, const std::vector<int>& views)
    {
        R_gripper2base.resize(views.size());
        t_gripper2base.resize(views.size());
        imagePoints.resize(views.size());
        for (size_t i = 0; i < views.size(); ++i)
        {
            writeMatrix(measurements.gripper2base[views[i]].R, R_gripper2base[i]);
            writeMatrix(measurements.gripper2base[views[i]].t, t_gripper2base[i]);
            const Pixels& pixels = measurements.imagePoints[views[i]];
            imagePoints[i].create(int(pixels.size()), 2, CV_64F);
            for (int j = 0; j < int(pixels.size()); ++j)
            {
                imagePoints[i].at<double>(j, 0) = pixels[j].x();
                imagePoints[i].at<double>(j, 1) = pixels[j].y();
            }
        }
    }
};

//! Starts refinements from different sets of views, and keeps the best one.
class StartSearch
{
public:
    StartSearch(const StartArguments& given, const RefineMeasurements& measurements, const RefineParams& params);

    /** A refinement of the points. Throws StsNoConv when no set of views gives a start.

    Closed forms that distrust views are right when a view is wrong, those that do not when the robot is merely inaccurate; and when
    the orientation of a whole group is wrong, the others must do without it.
    */
    std::unique_ptr<HandEyeRefinement> refinePoints();

private:
    bool attempt(const std::vector<int>& views, double threshold, const std::vector<int>& doubted);
    void attemptWithoutGroups(bool two);

    StartArguments given_;
    const RefineMeasurements& measurements_;
    const RefineParams& params_;
    const TurnDirections turns_;
    std::unique_ptr<HandEyeRefinement> best_;
    std::exception_ptr refusal_;
};

}} // namespace cv::active_handeye

#endif
