// SPDX-FileCopyrightText: 2026 active_handeye contributors
// SPDX-License-Identifier: Apache-2.0

// A DENSO arm (RC8, RC8A, RC9) over b-CAP without Python: prints where the flange is and what the moves of a plan would be; with --live and
// a typed confirmation it makes them. Two connections: one moves, the other one watches and halts.
//
// denso_live HOST[:PORT] [PLAN] [--live], with the plan.yaml that cv-active-handeye plan writes; doc/files.md describes it. Practise with
// cv-active-handeye emulate denso. What the Python driver also does and this does not: asks for the convention of the angles (this uses
// none), checks no-go boxes and tool points, and restores tool and work frame.
#include "bcap.hpp"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <exception>
#include <iostream>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

using bcap::List;
using bcap::Value;
using Clock = std::chrono::steady_clock;

const double externalPercent = 0.4; // of the arm's full speed: 0.05 m/s of an arm that does 12 m/s
const double maxStepMm = 100, maxStepDeg = 30, arrivedMm = 0.05, arrivedDeg = 0.01;
const double radian = 57.29577951308232;

//! Position (mm), orient vector and approach vector: second and third column of the rotation, flange to base.
struct Pose
{
    std::array<double, 9> values;

    double distanceMm(const Pose& other) const
    {
        return std::hypot(values[0] - other.values[0], values[1] - other.values[1], values[2] - other.values[2]);
    }

    double angleDeg(const Pose& other) const
    {
        // |R1 - R2|^2 = 8 sin^2(angle / 2), with the first column as the cross product of the others.
        double sum = 0;
        const std::array<double, 3> first = firstColumn(), second = other.firstColumn();
        for (size_t i = 0; i < 3; ++i)
            sum += std::pow(first[i] - second[i], 2);
        for (size_t i = 3; i < 9; ++i)
            sum += std::pow(values[i] - other.values[i], 2);
        return 2 * radian * std::asin(std::min(1.0, std::sqrt(sum / 8)));
    }

    void print(const std::string& name) const
    {
        std::printf("%-8s %9.3f %9.3f %9.3f mm   o %8.5f %8.5f %8.5f   a %8.5f %8.5f %8.5f\n", name.c_str(), values[0],
                    values[1], values[2], values[3], values[4], values[5], values[6], values[7], values[8]);
    }

private:
    std::array<double, 3> firstColumn() const
    {
        const double *o = values.data() + 3, *a = values.data() + 6;
        return {{o[1] * a[2] - o[2] * a[1], o[2] * a[0] - o[0] * a[2], o[0] * a[1] - o[1] * a[0]}};
    }
};

struct Plan
{
    std::vector<Pose> stops;
    std::array<double, 3> lower, upper; // box of the flange, mm

    explicit Plan(const std::string& path)
    {
        const YAML::Node plan = YAML::LoadFile(path);
        lower = plan["workspace"]["box"]["lower_mm"].as<std::array<double, 3>>();
        upper = plan["workspace"]["box"]["upper_mm"].as<std::array<double, 3>>();
        for (const YAML::Node& stop : plan["stops"])
        {
            const auto R = stop["R_gripper2base"].as<std::array<std::array<double, 3>, 3>>();
            const auto t = stop["t_gripper2base"].as<std::array<double, 3>>();
            Pose pose;
            for (size_t i = 0; i < 3; ++i)
            {
                pose.values[i] = 1000 * t[i];
                pose.values[3 + i] = R[i][1];
                pose.values[6 + i] = R[i][2];
            }
            stops.push_back(pose);
        }
    }

    //! Refuses a stop outside of the box, or too far from the one before.
    void check(const Pose& start) const
    {
        Pose before = start;
        for (size_t i = 0; i < stops.size(); ++i)
        {
            const std::string name = "stop " + std::to_string(i + 1);
            for (size_t axis = 0; axis < 3; ++axis)
                if (stops[i].values[axis] < lower[axis] || stops[i].values[axis] > upper[axis])
                    throw std::runtime_error(name + " is outside of the plan's box");
            if (before.distanceMm(stops[i]) > maxStepMm || before.angleDeg(stops[i]) > maxStepDeg)
                throw std::runtime_error(name + " is more than 100 mm or 30 deg from the pose before it");
            before = stops[i];
        }
    }
};

//! A connection with its controller and robot.
class Link
{
public:
    Link(const std::string& host, int port) : client_(host, port)
    {
        controller_ = client_.call(bcap::CONTROLLER_CONNECT, {"", "CaoProv.DENSO.VRC", "localhost", ""});
        robot_ = client_.call(bcap::CONTROLLER_GET_ROBOT, {controller_, "Arm", ""});
    }

    Value execute(const std::string& command, const Value& parameter = Value(), double seconds = 2)
    {
        return client_.call(bcap::ROBOT_EXECUTE, {robot_, command, parameter}, seconds);
    }

    double controllerVariable(const std::string& name)
    {
        return read(client_.call(bcap::CONTROLLER_GET_VARIABLE, {controller_, name, ""}));
    }

    double robotVariable(const std::string& name)
    {
        return read(client_.call(bcap::ROBOT_GET_VARIABLE, {robot_, name, ""}));
    }

    Pose pose()
    {
        const std::vector<double> numbers = execute("CurTrn", Value(), 0.2).numbers(9);
        Pose out;
        std::copy_n(numbers.begin(), 9, out.values.begin());
        return out;
    }

    void halt() { client_.call(bcap::ROBOT_HALT, {robot_, ""}, 0.5); }

    void beginStraightMove(const Pose& target)
    {
        List numbers(target.values.begin(), target.values.end());
        numbers.push_back(-1.0); // figure: as it is
        client_.begin(bcap::ROBOT_MOVE, {robot_, 2, List{numbers, "T", "@E"}, ""});
    }

    bool ended(double seconds)
    {
        Value nothing;
        return client_.poll(seconds, nothing);
    }

private:
    double read(const Value& handle)
    {
        const double value = client_.call(bcap::VARIABLE_GET_VALUE, {handle}, 0.2).number();
        client_.call(bcap::VARIABLE_RELEASE, {handle}, 0.2);
        return value;
    }

    bcap::Client client_;
    Value controller_, robot_;
};

//! Nothing may move unless the controller is in automatic mode, without error, and no emergency stop is pressed.
void requireReady(Link& watch)
{
    if (watch.controllerVariable("@EMERGENCY_STOP") != 0)
        throw std::runtime_error("the emergency stop is pressed");
    if (watch.controllerVariable("@ERROR_CODE") != 0)
        throw std::runtime_error("the controller has an error: find its cause and clear it at the pendant");
    if (watch.controllerVariable("@MODE") != 3)
        throw std::runtime_error("the controller is not in automatic mode");
}

//! The arm, taken and with its motor on; given back, and the motor as it was, whatever happens.
class Arm
{
public:
    explicit Arm(Link& link) : link_(link)
    {
        link_.execute("TakeArm", List{0, 0});
        try
        {
            link_.execute("ExtSpeed", List{externalPercent, externalPercent, externalPercent});
            wasOn_ = link_.robotVariable("@SERVO_ON") != 0;
            if (!wasOn_)
                link_.execute("Motor", List{1, 0}, 10);
        }
        catch (...)
        {
            release();
            throw;
        }
    }
    Arm(const Arm&) = delete;
    Arm& operator=(const Arm&) = delete;
    ~Arm() { release(); }

    //! Moves and watches; halts on any doubt.
    void move(const Pose& target, Link& watch)
    {
        requireReady(watch);
        const Pose start = watch.pose();
        const double way = std::max(start.distanceMm(target), 4 * start.angleDeg(target)); // 1 deg as 4 mm
        const auto deadline = Clock::now() + std::chrono::duration<double>(5 + way / 5);
        link_.beginStraightMove(target);
        try
        {
            while (!link_.ended(0.02))
            {
                requireReady(watch);
                if (watch.pose().distanceMm(start) > start.distanceMm(target) + 2)
                    throw std::runtime_error("the arm went beyond the target");
                if (Clock::now() > deadline)
                    throw std::runtime_error("the move takes far too long");
            }
        }
        catch (...)
        {
            watch.halt();
            waitForTheEnd();
            throw;
        }
        const Pose now = watch.pose();
        if (now.distanceMm(target) > arrivedMm || now.angleDeg(target) > arrivedDeg)
            throw std::runtime_error("the controller says done, but the arm is not there");
    }

private:
    //! After a halt the motion's call ends, with an error as a rule.
    void waitForTheEnd()
    {
        try
        {
            link_.ended(2);
        }
        catch (const std::exception&)
        {}
    }

    void release()
    {
        try
        {
            if (!wasOn_)
                link_.execute("Motor", List{0, 0}, 10);
            link_.execute("GiveArm");
        }
        catch (const std::exception& error)
        {
            std::fprintf(stderr, "warning: motor and arm could not be restored: %s\n", error.what());
        }
    }

    Link& link_;
    bool wasOn_ = true; // until it is known
};

bool confirmed(const std::string& host)
{
    std::printf("The arm at %s will move. Nobody within its reach? Emergency stop at hand? Type the word move: ",
                host.c_str());
    std::fflush(stdout);
    std::string answer;
    std::getline(std::cin, answer);
    return answer == "move";
}

int run(const std::string& host, int port, const std::string& planPath, bool isLive)
{
    Link watch(host, port);
    const Pose start = watch.pose();
    start.print("flange");
    if (planPath.empty())
        return 0;
    const Plan plan(planPath);
    plan.check(start);
    for (size_t i = 0; i < plan.stops.size(); ++i)
        plan.stops[i].print("stop " + std::to_string(i + 1));
    if (!isLive)
    {
        std::puts("Nothing was moved; --live makes these moves.");
        return 0;
    }
    if (!confirmed(host))
    {
        std::puts("Nothing was moved.");
        return 1;
    }
    requireReady(watch);
    Link link(host, port);
    Arm arm(link);
    for (const Pose& stop : plan.stops)
    {
        arm.move(stop, watch);
        watch.pose().print("reached");
    }
    return 0;
}

} // namespace

int main(int argc, char** argv)
{
    std::vector<std::string> words(argv + 1, argv + argc);
    const auto live = std::find(words.begin(), words.end(), "--live");
    const bool isLive = live != words.end();
    if (isLive)
        words.erase(live);
    if (words.empty() || words.size() > 2 || words[0][0] == '-')
    {
        std::fprintf(stderr, "usage: %s HOST[:PORT] [PLAN] [--live]\n", argv[0]);
        return 2;
    }
    try
    {
        const size_t colon = words[0].find(':');
        const int port = colon == std::string::npos ? 5007 : std::stoi(words[0].substr(colon + 1));
        return run(words[0].substr(0, colon), port, words.size() > 1 ? words[1] : std::string(), isLive);
    }
    catch (const std::exception& error)
    {
        std::fprintf(stderr, "error: %s\n", error.what());
        return 4;
    }
}
