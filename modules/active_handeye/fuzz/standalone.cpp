// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// A driver for compilers without libFuzzer: changes inputs at random for some seconds. The sanitizers end it at a finding; the input of the
// last run is then in the file fuzz_last_input.
#include "opencv2/core.hpp"
#include "opencv2/core/utils/logger.hpp"

#include <chrono>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <vector>

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size);

static std::vector<uint8_t> mutated(std::vector<uint8_t> input, cv::RNG& rng)
{
    for (int change = rng.uniform(1, 9); change > 0; --change)
    {
        const size_t at = size_t(rng.uniform(0, int(input.size())));
        const int kind = rng.uniform(0, 4);
        if (kind == 0)
            input[at] = uint8_t(rng.uniform(0, 256));
        else if (kind == 1)
            input[at] = uint8_t(rng.uniform(0, 2) * 255);
        else if (kind == 2)
            input.resize(at + 1);
        else
            input.insert(input.end(), size_t(rng.uniform(1, 400)), uint8_t(rng.uniform(0, 256)));
    }
    input.resize(std::min(input.size(), size_t(40000)));
    return input;
}

int main(int argc, char** argv)
{
    double seconds = 0;
    if (argc != 2 || std::sscanf(argv[1], "-max_total_time=%lf", &seconds) != 1)
    {
        std::fprintf(stderr, "usage: %s -max_total_time=SECONDS\n", argv[0]);
        return 2;
    }
    cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
    cv::RNG rng(1);
    std::vector<std::vector<uint8_t>> corpus;
    for (int i = 0; i < 64; ++i)
    {
        std::vector<uint8_t> seed(size_t(rng.uniform(20, 8000)));
        for (uint8_t& byte : seed)
            byte = uint8_t(rng.uniform(0, 256));
        corpus.push_back(seed);
    }
    const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
    unsigned long runs = 0;
    for (; std::chrono::steady_clock::now() < end; ++runs)
    {
        std::vector<uint8_t>& chosen = corpus[size_t(rng.uniform(0, int(corpus.size())))];
        const std::vector<uint8_t> input = mutated(chosen, rng);
        std::ofstream("fuzz_last_input", std::ios::binary)
            .write(reinterpret_cast<const char*>(input.data()), long(input.size()));
        LLVMFuzzerTestOneInput(input.data(), input.size());
        if (rng.uniform(0, 8) == 0)
            chosen = input;
    }
    std::printf("%lu runs without a finding\n", runs);
    return 0;
}
