// SPDX-FileCopyrightText: 2026 active_handeye contributors
// SPDX-License-Identifier: Apache-2.0

// A UR arm through ur_rtde: prints where its tool centre point is; with --live and a typed confirmation it makes small
// translations of the flange, each watched by a loop of our own, and gives the tool centre point back.
//
// ur_live HOST [--live]. Practise with cv-active-handeye emulate ur. What the Python driver also does and this does not:
// it asks the ports before ur_rtde does (ur_rtde waits for ever on one that is silent), runs ur_rtde in a process that
// can be ended, sets the controller's watchdog, and checks boxes and joint limits.
#include <ur_rtde/rtde_control_interface.h>
#include <ur_rtde/rtde_receive_interface.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <exception>
#include <iostream>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

namespace {

using Clock = std::chrono::steady_clock;
using Pose = std::vector<double>; // position (m) and rotation vector (rad)

const double speed = 0.05, acceleration = 0.2, deceleration = 2; // m/s, m/s^2
const double stepM = 0.02, beyondM = 0.002, arrivedM = 5e-5;
const std::chrono::milliseconds freshness(200), watchEvery(10), settling(200), restAtMost(5000);
const double streamHz = 125;

volatile std::sig_atomic_t interrupted = 0;

void interrupt(int)
{
    interrupted = 1;
}

double distance(const Pose& a, const Pose& b)
{
    return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

void print(const std::string& name, const Pose& pose)
{
    std::printf("%-8s %9.3f %9.3f %9.3f mm   %9.6f %9.6f %9.6f rad\n", name.c_str(), 1000 * pose[0], 1000 * pose[1],
                1000 * pose[2], pose[3], pose[4], pose[5]);
}

//! Column `axis` of the rotation matrix of a rotation vector (Rodrigues' formula): a flange axis in the base frame.
std::array<double, 3> flangeAxis(const Pose& pose, size_t axis)
{
    const double angle = std::hypot(pose[3], pose[4], pose[5]);
    std::array<double, 3> column{{0, 0, 0}};
    column[axis] = 1;
    if (angle < 1e-12)
        return column;
    const std::array<double, 3> k{{pose[3] / angle, pose[4] / angle, pose[5] / angle}};
    const std::array<double, 3> e = column;
    const std::array<double, 3> cross{
        {k[1] * e[2] - k[2] * e[1], k[2] * e[0] - k[0] * e[2], k[0] * e[1] - k[1] * e[0]}};
    for (size_t i = 0; i < 3; ++i)
        column[i] = e[i] * std::cos(angle) + cross[i] * std::sin(angle) + k[i] * k[axis] * (1 - std::cos(angle));
    return column;
}

//! The start's neighbours along the flange's axes (along z backwards, away from what the tool points at), and itself.
std::vector<Pose> translations(const Pose& start)
{
    std::vector<Pose> stops;
    for (size_t axis = 0; axis < 3; ++axis)
    {
        const std::array<double, 3> along = flangeAxis(start, axis);
        Pose stop = start;
        for (size_t i = 0; i < 3; ++i)
            stop[i] += (axis == 2 ? -stepM : stepM) * along[i];
        stops.push_back(stop);
    }
    stops.push_back(start);
    return stops;
}

//! The stream of the controller's state; every reading is checked.
class Watch
{
public:
    explicit Watch(const std::string& host) : receive_(host, streamHz) {}

    //! Throws where the arm must not be moved, or the clock of the controller has stood still for too long.
    Pose pose()
    {
        if (!receive_.isConnected())
            throw std::runtime_error("link lost: check cable and network");
        if (receive_.isEmergencyStopped())
            throw std::runtime_error("emergency stop");
        if (receive_.isProtectiveStopped())
            throw std::runtime_error("protective stop: find its cause and clear it at the pendant");
        const double time = receive_.getTimestamp();
        const auto now = Clock::now();
        if (time != time_)
            time_ = time, advanced_ = now;
        else if (now - advanced_ > freshness)
            throw std::runtime_error("stale pose: the controller's clock stands still");
        return receive_.getActualTCPPose();
    }

    //! A pose that the controller sent after this call began.
    Pose freshPose()
    {
        pose();
        const double before = time_;
        for (;;)
        {
            const Pose now = pose();
            if (time_ != before)
                return now;
            std::this_thread::sleep_for(std::chrono::milliseconds(2));
        }
    }

private:
    ur_rtde::RTDEReceiveInterface receive_;
    double time_ = -1;
    Clock::time_point advanced_ = Clock::now();
};

//! The arm with its flange as tool centre point; stopped, and the tool as it was, whatever happens.
class Arm
{
public:
    Arm(const std::string& host, Watch& watch) : watch_(watch), control_(host, streamHz)
    {
        tool_ = control_.getTCPOffset();
        if (!control_.setTcp(Pose(6, 0.0)))
            throw std::runtime_error("the tool centre point could not be set to the flange");
        std::this_thread::sleep_for(settling); // until the stream shows poses of the flange
    }
    Arm(const Arm&) = delete;
    Arm& operator=(const Arm&) = delete;

    ~Arm()
    {
        try
        {
            if (!control_.setTcp(tool_))
                throw std::runtime_error("refused");
            control_.stopScript();
        }
        catch (const std::exception& error)
        {
            std::fprintf(
                stderr,
                "warning: the tool centre point may still be the flange (%s); it was p[%g, %g, %g, %g, %g, %g]: "
                "set it at the pendant\n",
                error.what(), tool_[0], tool_[1], tool_[2], tool_[3], tool_[4], tool_[5]);
        }
    }

    void check(const Pose& target)
    {
        if (!control_.isPoseWithinSafetyLimits(target) || !control_.getInverseKinematicsHasSolution(target))
            throw std::runtime_error("a stop is outside of the safety limits or of the arm's reach; nothing was moved");
    }

    //! Moves asynchronously and watches; stops on any doubt.
    void move(const Pose& target)
    {
        const Pose start = watch_.freshPose();
        const double way = distance(start, target);
        const auto deadline =
            Clock::now() + std::chrono::duration<double>(2 + 3 * (way / speed + speed / acceleration));
        if (!control_.moveL(target, speed, acceleration, true))
            throw std::runtime_error("the controller did not begin the move; see the pendant");
        try
        {
            while (distance(watch_.pose(), target) > arrivedM)
            {
                if (interrupted)
                    throw std::runtime_error("interrupted");
                if (distance(watch_.pose(), start) > way + beyondM)
                    throw std::runtime_error("the arm went beyond the target");
                if (Clock::now() > deadline)
                    throw std::runtime_error("the move takes far too long");
                std::this_thread::sleep_for(watchEvery);
            }
            rest();
        }
        catch (...)
        {
            control_.stopL(deceleration, true);
            std::this_thread::sleep_for(settling); // it takes 25 ms from this speed
            throw;
        }
    }

private:
    void rest()
    {
        const auto deadline = Clock::now() + restAtMost;
        while (!control_.isSteady())
        {
            watch_.pose();
            if (Clock::now() > deadline)
                throw std::runtime_error("the arm does not come to rest");
            std::this_thread::sleep_for(watchEvery);
        }
    }

    Watch& watch_;
    ur_rtde::RTDEControlInterface control_;
    Pose tool_;
};

bool confirmed(const std::string& host)
{
    std::printf(
        "The arm at %s will make %.0f mm moves along its flange's axes. Nobody within its reach? Emergency stop "
        "at hand? Type the word move: ",
        host.c_str(), 1000 * stepM);
    std::fflush(stdout);
    std::string answer;
    std::getline(std::cin, answer);
    return answer == "move";
}

int run(const std::string& host, bool isLive)
{
    Watch watch(host);
    print("tool", watch.freshPose());
    if (!isLive)
    {
        std::puts("Nothing was moved; --live makes small moves.");
        return 0;
    }
    if (!confirmed(host))
    {
        std::puts("Nothing was moved.");
        return 1;
    }
    std::signal(SIGINT, interrupt);
    std::signal(SIGTERM, interrupt);
    Arm arm(host, watch);
    const Pose start = watch.freshPose();
    print("flange", start);
    const std::vector<Pose> stops = translations(start);
    for (const Pose& stop : stops)
        arm.check(stop);
    for (const Pose& stop : stops)
    {
        arm.move(stop);
        print("reached", watch.freshPose());
    }
    return 0;
}

} // namespace

int main(int argc, char** argv)
{
    const bool isLive = argc == 3 && std::string(argv[2]) == "--live";
    if (argc < 2 || argc > 3 || (argc == 3 && !isLive) || argv[1][0] == '-')
    {
        std::fprintf(stderr, "usage: %s HOST [--live]\n", argv[0]);
        return 2;
    }
    try
    {
        return run(argv[1], isLive);
    }
    catch (const std::exception& error)
    {
        std::fprintf(stderr, "error: %s\n", error.what());
        return 4;
    }
}
