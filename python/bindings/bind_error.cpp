// SPDX-FileCopyrightText: 2026 active_handeye contributors
// SPDX-License-Identifier: Apache-2.0

#include <pybind11/gil_safe_call_once.h>
#include "bind.hpp"
#include "opencv2/core.hpp"

namespace active_handeye_python {

namespace py = pybind11;

namespace {

PYBIND11_CONSTINIT py::gil_safe_call_once_and_store<py::object> errorType;

const char* const errorDoc = R"doc(What the C++ functions refuse, and data that cannot answer.

The text names the argument, what was needed and what was given.

Attributes:
    code: OpenCV's error code. -5 (StsBadArg), -201 (StsBadSize), -211 (StsOutOfRange): wrong input;
        -7 (StsNoConv): the input is right, but the motion or the scene does not determine the answer.
    err: the text.
    func: the C++ function that refused.
    line: the line of its source.
)doc";

py::object makeErrorType()
{
    py::dict members;
    members["__doc__"] = errorDoc;
    members["__module__"] = "cv_active_handeye._core";
    members["code"] = 0;
    members["err"] = "";
    members["func"] = "";
    members["line"] = 0;
    const py::handle type(reinterpret_cast<PyObject*>(&PyType_Type));
    return type("error", py::make_tuple(py::handle(PyExc_Exception)), members);
}

void translate(std::exception_ptr thrown) // NOLINT(performance-unnecessary-value-param): what pybind11 calls
{
    try
    {
        if (thrown)
            std::rethrow_exception(thrown);
    }
    catch (const cv::Exception& e)
    {
        const py::object error = errorType.get_stored()(e.err);
        error.attr("code") = int(e.code); // an enum in OpenCV 5
        error.attr("err") = e.err;
        error.attr("func") = e.func;
        error.attr("line") = e.line;
        PyErr_SetObject(errorType.get_stored().ptr(), error.ptr());
    }
}

} // namespace

void bindError(py::module_& m)
{
    m.attr("error") = errorType.call_once_and_store_result(makeErrorType).get_stored();
    py::register_local_exception_translator(translate);
}

} // namespace active_handeye_python
