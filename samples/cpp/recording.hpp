// SPDX-FileCopyrightText: 2026 active_handeye contributors
// SPDX-License-Identifier: Apache-2.0

// Reads a data set folder (doc/files.md) for the samples: poses, image points and, where there are any, board points.
#ifndef ACTIVE_HANDEYE_SAMPLES_RECORDING_HPP
#define ACTIVE_HANDEYE_SAMPLES_RECORDING_HPP

#include <opencv2/core.hpp>

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <limits>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace recording {

//! A list of numbers, or of rows of numbers, as 3 x n.
inline cv::Mat matrix(const YAML::Node& node)
{
    cv::Mat result;
    for (const YAML::Node& row : node)
        for (const YAML::Node& value : row.IsSequence() ? row : YAML::Node(std::vector<double>{row.as<double>()}))
            result.push_back(value.as<double>());
    return result.reshape(1, 3);
}

//! Rows of four numbers below the given header; throws where the file says something else.
inline std::vector<std::array<double, 4>> table(const std::string& path, const std::string& header)
{
    std::ifstream file(path);
    std::string line;
    if (!std::getline(file, line) || line != header)
        throw std::runtime_error(path + ": needs the header " + header + ", given " +
                                 (line.empty() ? "nothing" : line));
    std::vector<std::array<double, 4>> rows;
    while (std::getline(file, line))
    {
        std::istringstream cells(line);
        std::array<double, 4> row;
        std::string cell;
        for (double& value : row)
        {
            std::getline(cells, cell, ',');
            value = std::stod(cell);
        }
        rows.push_back(row);
    }
    if (rows.empty())
        throw std::runtime_error(path + ": has no rows");
    return rows;
}

//! Where nothing was seen: (rows, cols) of NaN.
inline cv::Mat unknown(int rows, int cols)
{
    return cv::Mat(rows, cols, CV_64F, cv::Scalar(std::numeric_limits<double>::quiet_NaN()));
}

//! A recording whose points were found already. Metres and pixels.
struct Recording
{
    cv::Size image;
    std::vector<cv::Mat> R_gripper2base, t_gripper2base; // one 3 x 3 and one 3 x 1 a view
    std::vector<cv::Mat> imagePoints;                    // one (N, 2) a view, NaN where a point is not seen
    cv::Mat boardPoints;                                 // (M, 3), NaN where no row names the point; or empty

    explicit Recording(const std::string& folder)
    {
        const YAML::Node content = YAML::LoadFile(folder + "/dataset.yaml");
        image = cv::Size(content["camera"]["width"].as<int>(), content["camera"]["height"].as<int>());
        for (const YAML::Node& view : content["views"])
        {
            R_gripper2base.push_back(matrix(view["R_gripper2base"]));
            t_gripper2base.push_back(matrix(view["t_gripper2base"]));
        }
        if (!named(content, "image_points"))
            throw std::runtime_error(folder + ": names no image_points; without them the points have to be tracked in "
                                              "the images, which cv-active-handeye calibrate does");
        readImagePoints(folder + "/" + content["image_points"].as<std::string>());
        if (named(content, "board_points"))
            readBoardPoints(folder + "/" + content["board_points"].as<std::string>());
    }

private:
    static bool named(const YAML::Node& content, const char* key) { return content[key] && !content[key].IsNull(); }

    static int points(const std::vector<std::array<double, 4>>& rows, size_t column)
    {
        double largest = 0;
        for (const auto& row : rows)
            largest = std::max(largest, row[column]);
        return int(largest) + 1;
    }

    void readImagePoints(const std::string& path)
    {
        const auto rows = table(path, "view,point,u_px,v_px");
        const int count = points(rows, 1);
        for (size_t view = 0; view < R_gripper2base.size(); ++view)
            imagePoints.push_back(unknown(count, 2));
        for (const auto& row : rows)
            for (int k = 0; k < 2; ++k)
                imagePoints.at(size_t(row[0])).at<double>(int(row[1]), k) = row[size_t(2 + k)];
    }

    void readBoardPoints(const std::string& path)
    {
        const auto rows = table(path, "point,X_m,Y_m,Z_m");
        boardPoints = unknown(points(rows, 0), 3);
        for (const auto& row : rows)
            for (int k = 0; k < 3; ++k)
                boardPoints.at<double>(int(row[0]), k) = row[size_t(1 + k)];
    }
};

} // namespace recording

#endif
