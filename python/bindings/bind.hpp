// SPDX-FileCopyrightText: 2026 active_handeye contributors
// SPDX-License-Identifier: Apache-2.0

// One function per header of the module, in the order of the flow; bind_<header>.cpp holds it.
#ifndef ACTIVE_HANDEYE_BINDINGS_BIND_HPP
#define ACTIVE_HANDEYE_BINDINGS_BIND_HPP

#include <pybind11/pybind11.h>

namespace active_handeye_python {

void bindError(pybind11::module_& m);
void bindFoe(pybind11::module_& m);
void bindTranslations(pybind11::module_& m);
void bindRotation(pybind11::module_& m);
void bindLightPlane(pybind11::module_& m);
void bindStripe(pybind11::module_& m);
void bindRefine(pybind11::module_& m);
void bindHandEye(pybind11::module_& m);
void bindVerify(pybind11::module_& m);
void bindProfile(pybind11::module_& m);
void bindMeasure(pybind11::module_& m);
void bindPlanning(pybind11::module_& m);

} // namespace active_handeye_python

#endif
