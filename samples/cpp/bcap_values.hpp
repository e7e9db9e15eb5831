// SPDX-FileCopyrightText: 2026 active_handeye contributors
// SPDX-License-Identifier: Apache-2.0

// Values of b-CAP packets and their bytes, little endian; part of bcap.hpp.
#ifndef ACTIVE_HANDEYE_SAMPLES_BCAP_VALUES_HPP
#define ACTIVE_HANDEYE_SAMPLES_BCAP_VALUES_HPP

#include <cmath>
#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <string>
#include <variant>
#include <vector>

namespace bcap {

//! The connection is gone, silent or garbled, and cannot be used again.
struct LinkLost : std::runtime_error
{
    using std::runtime_error::runtime_error;
};

//! What a VARIANT holds; arrays of any type become a List. Text is ASCII.
struct Value;
using List = std::vector<Value>;
struct Value : std::variant<std::monostate, bool, int32_t, double, std::string, List>
{
    using variant::variant;
    Value(const char* text) : variant(std::string(text)) {}

    double number() const
    {
        if (const double* real = std::get_if<double>(this))
            return *real;
        if (const int32_t* integer = std::get_if<int32_t>(this))
            return *integer;
        if (const bool* truth = std::get_if<bool>(this))
            return *truth ? 1 : 0;
        throw LinkLost("the controller's answer is no number");
    }
    //! At least this many finite numbers.
    std::vector<double> numbers(size_t least) const
    {
        std::vector<double> out;
        if (const List* list = std::get_if<List>(this))
            for (const Value& value : *list)
                out.push_back(value.number());
        for (double value : out)
            if (!std::isfinite(value))
                throw LinkLost("the controller's answer is not finite");
        if (out.size() < least)
            throw LinkLost("the controller's answer has " + std::to_string(out.size()) + " numbers, needs " +
                           std::to_string(least));
        return out;
    }
};

namespace detail {

const uint32_t maxPacket = 16u << 20, maxValues = 1u << 20, executing = 0x900;
const int maxDepth = 8;

template <class T>
void put(std::string& out, T value)
{
    char bytes[sizeof value]; // the machine is taken to be little endian, as all that OpenCV's packages are built for
    std::memcpy(bytes, &value, sizeof value);
    out.append(bytes, sizeof value);
}

inline void putText(std::string& out, const std::string& text)
{
    put(out, uint32_t(2 * text.size()));
    for (char character : text)
        put(out, uint16_t(uint8_t(character)));
}

inline void putValue(std::string& out, const Value& value)
{
    const auto head = [&out](uint16_t type, size_t count) { put(out, type), put(out, uint32_t(count)); };
    if (const bool* truth = std::get_if<bool>(&value))
        head(11, 1), put(out, int16_t(*truth ? -1 : 0));
    else if (const int32_t* integer = std::get_if<int32_t>(&value))
        head(3, 1), put(out, *integer);
    else if (const double* real = std::get_if<double>(&value))
        head(5, 1), put(out, *real);
    else if (const std::string* text = std::get_if<std::string>(&value))
        head(8, 1), putText(out, *text);
    else if (const List* list = std::get_if<List>(&value))
    {
        bool isReal = !list->empty();
        for (const Value& element : *list)
            isReal = isReal && std::holds_alternative<double>(element);
        head(uint16_t(0x2000 | (isReal ? 5 : 12)), list->size());
        for (const Value& element : *list)
            if (isReal)
                put(out, std::get<double>(element));
            else
                putValue(out, element);
    }
    else
        head(0, 1);
}

//! Reads front to back, never beyond the end of the bytes.
class Reader
{
public:
    Reader(const std::string& bytes, size_t at, size_t end) : bytes_(bytes), at_(at), end_(end) {}
    size_t at() const { return at_; }

    template <class T>
    T get()
    {
        T value;
        std::memcpy(&value, take(sizeof value), sizeof value);
        return value;
    }

    Value value(int depth = 0)
    {
        if (depth > maxDepth)
            throw LinkLost("the answer is nested too deep");
        const uint16_t type = get<uint16_t>();
        const uint32_t count = get<uint32_t>();
        if (!(type & 0x2000))
            return single(type, depth);
        List list;
        for (uint32_t i = 0; i < count; ++i)
            list.push_back(single(type & ~0x2000, depth));
        return list;
    }

private:
    Value single(int type, int depth)
    {
        if (++values_ > maxValues)
            throw LinkLost("the answer holds too many values");
        switch (type)
        {
        case 0:
        case 1:
            return Value();
        case 2:
            return int32_t(get<int16_t>());
        case 3:
        case 10:
            return get<int32_t>();
        case 4:
            return double(get<float>());
        case 5:
        case 7:
            return get<double>();
        case 6:
        case 20:
            return double(get<int64_t>());
        case 8:
            return text();
        case 11:
            return get<int16_t>() != 0;
        case 12:
            return value(depth + 1);
        case 17:
            return int32_t(get<uint8_t>());
        case 18:
            return int32_t(get<uint16_t>());
        case 19:
            return double(get<uint32_t>());
        case 21:
            return double(get<uint64_t>());
        default:
            throw LinkLost("the answer has a value of the unknown type " + std::to_string(type));
        }
    }

    std::string text()
    {
        const uint32_t size = get<uint32_t>();
        const char* bytes = take(size);
        std::string out;
        for (uint32_t i = 0; i + 1 < size; i += 2)
            out += bytes[i + 1] == 0 && uint8_t(bytes[i]) < 128 ? bytes[i] : '?';
        return out;
    }

    const char* take(size_t size)
    {
        if (size > end_ - at_)
            throw LinkLost("the answer is shorter than it says");
        at_ += size;
        return bytes_.data() + at_ - size;
    }

    const std::string& bytes_;
    size_t at_, end_;
    uint32_t values_ = 0;
};

} // namespace detail

} // namespace bcap

#endif
