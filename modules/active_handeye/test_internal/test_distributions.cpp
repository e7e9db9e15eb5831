// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// Tails and quantiles against tables (numbers to twelve digits from an independent program).
#include "../src/precomp.hpp"
#include "../src/distributions.hpp"

#include <gtest/gtest.h>

namespace opencv_test { namespace {

using namespace cv::active_handeye;
const double infinity = std::numeric_limits<double>::infinity();

TEST(ActiveHandEye_Distributions, chi_square)
{
    const double table[][3] = {{3.84, 1, 0.05004352124870519},    {1e-3, 1, 0.9747728793699604},
                               {5.99, 2, 0.05003662708658629},    {2.5, 7.3, 0.9395836572143295},
                               {18.31, 10, 0.04995416634369678},  {40, 10, 1.694474393006737e-05},
                               {150, 100, 0.0009039320423540184}, {60, 100, 0.999481108537452},
                               {1000, 1000, 0.49405285382923964}, {100, 1, 1.5239706048320995e-23}};
    for (const auto& row : table)
        EXPECT_NEAR(row[2], chiSquareTail(row[0], row[1]), 1e-11 * row[2]) << row[0] << ", " << row[1];
    EXPECT_EQ(1, chiSquareTail(0, 3));
    EXPECT_EQ(1, chiSquareTail(-1, 3));
}

TEST(ActiveHandEye_Distributions, fisher)
{
    const double table[][4] = {{3.33, 5, 10, 0.049831275797221346}, {0.4, 5, 10, 0.8381652584780424},
                               {4.94, 3, 20, 0.00998530235551495},  {12, 1, 4, 0.025721420742506513},
                               {1.02, 6, 2.5, 0.55258406880004},    {2.1, 6, 150, 0.056450226191970695},
                               {30, 6, 40, 2.4617517328278023e-13}};
    for (const auto& row : table)
        EXPECT_NEAR(row[3], fTail(row[0], row[1], row[2]), 1e-11 * row[3])
            << row[0] << ", " << row[1] << ", " << row[2];
    EXPECT_EQ(1, fTail(0, 3, 5));
    EXPECT_NEAR(chiSquareTail(12, 6), fTail(2, 6, infinity), 1e-15);
    EXPECT_NEAR(chiSquareTail(12, 6), fTail(2, 6, 1e5), 1e-4);
}

TEST(ActiveHandEye_Distributions, student)
{
    const double table[][3] = {{0.05, 1, 12.706204736174705},        {0.05, 2, 4.302652729749464},
                               {0.05, 3.7, 2.8675207071911903},      {0.05, 10, 2.2281388519862753},
                               {0.05, 100, 1.983971518523552},       {0.01, 5, 4.032142983555229},
                               {0.3, 8, 1.1081454445582555},         {1e-6, 12, 9.084692934131269},
                               {0.05, infinity, 1.9599639845400545}, {0.01, 1e9, 2.575829303548901}};
    for (const auto& row : table)
        EXPECT_NEAR(row[2], studentQuantile(row[0], row[1]), 1e-8 * row[2]) << row[0] << ", " << row[1];
}

}} // namespace opencv_test
