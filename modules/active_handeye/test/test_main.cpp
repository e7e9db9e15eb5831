// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.
#include "test_precomp.hpp"

#ifdef ACTIVE_HANDEYE_STANDALONE

namespace {

// As OpenCV's ts does: every test starts from the same state of cv::theRNG(), whatever ran before it.
class SeedRNG : public ::testing::EmptyTestEventListener
{
    void OnTestStart(const ::testing::TestInfo&) CV_OVERRIDE { cv::theRNG().state = 809564; }
};

} // namespace

int main(int argc, char** argv)
{
    ::testing::InitGoogleTest(&argc, argv);
    ::testing::UnitTest::GetInstance()->listeners().Append(new SeedRNG);
    return RUN_ALL_TESTS();
}

#else

CV_TEST_MAIN("cv")

#endif
