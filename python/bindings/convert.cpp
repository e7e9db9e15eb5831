// SPDX-FileCopyrightText: 2026 active_handeye contributors
// SPDX-License-Identifier: Apache-2.0

#include "convert.hpp"

#include <cstring>

namespace active_handeye_python {

namespace {

[[noreturn]] void refuse(const std::string& name, const std::string& needed, const std::string& given)
{
    CV_Error(cv::Error::StsBadArg, name + ": needed " + needed + ", given " + given);
}

std::string typeName(const py::object& values)
{
    return py::type::of(values).attr("__name__").cast<std::string>();
}

py::array asArray(const py::object& values, const std::string& name)
{
    if (py::isinstance<py::array>(values))
        return py::reinterpret_borrow<py::array>(values);
    try
    {
        return py::module_::import("numpy").attr("asarray")(values);
    }
    catch (const py::error_already_set& e)
    {
        if (!e.matches(PyExc_ValueError) && !e.matches(PyExc_TypeError))
            throw;
        const std::string reason = py::str(e.value());
        refuse(name, "an array of numbers", "a " + typeName(values) + " that has no one shape (numpy: " + reason + ")");
    }
}

py::array numbers(const py::object& values, const std::string& name)
{
    if (values.is_none())
        refuse(name, "an array of numbers", "None");
    const py::array array = asArray(values, name);
    const bool isNumeric = std::strchr("iuf", array.dtype().kind()) != nullptr;
    if (!isNumeric)
        refuse(name, "an array of real numbers", "elements of type " + std::string(py::str(array.dtype())));
    if (array.ndim() < 1 || array.ndim() > 3)
        refuse(name, "an array of 1 to 3 dimensions", std::to_string(array.ndim()) + " dimensions");
    return array;
}

std::vector<int> sizesOf(const py::array& array)
{
    std::vector<int> sizes(array.shape(), array.shape() + array.ndim());
    if (sizes.size() == 1)
        sizes.push_back(1);
    return sizes;
}

template <typename T>
Image imageOf(const py::array& values, const std::vector<int>& sizes)
{
    const auto contiguous = py::array_t<T, py::array::c_style>::ensure(values);
    const int type = CV_MAKETYPE(cv::traits::Depth<T>::value, sizes.size() == 3 ? sizes[2] : 1);
    return Image{contiguous, cv::Mat(sizes[0], sizes[1], type, const_cast<T*>(contiguous.data()))};
}

} // namespace

cv::Mat matrix(const py::object& values, const std::string& name)
{
    const auto doubles = py::array_t<double, py::array::c_style | py::array::forcecast>::ensure(numbers(values, name));
    const std::vector<int> sizes = sizesOf(doubles);
    cv::Mat mat(int(sizes.size()), sizes.data(), CV_64F);
    std::copy(doubles.data(), doubles.data() + doubles.size(), reinterpret_cast<double*>(mat.data));
    return mat;
}

cv::Mat optionalMatrix(const py::object& values, const std::string& name)
{
    return values.is_none() ? cv::Mat() : matrix(values, name);
}

std::vector<cv::Mat> matrices(const py::object& values, const std::string& name)
{
    const bool isText = py::isinstance<py::str>(values) || py::isinstance<py::bytes>(values);
    if (!PySequence_Check(values.ptr()) || isText)
        refuse(name, "a sequence of arrays", typeName(values));
    if (py::isinstance<py::array>(values) && py::array(values).ndim() < 2)
        refuse(name, "a sequence of arrays", "an array of " + std::to_string(py::array(values).ndim()) + " dimensions");
    std::vector<cv::Mat> list;
    const auto sequence = py::reinterpret_borrow<py::sequence>(values);
    list.reserve(sequence.size());
    for (size_t i = 0; i < sequence.size(); ++i)
        list.push_back(matrix(sequence[i], name + "[" + std::to_string(i) + "]"));
    return list;
}

Image image(const py::object& values, const std::string& name)
{
    if (values.is_none())
        return Image();
    const py::array pixels = numbers(values, name);
    const std::vector<int> sizes(pixels.shape(), pixels.shape() + pixels.ndim());
    if (sizes.size() < 2 || (sizes.size() == 3 && sizes[2] != 1 && sizes[2] != 3))
        refuse(name, "an image of shape (rows, columns) or (rows, columns, 3)",
               "shape " + std::string(py::str(pixels.attr("shape"))));
    if (py::isinstance<py::array_t<uchar>>(pixels))
        return imageOf<uchar>(pixels, sizes);
    if (py::isinstance<py::array_t<ushort>>(pixels))
        return imageOf<ushort>(pixels, sizes);
    refuse(name, "an image of type uint8 or uint16", "type " + std::string(py::str(pixels.dtype())));
}

} // namespace active_handeye_python
