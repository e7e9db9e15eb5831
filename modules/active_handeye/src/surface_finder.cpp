// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "surface_finder.hpp"

namespace cv { namespace active_handeye {

static void removeLines(std::vector<int>& from, const std::vector<int>& lines)
{
    const auto isAmong = [&](int line) { return std::find(lines.begin(), lines.end(), line) != lines.end(); };
    from.erase(std::remove_if(from.begin(), from.end(), isAmong), from.end());
}

//! Set of coplanar lines among the candidates that agree best, seeded by pairs of different views.
ScenePlane SurfaceFinder::largest(const std::vector<int>& candidates, const Demand& demand) const
{
    ScenePlane best;
    double most = 0;
    const size_t pairs = candidates.size() * (candidates.size() - 1) / 2, mostPairs = 20000,
                 stride = 1 + pairs / mostPairs;
    size_t pair = 0;
    const double leastPlanarity = 0.01;
    for (size_t i = 0; i < candidates.size(); ++i)
        for (size_t j = i + 1; j < candidates.size(); ++j)
        {
            if (pair++ % stride || lines_[candidates[i]].view.view == lines_[candidates[j]].view.view)
                continue;
            ScenePlane seed = lines_.fit({candidates[i], candidates[j]});
            if (seed.planarity < leastPlanarity || !lines_.fits(seed.plane, candidates[i], demand.support) ||
                !lines_.fits(seed.plane, candidates[j], demand.support))
                continue;
            seed.lines = lines_.linesOn(seed.plane, candidates, demand.support);
            const double found = lines_.views(seed.lines) < demand.views ? 0 : lines_.agreement(seed.plane, seed.lines);
            if (found > most)
                most = found, best = seed;
        }
    for (int pass = 0; pass < 3 && !best.lines.empty(); ++pass)
    {
        best = lines_.fit(best.lines);
        best.lines = lines_.linesOn(best.plane, candidates, demand.support);
    }
    return best;
}

ScenePlanes SurfaceFinder::find(std::vector<int> open, const Demand& demand) const
{
    ScenePlanes found;
    while (lines_.views(open) >= demand.views)
    {
        const ScenePlane surface = largest(open, demand);
        if (lines_.views(surface.lines) < demand.views)
            break;
        found.push_back(surface);
        removeLines(open, surface.lines);
    }
    dropAmbiguousLines(found);
    dropThinSurfaces(found, demand);
    dropIsolatedLines(found);
    dropThinSurfaces(found, demand);
    return found;
}

void SurfaceFinder::dropThinSurfaces(ScenePlanes& surfaces, const Demand& demand) const
{
    const auto isThin = [&](const ScenePlane& surface) { return lines_.views(surface.lines) < demand.views; };
    surfaces.erase(std::remove_if(surfaces.begin(), surfaces.end(), isThin), surfaces.end());
}

//! A line that fits a second surface about as well could be on either; one that fits another better belongs there.
void SurfaceFinder::dropAmbiguousLines(ScenePlanes& surfaces) const
{
    for (ScenePlane& surface : surfaces)
    {
        const auto fitsAnother = [&](int line)
        {
            for (const ScenePlane& other : surfaces)
                if (&other != &surface && lines_.fits(other.plane, line) &&
                    lines_.error(other.plane, line) <= lines_.error(surface.plane, line) + clearly())
                    return true;
            return false;
        };
        surface.lines.erase(std::remove_if(surface.lines.begin(), surface.lines.end(), fitsAnother),
                            surface.lines.end());
    }
}

std::vector<int> SurfaceFinder::openLines() const
{
    std::vector<int> open;
    for (int line = 0; line < lines_.count(); ++line)
        if (lines_[line].inFront)
            open.push_back(line);
    for (const ScenePlane& surface : surfaces_)
        removeLines(open, surface.lines);
    return open;
}

void SurfaceFinder::findInGroups(int groups)
{
    const std::vector<int> open = openLines();
    for (int group = 0; group < groups; ++group)
    {
        std::vector<int> own;
        for (int line : open)
            if (lines_[line].group == group)
                own.push_back(line);
        const ScenePlanes found = find(own, Demand{3, UNDECIDED});
        surfaces_.insert(surfaces_.end(), found.begin(), found.end());
    }
}

void SurfaceFinder::mergeAcrossGroups()
{
    const double looser = 2; // errors of the calibration shift one group against another
    const auto areOn = [&](const ScenePlane& surface, const std::vector<int>& lines)
    {
        return std::all_of(lines.begin(), lines.end(),
                           [&](int line) { return lines_.error(surface.plane, line) <= looser * lines_.tolerance; });
    };
    for (size_t i = 0; i < surfaces_.size(); ++i)
        for (size_t j = i + 1; j < surfaces_.size();)
        {
            ScenePlane &a = surfaces_[i], &b = surfaces_[j];
            if (lines_[a.lines[0]].group == lines_[b.lines[0]].group || !areOn(a, b.lines) || !areOn(b, a.lines))
            {
                ++j;
                continue;
            }
            a.lines.insert(a.lines.end(), b.lines.begin(), b.lines.end());
            surfaces_.erase(surfaces_.begin() + j);
        }
}

//! Lines far from the others of their surface: coplanar they may be, but on a plane that their own errors turn towards them.
void SurfaceFinder::dropIsolatedLines(ScenePlanes& surfaces) const
{
    for (ScenePlane& surface : surfaces)
    {
        const std::vector<int> all = surface.lines;
        for (int line : all)
        {
            std::vector<int> others = surface.lines;
            removeLines(others, {line});
            if (lines_.isIsolated(line, others))
                surface.lines = others;
        }
    }
}

//! Open lines that fit one of the surfaces clearly better than the others join it.
void SurfaceFinder::join()
{
    for (ScenePlane& surface : surfaces_)
        surface = lines_.fit(surface.lines);
    for (int line : openLines())
    {
        ScenePlane* best = 0;
        double least = std::numeric_limits<double>::infinity(), second = least;
        for (ScenePlane& surface : surfaces_)
        {
            if (!lines_.fits(surface.plane, line) || lines_.isIsolated(line, surface.lines))
                continue;
            const double own = lines_.error(surface.plane, line);
            second = std::min(second, std::max(own, least));
            if (own < least)
                least = own, best = &surface;
        }
        if (best && second > least + clearly())
            best->lines.push_back(line);
    }
}

//! Surfaces of the lines that fit none of those found before.
void SurfaceFinder::findAcrossGroups()
{
    for (const Demand& demand : {Demand{3, UNDECIDED}, Demand{2, CONFIRMED}})
    {
        std::vector<int> open = openLines();
        for (const ScenePlane& surface : surfaces_)
            removeLines(open, lines_.linesOn(surface.plane, open, CONTRADICTED));
        const ScenePlanes found = find(open, demand);
        surfaces_.insert(surfaces_.end(), found.begin(), found.end());
    }
}

void SurfaceFinder::findSurfaces(int groups)
{
    surfaces_.clear();
    findInGroups(groups);
    mergeAcrossGroups();
    join();
    findAcrossGroups();
    join();
}

//! Some times what half of the lines miss their surface by; not more than before.
void SurfaceFinder::tightenTolerance()
{
    const double times = 8, least = 0.3; // px
    std::vector<double> errors;
    for (const ScenePlane& surface : surfaces_)
        for (int line : surface.lines)
            errors.push_back(lines_.error(surface.plane, line));
    if (errors.empty())
        return;
    std::nth_element(errors.begin(), errors.begin() + errors.size() / 2, errors.end());
    lines_.tolerance = std::min(lines_.tolerance, std::max(least, times * errors[errors.size() / 2]));
}

std::vector<int> SurfaceFinder::run(int groups)
{
    findSurfaces(groups);
    tightenTolerance();
    findSurfaces(groups);
    std::stable_sort(surfaces_.begin(), surfaces_.end(),
                     [](const ScenePlane& a, const ScenePlane& b) { return a.lines.size() > b.lines.size(); });
    std::vector<int> ids(lines_.count(), -1);
    for (size_t s = 0; s < surfaces_.size(); ++s)
        for (int line : surfaces_[s].lines)
            ids[line] = int(s);
    return ids;
}

}} // namespace cv::active_handeye
