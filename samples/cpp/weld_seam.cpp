// SPDX-FileCopyrightText: 2026 active_handeye contributors
// SPDX-License-Identifier: Apache-2.0

// The seam of a weld joint from laser images: stripe, straight pieces, the corner where the faces of the groove meet,
// and all corners as points of the base frame with covariances. The same as samples/python/05_weld_seam.py.
//
// weld_seam DATASET CALIBRATION, with the folder and the file that the demo writes: out/demo/scan
// out/demo/calibration.yaml. doc/files.md describes both.
#include "recording.hpp"

#include <opencv2/active_handeye.hpp>
#include <opencv2/imgcodecs.hpp>

#include <cmath>
#include <cstdio>
#include <exception>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

const double openingDeg = 60, toleranceDeg = 20;
const int leastColumns = 8; // of a face of the groove

struct Calibration
{
    cv::Mat K, D, R_cam2gripper, t_cam2gripper, lightPlane, covariance;
    double robotTranslationSigma, robotRotationSigma;

    explicit Calibration(const std::string& path)
    {
        const cv::FileStorage file(path, cv::FileStorage::READ);
        if (!file.isOpened())
            throw std::runtime_error(path + ": cannot be read");
        file["camera_matrix"] >> K;
        file["distortion_coefficients"] >> D;
        file["R_cam2gripper"] >> R_cam2gripper;
        file["t_cam2gripper"] >> t_cam2gripper;
        file["light_plane"] >> lightPlane;
        file["covariance"] >> covariance;
        file["noise_levels"]["robot_translation"]["level"] >> robotTranslationSigma;
        file["noise_levels"]["robot_rotation"]["level"] >> robotRotationSigma;
        if (lightPlane.empty() || covariance.empty())
            throw std::runtime_error(path + ": needs a light plane and a covariance");
    }
};

//! The corners found so far, one for each view that shows the groove.
struct Roots
{
    cv::Mat pixels, covariances; // (N, 2), (N, 4)
    std::vector<int> views;

    //! The corner of this view whose opening angle is nearest to the groove's, if one is near enough.
    void add(int view, const cv::Mat& image, const cv::Mat& background, const Calibration& tool)
    {
        using namespace cv::active_handeye;
        cv::Mat stripe, sigmas, pieces, corners, spreads, angles, segments;
        detectStripe(image, stripe, sigmas, background);
        if (stripe.empty())
            return;
        splitStripe(stripe, sigmas, tool.K, tool.D, pieces, 0.6, 6, leastColumns);
        findProfileCorners(stripe, sigmas, pieces, tool.K, tool.D, tool.lightPlane, corners, spreads, angles, segments);
        int best = -1;
        double least = toleranceDeg;
        for (int i = 0; i < angles.rows; ++i)
            if (std::abs(angles.at<double>(i) - openingDeg) <= least)
                least = std::abs(angles.at<double>(i) - openingDeg), best = i;
        if (best < 0)
            return;
        pixels.push_back(corners.row(best));
        covariances.push_back(cv::Mat(1, 4, CV_64F, spreads.ptr<double>(best)));
        views.push_back(view);
    }
};

void run(const std::string& folder, const Calibration& tool)
{
    const YAML::Node views = YAML::LoadFile(folder + "/dataset.yaml")["views"];
    std::vector<cv::Mat> R, t;
    Roots roots;
    for (const YAML::Node& view : views)
    {
        R.push_back(recording::matrix(view["R_gripper2base"]));
        t.push_back(recording::matrix(view["t_gripper2base"]));
        const auto image = [&](const char* key)
        {
            return view[key].IsNull() ? cv::Mat()
                                      : cv::imread(folder + "/" + view[key].as<std::string>(), cv::IMREAD_UNCHANGED);
        };
        const cv::Mat lit = image("laser_image");
        if (!lit.empty())
            roots.add(int(R.size()) - 1, lit, image("image"), tool);
    }
    if (roots.views.empty())
        throw std::runtime_error(folder + ": no groove of 60 degrees in its laser images");

    std::vector<int> ids;
    for (size_t i = 0; i < roots.views.size(); ++i)
        ids.push_back(int(i));
    cv::Mat points, covariances, disagreements;
    cv::active_handeye::measureStripePoints(R, t, roots.pixels, roots.views, ids, tool.K, tool.D, tool.lightPlane,
                                            tool.R_cam2gripper, tool.t_cam2gripper, points, covariances, disagreements,
                                            tool.covariance, roots.covariances, tool.robotTranslationSigma,
                                            tool.robotRotationSigma);
    std::puts("view,x,y,z,sigma_x,sigma_y,sigma_z  [mm]");
    for (int i = 0; i < points.rows; ++i)
    {
        const double *X = points.ptr<double>(i), *C = covariances.ptr<double>(i);
        std::printf("%d,%.3f,%.3f,%.3f,%.3f,%.3f,%.3f\n", roots.views[size_t(i)], 1e3 * X[0], 1e3 * X[1], 1e3 * X[2],
                    1e3 * std::sqrt(C[0]), 1e3 * std::sqrt(C[4]), 1e3 * std::sqrt(C[8]));
    }
}

} // namespace

int main(int argc, char** argv)
{
    if (argc != 3)
    {
        std::fprintf(stderr, "usage: %s DATASET CALIBRATION\n", argv[0]);
        return 2;
    }
    try
    {
        run(argv[1], Calibration(argv[2]));
        return 0;
    }
    catch (const std::exception& error)
    {
        std::fprintf(stderr, "error: %s\n", error.what());
        return 4;
    }
}
