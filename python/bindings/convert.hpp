// SPDX-FileCopyrightText: 2026 active_handeye contributors
// SPDX-License-Identifier: Apache-2.0

// Between numpy and OpenCV, always by copy: no layout, life time or later change of an array reaches the other side.
// What cannot be read as numbers is refused here with the argument's name; what the numbers mean is checked in C++.
#ifndef ACTIVE_HANDEYE_BINDINGS_CONVERT_HPP
#define ACTIVE_HANDEYE_BINDINGS_CONVERT_HPP

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/typing.h>
#include <vector>
#include "opencv2/active_handeye.hpp"

namespace active_handeye_python {

namespace py = pybind11;

inline bool isAnything(PyObject*)
{
    return true;
}

//! Whatever numpy makes an array of.
class ArrayLike : public py::object
{
public:
    PYBIND11_OBJECT_DEFAULT(ArrayLike, py::object, isAnything) // NOLINT(misc-explicit-constructor): pybind11's
};

//! The same, or None for "not given".
class OptionalArrayLike : public py::object
{
public:
    PYBIND11_OBJECT_DEFAULT(OptionalArrayLike, py::object, isAnything) // NOLINT(misc-explicit-constructor): pybind11's
};

//! Doubles of the same shape; a vector of n becomes n x 1.
cv::Mat matrix(const py::object& values, const std::string& name);

//! As matrix(); None becomes an empty Mat.
cv::Mat optionalMatrix(const py::object& values, const std::string& name);

//! One Mat per element of a sequence, or per slice of an array along its first axis.
std::vector<cv::Mat> matrices(const py::object& values, const std::string& name);

//! The caller's pixels, not a copy of them: images are large. As in OpenCV, nobody may write to them during the call.
struct Image
{
    py::object owner;
    cv::Mat pixels;
};

//! 8 or 16 bit grey or colour image, its element type kept; None becomes an empty one.
Image image(const py::object& values, const std::string& name);

//! Copy of a Mat of element type T; a vector of n stays (n, 1), as in cv2.
template <typename T>
py::array_t<T> array(const cv::Mat& mat)
{
    CV_Assert(mat.empty() || (mat.type() == cv::traits::Type<T>::value && mat.dims == 2 && mat.isContinuous()));
    return py::array_t<T>({mat.rows, mat.cols}, reinterpret_cast<const T*>(mat.data));
}

//! Copy of a Mat of N x n x n doubles.
inline py::array_t<double> matrixArray(const cv::Mat& blocks)
{
    CV_Assert(blocks.dims == 3 && blocks.type() == CV_64F && blocks.isContinuous());
    return py::array_t<double>({blocks.size[0], blocks.size[1], blocks.size[2]},
                               reinterpret_cast<const double*>(blocks.data));
}

//! Runs the C++ part of a call while other Python threads go on.
template <typename Call>
auto unlocked(const Call& call)
{
    const py::gil_scoped_release release;
    return call();
}

} // namespace active_handeye_python

template <>
struct pybind11::detail::handle_type_name<active_handeye_python::ArrayLike>
{
    static constexpr auto name = const_name("numpy.typing.ArrayLike");
};

template <>
struct pybind11::detail::handle_type_name<active_handeye_python::OptionalArrayLike>
{
    static constexpr auto name = const_name("numpy.typing.ArrayLike | None");
};

#endif
