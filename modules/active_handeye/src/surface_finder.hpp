// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_ACTIVE_HANDEYE_SURFACE_FINDER_HPP
#define OPENCV_ACTIVE_HANDEYE_SURFACE_FINDER_HPP

#include "coplanar_lines.hpp"

namespace cv { namespace active_handeye {

/** Finds the planes that segments of different views share, for a known light plane and known poses.

A segment fits a plane when the stripe predicted is within the tolerance of both of its ends, and most of the scene
points beside it are near the plane: a line alone lies on many planes. First come planes inside a group of equal
orientation, with three views or more, where errors of the hand-eye transform matter least. The same plane found in
two groups is one; other segments join the planes that they fit. Last come planes across groups: of three views, or
of two where scene points confirm every segment. A second round has the tolerance that the first shows to be needed.
Segments that fit two planes alike, or lie far from all others of theirs, are left out.
*/
class SurfaceFinder
{
public:
    explicit SurfaceFinder(const CoplanarLines& lines) : lines_(lines) {}

    //! The surface of every line, the one with most lines first; -1 = not sure.
    std::vector<int> run(int groups);

private:
    //! What it takes to be a surface.
    struct Demand
    {
        size_t views;
        Support support;
    };

    ScenePlane largest(const std::vector<int>& candidates, const Demand& demand) const;
    ScenePlanes find(std::vector<int> open, const Demand& demand) const;
    void dropThinSurfaces(ScenePlanes& surfaces, const Demand& demand) const;
    void dropAmbiguousLines(ScenePlanes& surfaces) const;
    void dropIsolatedLines(ScenePlanes& surfaces) const;
    std::vector<int> openLines() const;
    void findInGroups(int groups);
    void mergeAcrossGroups();
    void join();
    void findAcrossGroups();
    void findSurfaces(int groups);
    void tightenTolerance();
    double clearly() const { return lines_.tolerance / 3; } //!< by how much the better one of two surfaces fits better

    CoplanarLines lines_;
    ScenePlanes surfaces_;
};

}} // namespace cv::active_handeye

#endif
