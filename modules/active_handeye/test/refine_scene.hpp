// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.
#ifndef OPENCV_TEST_ACTIVE_HANDEYE_REFINE_SCENE_HPP
#define OPENCV_TEST_ACTIVE_HANDEYE_REFINE_SCENE_HPP

#include "point_scene.hpp"

#include <cstring>

namespace opencv_test { namespace refine {

//! Arguments and results of one call of refineHandEye().
struct Refinement
{
    vector<Mat> R, t, imagePoints, stripes, pointSigmas;
    vector<int> stripeViews, surfaceIds;
    Mat objectPoints, stripeSigmas;
    Mat K, D, R_cam2gripper, t_cam2gripper, light; //!< start, then result
    RefineParams params;
    RefineSummary summary;
    double rms = -1;

    void run()
    {
        rms = refineHandEye(R, t, imagePoints, K, D, R_cam2gripper, t_cam2gripper, light, summary, stripes, stripeViews,
                            surfaceIds, objectPoints, pointSigmas, stripeSigmas, params);
    }

    Vec3d translation() const { return Vec3d(t_cam2gripper.ptr<double>()); }
    double deviation(const string& parameter) const { return summary.standardDeviations.at<double>(row(parameter)); }
    double variance(const string& a, const string& b) const { return summary.covariance.at<double>(row(a), row(b)); }

    int row(const string& parameter) const
    {
        const auto found = std::find(summary.parameterNames.begin(), summary.parameterNames.end(), parameter);
        EXPECT_TRUE(found != summary.parameterNames.end()) << parameter;
        return int(found - summary.parameterNames.begin());
    }
};

struct Surface
{
    Vec3d normal; //!< base frame, normal.X = offset
    double offset;
};

/** Points and laser stripes seen by a camera in the hand of a robot that is a little elsewhere than it says. Millimetres.

True poses and pixels are those of PointScene; R, t are what the robot reports.
*/
class RefineScene : public PointScene
{
public:
    explicit RefineScene(uint64 seed = 1, int points = 40) : PointScene(seed, points), light(0.05, -0.5, 0.23)
    {
        K(0, 1) = 0;
        light = light * (1 / cv::norm(light));
        lightOffset = light[2] * 550;
    }

    //! Three groups of five views and four more orientations, of a robot and a camera with this noise.
    static RefineScene noisy(uint64 seed = 1, double pixels = 0.1, double millimetres = 0.02, double degrees = 0.005,
                             int points = 40)
    {
        RefineScene scene(seed, points);
        scene.addViews();
        scene.measure(pixels, millimetres, degrees);
        return scene;
    }

    static RefineScene exact(uint64 seed = 1) { return noisy(seed, 0, 0, 0); }

    void addViews()
    {
        for (const Vec3d& turn : {Vec3d(0, 0, 0), Vec3d(0.35, 0, 0), Vec3d(-0.1, 0.3, 1.2)})
            addGroup(turn, fourTranslations());
        for (const Vec3d& turn :
             {Vec3d(0, 0.3, 0.4), Vec3d(-0.2, -0.2, -0.8), Vec3d(0.2, -0.3, 2.5), Vec3d(-0.3, 0.1, -1.6)})
            addGroup(turn, vector<Vec3d>(1, Vec3d()));
    }

    void addSurfaces()
    {
        surfaces = {Surface{Vec3d(0.1, 0, 1), 30}, Surface{Vec3d(-0.3, 0.2, 1), -90}, Surface{Vec3d(0.2, 0.35, 1), 60}};
        for (Surface& surface : surfaces)
        {
            surface.offset /= cv::norm(surface.normal);
            surface.normal = surface.normal * (1 / cv::norm(surface.normal));
        }
    }

    void measure(double pixels, double millimetres, double degrees, double stripePixels = 0)
    {
        project(pixels);
        shine(stripePixels);
        reportedR.clear();
        reportedT.clear();
        for (size_t view = 0; view < R.size(); ++view)
        {
            const Matx33d turn = rotation(gaussian(degrees * CV_PI / 180));
            reportedR.push_back(Mat(Matx33d(turn * Matx33d(R[view]))));
            reportedT.push_back(Mat(Vec3d(Vec3d(t[view]) + gaussian(millimetres))));
        }
    }

    //! One segment of 12 pixels for each view and surface.
    void shine(double noise)
    {
        stripes.clear();
        stripeViews.clear();
        surfaceIds.clear();
        for (int view = 0; view < int(R.size()); ++view)
            for (int s = 0; s < int(surfaces.size()); ++s)
            {
                Mat segment(12, 2, CV_64F);
                for (int i = 0; i < segment.rows; ++i)
                {
                    const Vec2d x = stripePixel(view, surfaces[s], -0.18 + 0.12 * s + 0.01 * i);
                    segment.at<double>(i, 0) = x[0];
                    segment.at<double>(i, 1) = x[1] + (noise > 0 ? rng.gaussian(noise) : 0);
                }
                stripes.push_back(segment);
                stripeViews.push_back(view);
                surfaceIds.push_back(10 + 3 * s);
            }
    }

    //! Pixel where the stripe on a surface has this ideal x.
    Vec2d stripePixel(int view, const Surface& surface, double x) const
    {
        const Matx33d Rv(R[view]), cam2base = Rv * R_cam2gripper;
        const Vec3d centre = Rv * t_cam2gripper + Vec3d(t[view]);
        const Vec3d line =
            (surface.offset - surface.normal.dot(centre)) * light - lightOffset * (cam2base.t() * surface.normal);
        const Vec3d ray(x, -(line[0] * x + line[2]) / line[1], 1);
        return project(cam2base * (ray * (lightOffset / light.dot(ray))) + centre, view);
    }

    using PointScene::project;

    //! A call without a start.
    Refinement call() const
    {
        Refinement call;
        for (size_t view = 0; view < R.size(); ++view)
        {
            call.R.push_back(reportedR[view].clone());
            call.t.push_back(reportedT[view].clone());
            call.imagePoints.push_back(imagePoints[view].clone());
        }
        for (const Mat& stripe : stripes)
            call.stripes.push_back(stripe.clone());
        call.stripeViews = stripeViews;
        call.surfaceIds = surfaceIds;
        return call;
    }

    Refinement refined() const
    {
        Refinement result = call();
        result.run();
        return result;
    }

    Mat trueLight() const { return (Mat_<double>(4, 1) << light[0], light[1], light[2], lightOffset); }

    //! Largest error in standard deviations over the parameters with a deviation; light plane included.
    double worstError(const Refinement& r) const
    {
        const Mat K_(K), D_ = dist();
        vector<double> errors = {K(0, 0) - r.K.at<double>(0, 0), K(1, 1) - r.K.at<double>(1, 1),
                                 K(0, 2) - r.K.at<double>(0, 2), K(1, 2) - r.K.at<double>(1, 2),
                                 K(0, 1) - r.K.at<double>(0, 1)};
        for (int i = 0; i < 5; ++i)
            errors.push_back(D[i] - r.D.at<double>(i));
        const Matx33d turn = R_cam2gripper * Matx33d(r.R_cam2gripper).t();
        for (double angle : {turn(2, 1) - turn(1, 2), turn(0, 2) - turn(2, 0), turn(1, 0) - turn(0, 1)})
            errors.push_back(0.5 * angle);
        for (int i = 0; i < 3; ++i)
            errors.push_back(t_cam2gripper[i] - r.translation()[i]);
        for (int i = 0; i < 4 && !r.light.empty(); ++i)
            errors.push_back(trueLight().at<double>(i) - r.light.at<double>(i));
        double worst = 0;
        for (size_t i = 0; i < errors.size(); ++i)
            if (r.summary.standardDeviations.at<double>(int(i)) > 0)
                worst = std::max(worst, std::abs(errors[i]) / r.summary.standardDeviations.at<double>(int(i)));
        return worst;
    }

    Vec3d light; //!< camera frame, light.X = lightOffset
    double lightOffset;
    vector<Surface> surfaces;
    vector<Mat> reportedR, reportedT, stripes;
    vector<int> stripeViews, surfaceIds;

private:
    Vec3d gaussian(double sigma)
    {
        const double x = rng.gaussian(sigma), y = rng.gaussian(sigma), z = rng.gaussian(sigma);
        return Vec3d(x, y, z);
    }
};

inline bool sameBits(const Mat& a, const Mat& b)
{
    return a.size() == b.size() && a.type() == b.type() &&
           (a.empty() || std::memcmp(a.clone().data, b.clone().data, a.total() * a.elemSize()) == 0);
}

//! Rows and columns of a parameter are zero: it was not estimated.
inline void expectFixed(const Refinement& r, const vector<string>& parameters)
{
    for (const string& name : parameters)
    {
        EXPECT_EQ(0, cv::norm(r.summary.covariance.row(r.row(name)))) << name;
        EXPECT_EQ(0, cv::norm(r.summary.covariance.col(r.row(name)))) << name;
        EXPECT_EQ(0, r.deviation(name)) << name;
    }
}

inline void expectFree(const Refinement& r, const vector<string>& parameters)
{
    for (const string& name : parameters)
        EXPECT_GT(r.deviation(name), 0) << name;
}

}} // namespace opencv_test::refine

#endif
