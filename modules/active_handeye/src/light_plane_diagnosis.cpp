// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "light_plane_diagnosis.hpp"
#include "decompositions.hpp"

namespace cv { namespace active_handeye {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

std::string inBase(const Vector3d& direction, int group, const GroupOrientations& cam2base)
{
    Vector3d v = cam2base[group] * direction.normalized();
    for (int i = 0; i < 3; ++i)
        v[i] = std::round(100 * v[i]) / 100 + 0.; // + 0: no "-0.00"
    return cv::format("(%.2f, %.2f, %.2f) in base coordinates", v.x(), v.y(), v.z());
}

//! An axis has no sign: its largest component is made positive in base coordinates.
std::string axisInBase(const Vector3d& axis, int group, const GroupOrientations& cam2base)
{
    const Vector3d v = cam2base[group] * axis;
    int largest = 0;
    v.cwiseAbs().maxCoeff(&largest);
    return inBase(v[largest] < 0 ? Vector3d(-axis) : axis, group, cam2base);
}

//! How the lines of a surface move [px] and which way the camera went.
struct Movement
{
    double pixels = 0;      //!< largest distance of a line to the first one
    double largest = 0;     //!< longest displacement of the camera
    double outOfPlane = 0;  //!< its largest part across the first interpretation plane
    Eigen::Vector2d across; //!< singular values of the displacements across r, smaller one first
    Vector3d missing;       //!< direction across r with the least displacement

    Movement(const StripeSurface& surface, const Vector3d& r) : across(0, 0), missing(r.unitOrthogonal())
    {
        const StripeView& first = surface.views[0];
        const Vector3d m = interpretationNormal(first);
        Eigen::Matrix<double, 3, 2> basis = tangentBasis(r);
        Eigen::Matrix2d scatter = Eigen::Matrix2d::Zero();
        for (const StripeView& view : surface.views)
        {
            for (int end = 0; end < 2; ++end)
                pixels = std::max(pixels, std::abs(first.line.distance(view.line.end(end))));
            largest = std::max(largest, view.displacement.norm());
            outOfPlane = std::max(outOfPlane, std::abs(m.dot(view.displacement)));
            const Eigen::Vector2d c = basis.transpose() * view.displacement;
            scatter += c * c.transpose();
        }
        const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen = symmetricEigen(scatter);
        across = eigen.eigenvalues().cwiseMax(0.).cwiseSqrt();
        missing = basis * eigen.eigenvectors().col(0);
    }

    bool standsStill() const { return pixels < 0.5; }
    bool isAlongStripe() const { return outOfPlane < 0.02 * largest; }
    bool hasOneDirectionAcross() const { return across(0) < 0.03 * across(1); }
};

bool shareOneDirection(const std::vector<VanishingDirection>& directions)
{
    const double different = 0.05; // rad
    for (const VanishingDirection& direction : directions)
        if (direction.determined && direction.r.cross(directions[0].r).norm() > different)
            return false;
    return true;
}

} // namespace

std::string explainWeakness(const StripeSurfaces& surfaces, const std::vector<VanishingDirection>& directions,
                            const GroupOrientations& cam2base, const LightPlane* light)
{
    bool still = true, along = true, oneAcross = true, parallel = light != 0;
    for (size_t s = 0; s < surfaces.size(); ++s)
    {
        const Movement movement(surfaces[s], directions[s].r);
        still = still && movement.standsStill();
        along = along && movement.isAlongStripe();
        oneAcross = oneAcross && movement.hasOneDirectionAcross();
        const Vector3d w = surfaces[s].plane.head<3>();
        parallel = parallel && w.cross(light->n).norm() < 0.05 * w.norm();
    }
    const Vector3d r = directions[0].r, optical = Vector3d::UnitZ();
    const int group = surfaces[0].group;
    if (still && along)
        return "t_gripper2base: the camera was moved along the stripe only; needed translations across it, in two directions, e.g. "
               "along " +
               inBase(optical, group, cam2base) + " and along " +
               axisInBase(interpretationNormal(surfaces[0].views[0]), group, cam2base);
    if (still)
        return "stripePoints: the stripes stand still in the image while the camera moves, so it moved along the surfaces only, or they "
               "are parallel to the light plane; needed translations towards the surfaces, e.g. along " +
               inBase(optical, group, cam2base);
    if (oneAcross)
        return "t_gripper2base: the translations have one direction only across the stripe; needed a second one, e.g. along " +
               axisInBase(Movement(surfaces[0], r).missing, group, cam2base);
    if (parallel)
        return "stripePoints: the surfaces are nearly parallel to the light plane; needed a surface at a larger angle to it";
    if (shareOneDirection(directions))
        return "stripePoints: all groups share the stripe direction " + axisInBase(r, group, cam2base) +
               "; needed a second one: turn the gripper about an axis across the stripe, e.g. about " +
               axisInBase(optical.cross(r), group, cam2base) + ", or use a surface that is tilted about it";
    return "stripePoints: the motion of the stripes is too small for the light plane; needed larger translations or more views";
}

std::string describeContradiction(const StripeView& view, int surfaceId, double error)
{
    return cv::format("stripePoints[%d] (view %d, surface %d) by %.1f px", view.segment, view.view, surfaceId, error);
}

}} // namespace cv::active_handeye
