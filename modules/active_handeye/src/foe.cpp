// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "foe.hpp"
#include "decompositions.hpp"
#include "least_squares.hpp"
#include "normalization.hpp"
#include "numbers.hpp"

namespace cv { namespace active_handeye {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

struct Match
{
    Vector2d x1, x2; //!< normalised pixels
    Vector3d line;   //!< x1 x x2, the line of the displacement
};

typedef AlignedVector<Match> Matches;

/** Orthogonal distance of both points of a match to their best common line through e.

With d_i the vector from x_i to e this is the smallest eigenvalue of d1 d1^T + d2 d2^T, written so that it stays exact for e at infinity.
*/
double lineDistance(const Vector3d& e, const Match& m, Vector3d* gradient)
{
    const double c = e.dot(m.line);
    const Vector2d d1 = e.head<2>() - e.z() * m.x1, d2 = e.head<2>() - e.z() * m.x2;
    const double T = d1.squaredNorm() + d2.squaredNorm();
    const double S = std::sqrt(std::max(T * T - 4 * e.z() * e.z() * c * c, 0.));
    const double scale = T > 0 ? std::sqrt(2 / (T + S)) : 0;
    if (gradient)
    {
        Vector3d dT, dS = Vector3d::Zero();
        dT << 2 * (d1 + d2), -2 * (d1.dot(m.x1) + d2.dot(m.x2));
        if (S > 1e-9 * T)
            dS = (T * dT - 4 * e.z() * e.z() * c * m.line - 4 * c * c * e.z() * Vector3d::UnitZ()) / S;
        *gradient = scale * m.line;
        if (T > 0)
            *gradient -= 0.5 * c * scale / (T + S) * (dT + dS);
    }
    return c * scale;
}

//! lineDistance() squared to first order, for scoring.
double squaredDistance(const Vector3d& e, const Match& m)
{
    const double c = e.dot(m.line);
    return c * c / ((e.head<2>() - e.z() * m.x1).squaredNorm() + (e.head<2>() - e.z() * m.x2).squaredNorm() + 1e-300);
}

class FOEProblem : public LeastSquaresProblem
{
public:
    FOEProblem(const Matches& matches, const std::vector<uchar>& inliers, const Vector3d& start)
        : e(start), matches_(matches), inliers_(inliers)
    {}

    double linearize(Eigen::MatrixXd& JtJ, Eigen::VectorXd& Jtr) CV_OVERRIDE
    {
        const Eigen::Matrix<double, 3, 2> basis = tangentBasis(e);
        Eigen::Matrix2d H = Eigen::Matrix2d::Zero();
        Vector2d g = Vector2d::Zero();
        double cost = 0;
        for (size_t i = 0; i < matches_.size(); ++i)
        {
            if (!inliers_[i])
                continue;
            Vector3d gradient;
            const double r = lineDistance(e, matches_[i], &gradient);
            const Vector2d J = basis.transpose() * gradient;
            H += J * J.transpose();
            g += J * r;
            cost += r * r;
        }
        JtJ = H;
        Jtr = g;
        return cost;
    }

    double costAfter(const Eigen::VectorXd& step) const CV_OVERRIDE
    {
        const Vector3d moved = (e + tangentBasis(e) * step).normalized();
        double cost = 0;
        for (size_t i = 0; i < matches_.size(); ++i)
            if (inliers_[i])
                cost += std::pow(lineDistance(moved, matches_[i], 0), 2);
        return cost;
    }

    void apply(const Eigen::VectorXd& step) CV_OVERRIDE { e = (e + tangentBasis(e) * step).normalized(); }

    Vector3d e;

private:
    const Matches& matches_;
    const std::vector<uchar>& inliers_;
};

//! Smallest singular vector of the displacement lines; the second and third pass weigh them by their distance from e.
Vector3d linearFOE(const Matches& matches, const std::vector<uchar>& inliers, int passes)
{
    Vector3d e = Vector3d::Zero();
    for (int pass = 0; pass < passes; ++pass)
    {
        Matrix3d A = Matrix3d::Zero();
        for (size_t i = 0; i < matches.size(); ++i)
        {
            if (!inliers[i])
                continue;
            const Match& m = matches[i];
            const double T = (e.head<2>() - e.z() * m.x1).squaredNorm() + (e.head<2>() - e.z() * m.x2).squaredNorm();
            A += m.line * m.line.transpose() / (pass == 0 ? 1. : T + 1e-12);
        }
        e = symmetricEigen(A).eigenvectors().col(0);
    }
    return e;
}

std::vector<uchar> gate(const Matches& matches, const Vector3d& e, double threshold)
{
    std::vector<uchar> inliers(matches.size());
    for (size_t i = 0; i < matches.size(); ++i)
        inliers[i] = squaredDistance(e, matches[i]) <= threshold * threshold;
    return inliers;
}

//! The threshold, or five times the noise where that is less: a wrong match far below the threshold would spoil the covariance.
double narrowed(double threshold, double shortest, const Matches& matches, const std::vector<uchar>& inliers,
                const Vector3d& e)
{
    std::vector<double> distances;
    for (size_t i = 0; i < matches.size(); ++i)
        if (inliers[i])
            distances.push_back(std::sqrt(squaredDistance(e, matches[i])));
    const size_t enough = 10; // fewer leave the noise open
    if (distances.size() < enough)
        return threshold;
    const double sigma = 1.4826 * median(distances);
    return std::min(threshold, std::max(5 * sigma, shortest));
}

//! Sum of squared distances, each at most threshold^2.
double score(const Matches& matches, const Vector3d& e, double threshold)
{
    double sum = 0;
    for (size_t i = 0; i < matches.size(); ++i)
        sum += std::min(squaredDistance(e, matches[i]), threshold * threshold);
    return sum;
}

int count(const std::vector<uchar>& inliers)
{
    return int(std::count(inliers.begin(), inliers.end(), uchar(1)));
}

//! Best FOE over samples of two matches; a better sample is improved by its own inliers at once.
Vector3d ransacFOE(const Matches& matches, double threshold, double confidence)
{
    const uint64 seed = 0x5eed;
    const double maxSamples = 5000;
    RNG rng(seed);
    const int n = int(matches.size());
    Vector3d best = Vector3d::UnitZ();
    double bestScore = std::numeric_limits<double>::infinity(), samplesNeeded = maxSamples;
    for (int sample = 0; sample < samplesNeeded; ++sample)
    {
        const int i = rng.uniform(0, n), j = (i + rng.uniform(1, n)) % n;
        Vector3d e = matches[i].line.cross(matches[j].line);
        if (e.norm() <= 1e-12 * matches[i].line.norm() * matches[j].line.norm())
            continue;
        e.normalize();
        double value = score(matches, e, threshold);
        if (value >= bestScore)
            continue;
        const Vector3d improved = linearFOE(matches, gate(matches, e, threshold), 2);
        const double improvedValue = score(matches, improved, threshold);
        best = improvedValue < value ? improved : e;
        bestScore = std::min(value, improvedValue);
        const double ratio = count(gate(matches, best, threshold)) / double(n);
        samplesNeeded = std::min(maxSamples, std::log(1 - confidence) / std::log(std::max(1 - ratio * ratio, 1e-12)));
    }
    return best;
}

//! +1 or -1: points move away from the FOE when the camera approaches it (doc/method/foe.md).
double motionSign(const Matches& matches, const std::vector<uchar>& inliers, const Vector3d& e)
{
    double sum = 0;
    for (size_t i = 0; i < matches.size(); ++i)
        if (inliers[i])
            sum += (matches[i].x2 - matches[i].x1).dot(e.head<2>() - e.z() * matches[i].x1);
    return sum < 0 ? 1 : -1;
}

double medianDisplacement(const Pixels& points1, const Pixels& points2, const std::vector<uchar>& inliers)
{
    std::vector<double> lengths;
    for (size_t i = 0; i < points1.size(); ++i)
        if (inliers[i])
            lengths.push_back((points2[i] - points1[i]).norm());
    return median(lengths);
}

//! Refuses matches that leave the FOE open. sigma: noise per axis, pixels; JtJ: information in normalised units.
void requireDetermined(const Eigen::Matrix2d& JtJ, double sigma, double scale, double displacement,
                       const std::string& source)
{
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen = symmetricEigen(JtJ);
    const double weakest = eigen.eigenvalues()[0], strongest = eigen.eigenvalues()[1];
    const double maxDeviation = 0.3; // of the direction in normalised coordinates, about 17 degrees on the image
    const bool determined = weakest > 1e-10 * strongest && sigma * scale < maxDeviation * std::sqrt(weakest);
    const double clearlyAboveNoise = 3; // displacements that are noise alone have 1.7 sigma
    if (displacement < 1e-9 || displacement < clearlyAboveNoise * sigma)
        CV_Error(
            Error::StsNoConv,
            cv::format(
                "%s: no parallax; needed displacements well above the noise, given a median displacement of %.3g px at a "
                "residual of %.3g px: translate farther, or come nearer to the scene",
                source.c_str(), displacement, sigma));
    if (!determined)
        CV_Error(Error::StsNoConv,
                 source +
                     ": all displacements lie on one line, the focus of expansion is open along it; needed points in "
                     "different directions from it, given points on one line: use more of the image");
}

} // namespace

FOE estimateFOE(const Pixels& points1, const Pixels& points2, FOEMethod method, double threshold, double confidence,
                const std::string& source)
{
    const int n = int(points1.size());
    if (n < 2)
        CV_Error(Error::StsNoConv, cv::format("%s: needed at least 2 matches, given %d", source.c_str(), n));
    const Normalization T({&points1, &points2});
    Matches matches(n);
    for (int i = 0; i < n; ++i)
    {
        matches[i].x1 = T.apply(points1[i]);
        matches[i].x2 = T.apply(points2[i]);
        matches[i].line = matches[i].x1.homogeneous().cross(matches[i].x2.homogeneous());
    }

    FOE result;
    result.inliers.assign(n, 1);
    if (medianDisplacement(points1, points2, result.inliers) == 0)
        requireDetermined(Eigen::Matrix2d::Zero(), 0, T.scale, 0, source);
    const double gateWidth = threshold * T.scale, rounding = 1e-6 * T.scale;
    if (method == FOE_RANSAC && n > 2)
        result.inliers = gate(matches, ransacFOE(matches, gateWidth, confidence), gateWidth);
    Vector3d e = linearFOE(matches, result.inliers, 3);
    LeastSquaresSummary fit;
    const int maxRounds = method == FOE_RANSAC && n > 2 ? 10 : 1;
    for (int round = 0; round < maxRounds; ++round)
    {
        const std::vector<uchar> last = result.inliers;
        if (round > 0)
            result.inliers = gate(matches, e, narrowed(gateWidth, rounding, matches, last, e));
        if (round > 0 && result.inliers == last)
            break;
        if (n > 3 && count(result.inliers) < std::max(3, n / 10))
            CV_Error(
                Error::StsNoConv,
                cv::format("%s: needed a tenth of the matches to agree on one translation within %g px, given %d of %d",
                           source.c_str(), threshold, count(result.inliers), n));
        FOEProblem problem(matches, result.inliers, e);
        fit = solveLeastSquares(problem);
        e = problem.e;
    }
    result.inlierCount = count(result.inliers);
    const double sigma = result.inlierCount > 2 ? std::sqrt(fit.cost / (result.inlierCount - 2)) / T.scale : 1.;
    requireDetermined(fit.JtJ, result.inlierCount > 2 ? sigma : 0, T.scale,
                      medianDisplacement(points1, points2, result.inliers), source);

    e *= motionSign(matches, result.inliers, e);
    const Vector3d pixelFOE = T.inverse() * e;
    result.direction = pixelFOE.normalized();
    const Matrix3d onSphere =
        (Matrix3d::Identity() - result.direction * result.direction.transpose()) / pixelFOE.norm();
    const Eigen::Matrix<double, 3, 2> J = onSphere * T.inverse() * tangentBasis(e);
    result.covariance = std::pow(sigma * T.scale, 2) * J * fit.JtJ.inverse() * J.transpose();
    return result;
}

int estimateFOE(InputArray points1, InputArray points2, OutputArray foe, OutputArray inlierMask, OutputArray covariance,
                FOEMethod method, double threshold, double confidence)
{
    CV_TRACE_FUNCTION();
    const Pixels x1 = readPixels(points1, "points1"), x2 = readPixels(points2, "points2");
    if (x1.size() != x2.size())
        CV_Error(Error::StsBadSize, cv::format("points2: needed the %d matches of points1, given %d points",
                                               int(x1.size()), int(x2.size())));
    if (method != FOE_LEAST_SQUARES && method != FOE_RANSAC)
        CV_Error(Error::StsBadArg,
                 cv::format("method: needed FOE_LEAST_SQUARES (0) or FOE_RANSAC (1), given %d", int(method)));
    readPositive(threshold, "threshold");
    if (!(confidence > 0 && confidence < 1))
        CV_Error(Error::StsOutOfRange,
                 cv::format("confidence: needed a probability between 0 and 1, given %g", confidence));

    const FOE result = estimateFOE(x1, x2, method, threshold, confidence, "points1, points2");
    writeMatrix(result.direction, foe);
    if (inlierMask.needed())
        Mat(int(result.inliers.size()), 1, CV_8U, const_cast<uchar*>(result.inliers.data())).copyTo(inlierMask);
    if (covariance.needed())
        writeMatrix(result.covariance, covariance);
    return result.inlierCount;
}

}} // namespace cv::active_handeye
