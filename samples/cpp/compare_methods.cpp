// SPDX-FileCopyrightText: 2026 active_handeye contributors
// SPDX-License-Identifier: Apache-2.0

// OpenCV's five hand-eye methods on a board beside ours without it, from one recording. OpenCV is told where the points
// lie on the board; ours is not. Without truth the fair question is by how much the board, which stands still, seems to
// move in the base frame. The same as cv-active-handeye compare --board points.
//
// compare_methods DATASET, with image_points and board_points; doc/files.md describes the folder.
#include "recording.hpp"

#include <opencv2/active_handeye.hpp>
#include <opencv2/calib3d.hpp>

#include <algorithm>
#include <cstdio>
#include <exception>

namespace {

using recording::Recording;

const int leastPoints = 6, leastViews = 3;

struct Method
{
    cv::Mat K, D, R, t;
};

//! What one view shows of the board.
struct BoardView
{
    size_t view;
    std::vector<cv::Point3f> board;
    std::vector<cv::Point2f> image;
};

std::vector<BoardView> boardViews(const Recording& seen)
{
    std::vector<BoardView> result;
    for (size_t view = 0; view < seen.imagePoints.size(); ++view)
    {
        BoardView shown{view, {}, {}};
        const cv::Mat& pixels = seen.imagePoints[view];
        for (int j = 0; j < std::min(pixels.rows, seen.boardPoints.rows); ++j)
        {
            const double *x = pixels.ptr<double>(j), *X = seen.boardPoints.ptr<double>(j);
            if (std::isnan(x[0]) || std::isnan(X[0]))
                continue;
            shown.board.emplace_back(float(X[0]), float(X[1]), float(X[2]));
            shown.image.emplace_back(float(x[0]), float(x[1]));
        }
        if (int(shown.board.size()) >= leastPoints)
            result.push_back(shown);
    }
    if (int(result.size()) < leastViews)
        throw std::runtime_error("needs 3 views that show at least 6 points of the board, given " +
                                 std::to_string(result.size()));
    return result;
}

//! Camera matrix and distortion from the board.
Method boardCamera(const Recording& seen, const std::vector<BoardView>& views)
{
    std::vector<std::vector<cv::Point3f>> board;
    std::vector<std::vector<cv::Point2f>> image;
    for (const BoardView& view : views)
        board.push_back(view.board), image.push_back(view.image);
    Method camera;
    std::vector<cv::Mat> rotations, translations;
    cv::calibrateCamera(board, image, seen.image, camera.K, camera.D, rotations, translations);
    return camera;
}

//! Board to camera of every view.
void boardPoses(const std::vector<BoardView>& views, const Method& camera, std::vector<cv::Mat>& R,
                std::vector<cv::Mat>& t)
{
    for (const BoardView& view : views)
    {
        cv::Mat turn, matrix, shift;
        cv::solvePnP(view.board, view.image, camera.K, camera.D, turn, shift);
        cv::Rodrigues(turn, matrix);
        R.push_back(matrix);
        t.push_back(shift);
    }
}

//! RMS distance of the board's middle, in the base frame, from its mean place [mm].
double spread(const Recording& seen, const std::vector<BoardView>& views, const Method& method)
{
    std::vector<cv::Mat> R, t;
    boardPoses(views, method, R, t);
    cv::Vec3d middle(0, 0, 0);
    int known = 0;
    for (int j = 0; j < seen.boardPoints.rows; ++j)
        if (!std::isnan(seen.boardPoints.at<double>(j, 0)))
            middle += cv::Vec3d(seen.boardPoints.ptr<double>(j)), ++known;
    middle /= known;
    cv::Mat places;
    for (size_t i = 0; i < views.size(); ++i)
    {
        const cv::Mat inCamera = R[i] * cv::Mat(middle) + t[i];
        const cv::Mat inGripper = method.R * inCamera + method.t;
        const cv::Mat inBase = seen.R_gripper2base[views[i].view] * inGripper + seen.t_gripper2base[views[i].view];
        places.push_back(inBase.t());
    }
    cv::Mat mean;
    cv::reduce(places, mean, 0, cv::REDUCE_AVG);
    return 1000 * cv::norm(places, cv::repeat(mean, places.rows, 1)) / std::sqrt(places.rows);
}

void print(const std::string& name, const Recording& seen, const std::vector<BoardView>& views, const Method& method)
{
    cv::Mat turn;
    cv::Rodrigues(method.R, turn);
    std::printf("%s,%.4f,%.4f,%.4f,%.6f,%.6f,%.6f,%.5f\n", name.c_str(), 1000 * method.t.at<double>(0),
                1000 * method.t.at<double>(1), 1000 * method.t.at<double>(2), turn.at<double>(0), turn.at<double>(1),
                turn.at<double>(2), spread(seen, views, method));
}

void printOpenCV(const Recording& seen, const std::vector<BoardView>& views)
{
    Method method = boardCamera(seen, views);
    std::vector<cv::Mat> R_gripper2base, t_gripper2base, R_target2cam, t_target2cam;
    boardPoses(views, method, R_target2cam, t_target2cam);
    for (const BoardView& view : views)
    {
        R_gripper2base.push_back(seen.R_gripper2base[view.view]);
        t_gripper2base.push_back(seen.t_gripper2base[view.view]);
    }
    const std::pair<const char*, cv::HandEyeCalibrationMethod> methods[] = {
        {"TSAI", cv::CALIB_HAND_EYE_TSAI},
        {"PARK", cv::CALIB_HAND_EYE_PARK},
        {"HORAUD", cv::CALIB_HAND_EYE_HORAUD},
        {"ANDREFF", cv::CALIB_HAND_EYE_ANDREFF},
        {"DANIILIDIS", cv::CALIB_HAND_EYE_DANIILIDIS}};
    for (const auto& one : methods)
    {
        cv::calibrateHandEye(R_gripper2base, t_gripper2base, R_target2cam, t_target2cam, method.R, method.t,
                             one.second);
        print(one.first, seen, views, method);
    }
}

void run(const std::string& folder)
{
    const Recording seen(folder);
    if (seen.boardPoints.empty())
        throw std::runtime_error(folder + ": names no board_points, which OpenCV's methods need");
    const std::vector<BoardView> views = boardViews(seen);
    std::puts("method,tx,ty,tz [mm],rx,ry,rz [rad],spread of the board [mm]");
    printOpenCV(seen, views);

    Method ours;
    cv::Mat plane;
    cv::active_handeye::RefineSummary summary;
    cv::active_handeye::refineHandEye(seen.R_gripper2base, seen.t_gripper2base, seen.imagePoints, ours.K, ours.D,
                                      ours.R, ours.t, plane, summary);
    print("ours", seen, views, ours);
    std::puts(summary.message.c_str());
}

} // namespace

int main(int argc, char** argv)
{
    if (argc != 2)
    {
        std::fprintf(stderr, "usage: %s DATASET\n", argv[0]);
        return 2;
    }
    try
    {
        run(argv[1]);
        return 0;
    }
    catch (const std::exception& error)
    {
        std::fprintf(stderr, "error: %s\n", error.what());
        return 4;
    }
}
