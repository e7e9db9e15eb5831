// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "numbers.hpp"

namespace cv { namespace active_handeye {

static std::string shapeOf(const Mat& m)
{
    std::string shape;
    for (int d = 0; d < m.dims; ++d)
        shape += (d ? " x " : "") + std::to_string(m.size[d]);
    return m.channels() > 1 ? shape + " of " + std::to_string(m.channels()) + " channels" : shape;
}

Numbers numbersOf(const Mat& m)
{
    Mat doubles;
    m.convertTo(doubles, CV_64F);
    Numbers numbers;
    numbers.shape = shapeOf(m);
    numbers.rowLength = m.channels() > 1 || m.dims < 2 ? m.channels() : m.size[m.dims - 1];
    if (!doubles.empty())
        numbers.values.assign(doubles.ptr<double>(), doubles.ptr<double>() + doubles.total() * doubles.channels());
    return numbers;
}

double median(std::vector<double> values)
{
    std::nth_element(values.begin(), values.begin() + values.size() / 2, values.end());
    return values[values.size() / 2];
}

static bool isListOfMats(const _InputArray& a)
{
    return a.isMatVector() || a.isUMatVector() || a.kind() == _InputArray::STD_VECTOR_VECTOR;
}

//! Splits one array along its first dimension (a vector of points along its only one).
static std::vector<Numbers> slicesOf(const Mat& m)
{
    std::vector<Numbers> slices;
    if (m.empty())
        return slices;
    const Numbers all = numbersOf(m);
    const bool vectorOfPoints = m.dims <= 2 && m.channels() > 1 && (m.size[0] == 1 || m.dims == 1);
    const size_t count = vectorOfPoints ? m.total() : size_t(m.size[0]), length = all.values.size() / count;
    for (size_t i = 0; i < count; ++i)
    {
        Numbers slice;
        slice.values.assign(all.values.begin() + i * length, all.values.begin() + (i + 1) * length);
        slice.shape = all.shape + cv::format(" / %d", int(count));
        slice.rowLength = all.rowLength;
        slices.push_back(slice);
    }
    return slices;
}

std::vector<Numbers> readList(const _InputArray& a)
{
    if (!isListOfMats(a))
        return slicesOf(a.getMat());
    std::vector<Numbers> list;
    list.reserve(a.total());
    for (int i = 0; i < int(a.total()); ++i)
        list.push_back(numbersOf(a.getMat(i)));
    return list;
}

}} // namespace cv::active_handeye
