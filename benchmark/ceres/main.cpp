// SPDX-FileCopyrightText: 2026 active_handeye contributors
// SPDX-License-Identifier: Apache-2.0

// Joint refinement of camera, lens, hand-eye transform, robot poses and points by Ceres, written as its users write it.
// Usage: refine_ceres PROBLEM SOLVER TOLERANCE ROUNDS >SOLUTION; the two files are written and read by benchmark/refine_problem.py.

#include <ceres/ceres.h>
#include <ceres/rotation.h>

#include <ctime>
#include <fstream>
#include <iostream>
#include <limits>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

struct Observation
{
    int view, point;
    double x, y;
};

//! As the robot reports it; R row by row.
struct Pose
{
    double R[9], t[3];
};

struct Problem
{
    double pixelSigma, rotationSigma, translationSigma;
    std::vector<double> camera;      //!< fx, fy, cx, cy, k1, k2
    std::vector<double> handEye;     //!< rotation vector and translation, cam2gripper
    std::vector<Pose> poses;         //!< gripper2base
    std::vector<double> corrections; //!< of each pose: w, e; true R = exp(w) R, true t = t + e
    std::vector<double> points;      //!< base frame
    std::vector<Observation> observations;
};

Problem readProblem(const std::string& path)
{
    std::ifstream file(path);
    size_t views = 0, points = 0, observations = 0;
    Problem p;
    file >> views >> points >> observations >> p.pixelSigma >> p.rotationSigma >> p.translationSigma;
    p.camera.resize(6);
    p.handEye.resize(6);
    p.poses.resize(views);
    p.corrections.assign(6 * views, 0.);
    p.points.resize(3 * points);
    p.observations.resize(observations);
    for (double& value : p.camera)
        file >> value;
    for (double& value : p.handEye)
        file >> value;
    for (Pose& pose : p.poses)
    {
        for (double& value : pose.R)
            file >> value;
        for (double& value : pose.t)
            file >> value;
    }
    for (double& value : p.points)
        file >> value;
    for (Observation& o : p.observations)
        file >> o.view >> o.point >> o.x >> o.y;
    if (!file)
        throw std::runtime_error(path + ": cannot be read as a problem");
    return p;
}

struct Reprojection
{
    const Pose& pose;
    const Observation& seen;
    double sigma;

    template <typename T>
    bool operator()(const T* camera, const T* handEye, const T* correction, const T* point, T* residuals) const
    {
        const T back[] = {-correction[0], -correction[1], -correction[2]};
        const T fromGripper[] = {point[0] - (pose.t[0] + correction[3]), point[1] - (pose.t[1] + correction[4]),
                                 point[2] - (pose.t[2] + correction[5])};
        T turned[3];
        ceres::AngleAxisRotatePoint(back, fromGripper, turned);
        T fromCamera[3];
        for (int i = 0; i < 3; ++i)
            fromCamera[i] =
                pose.R[i] * turned[0] + pose.R[3 + i] * turned[1] + pose.R[6 + i] * turned[2] - handEye[3 + i];
        const T toCamera[] = {-handEye[0], -handEye[1], -handEye[2]};
        T X[3];
        ceres::AngleAxisRotatePoint(toCamera, fromCamera, X);
        const T x = X[0] / X[2], y = X[1] / X[2], r2 = x * x + y * y;
        const T radial = 1. + r2 * (camera[4] + r2 * camera[5]);
        residuals[0] = (camera[0] * radial * x + camera[2] - seen.x) / sigma;
        residuals[1] = (camera[1] * radial * y + camera[3] - seen.y) / sigma;
        return true;
    }
};

struct PosePrior
{
    double rotationSigma, translationSigma;

    template <typename T>
    bool operator()(const T* correction, T* residuals) const
    {
        for (int i = 0; i < 3; ++i)
        {
            residuals[i] = correction[i] / rotationSigma;
            residuals[3 + i] = correction[3 + i] / translationSigma;
        }
        return true;
    }
};

//! Points are to be eliminated first.
ceres::Solver::Options makeOptions(Problem& p, const std::string& solver, double tolerance)
{
    static const std::map<std::string, ceres::LinearSolverType> types = {{"DENSE_SCHUR", ceres::DENSE_SCHUR},
                                                                         {"SPARSE_SCHUR", ceres::SPARSE_SCHUR},
                                                                         {"ITERATIVE_SCHUR", ceres::ITERATIVE_SCHUR}};
    ceres::Solver::Options options;
    options.linear_solver_type = types.at(solver);
    options.preconditioner_type = ceres::SCHUR_JACOBI;
    options.num_threads = 1;
    options.max_num_iterations = 200;
    options.function_tolerance = tolerance;
    options.gradient_tolerance = 1e-12;
    options.parameter_tolerance = 1e-12;
    options.linear_solver_ordering.reset(new ceres::ParameterBlockOrdering);
    for (size_t j = 0; j < p.points.size(); j += 3)
        options.linear_solver_ordering->AddElementToGroup(&p.points[j], 0);
    for (size_t i = 0; i < p.corrections.size(); i += 6)
        options.linear_solver_ordering->AddElementToGroup(&p.corrections[i], 1);
    options.linear_solver_ordering->AddElementToGroup(p.camera.data(), 1);
    options.linear_solver_ordering->AddElementToGroup(p.handEye.data(), 1);
    return options;
}

void addResiduals(Problem& p, ceres::Problem& problem)
{
    for (const Observation& o : p.observations)
    {
        const auto cost = new Reprojection{p.poses[size_t(o.view)], o, p.pixelSigma};
        problem.AddResidualBlock(new ceres::AutoDiffCostFunction<Reprojection, 2, 6, 6, 6, 3>(cost), nullptr,
                                 p.camera.data(), p.handEye.data(), &p.corrections[size_t(o.view) * 6],
                                 &p.points[size_t(o.point) * 3]);
    }
    for (size_t i = 0; i < p.corrections.size(); i += 6)
    {
        const auto prior = new PosePrior{p.rotationSigma, p.translationSigma};
        problem.AddResidualBlock(new ceres::AutoDiffCostFunction<PosePrior, 6, 6>(prior), nullptr, &p.corrections[i]);
    }
}

double seconds()
{
    return double(std::clock()) / CLOCKS_PER_SEC; // of this process
}

void write(const std::vector<double>& values)
{
    for (double value : values)
        std::cout << value << '\n';
}

//! The fastest of several solutions from the same start: processor time of Solve() alone, without building the problem.
void solve(const Problem& start, const std::string& solver, double tolerance, int rounds)
{
    double fastest = std::numeric_limits<double>::infinity();
    ceres::Solver::Summary summary;
    Problem p;
    for (int round = 0; round < rounds; ++round)
    {
        p = start;
        ceres::Problem problem;
        addResiduals(p, problem);
        const ceres::Solver::Options options = makeOptions(p, solver, tolerance);
        const double begin = seconds();
        ceres::Solve(options, &problem, &summary);
        fastest = std::min(fastest, seconds() - begin);
    }
    if (!summary.IsSolutionUsable() || summary.termination_type == ceres::NO_CONVERGENCE)
        throw std::runtime_error(solver + ": " + summary.message);
    std::cout.precision(17);
    std::cout << fastest << '\n' << summary.iterations.size() << '\n' << 2 * summary.final_cost << '\n';
    write(p.camera);
    write(p.handEye);
    write(p.corrections);
    write(p.points);
}

} // namespace

int main(int argc, char** argv)
{
    if (argc != 5)
    {
        std::cerr << "usage: " << argv[0] << " PROBLEM DENSE_SCHUR|SPARSE_SCHUR|ITERATIVE_SCHUR TOLERANCE ROUNDS\n";
        return 2;
    }
    try
    {
        solve(readProblem(argv[1]), argv[2], std::stod(argv[3]), std::stoi(argv[4]));
    }
    catch (const std::exception& e)
    {
        std::cerr << argv[0] << ": " << e.what() << '\n';
        return 1;
    }
    return 0;
}
