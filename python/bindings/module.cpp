// SPDX-FileCopyrightText: 2026 active_handeye contributors
// SPDX-License-Identifier: Apache-2.0

#include "bind.hpp"

using namespace active_handeye_python;

PYBIND11_MODULE(_core, m)
{
    m.doc() = "The C++ functions of cv::active_handeye: same names, same order of arguments and results.";
    m.attr("version") = ACTIVE_HANDEYE_VERSION;

    bindError(m);
    bindFoe(m);
    bindTranslations(m);
    bindRotation(m);
    bindLightPlane(m);
    bindStripe(m);
    bindRefine(m);
    bindHandEye(m);
    bindVerify(m);
    bindProfile(m);
    bindMeasure(m);
    bindPlanning(m);
}
