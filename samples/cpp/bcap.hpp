// SPDX-FileCopyrightText: 2026 active_handeye contributors
// SPDX-License-Identifier: Apache-2.0

// b-CAP over TCP for DENSO controllers (RC8, RC8A, RC9): one connection, one call at a time, every call within its deadline. C++17, POSIX.
// The same protocol as python/cv_active_handeye/robots/bcap.py, where it is described.
#ifndef ACTIVE_HANDEYE_SAMPLES_BCAP_HPP
#define ACTIVE_HANDEYE_SAMPLES_BCAP_HPP

#include "bcap_values.hpp"

#include <netdb.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <stdexcept>
#include <string>

namespace bcap {

enum Function : uint32_t
{
    SERVICE_START = 1,
    SERVICE_STOP = 2,
    CONTROLLER_CONNECT = 3,
    CONTROLLER_DISCONNECT = 4,
    CONTROLLER_GET_ROBOT = 7,
    CONTROLLER_GET_VARIABLE = 9,
    ROBOT_GET_VARIABLE = 62,
    ROBOT_EXECUTE = 64,
    ROBOT_HALT = 70,
    ROBOT_MOVE = 72,
    ROBOT_RELEASE = 84,
    VARIABLE_GET_VALUE = 101,
    VARIABLE_RELEASE = 111
};

//! The controller refused a call; code is its HRESULT.
struct Refused : std::runtime_error
{
    Refused(uint32_t hresult, const std::string& what) : std::runtime_error(what), code(hresult) {}
    uint32_t code;
};

//! One connection. A call that is under way (begin, then poll) keeps it busy.
class Client
{
public:
    using Clock = std::chrono::steady_clock;

    //! Connects and starts the service, which sends a keep-alive every 200 ms during a long call.
    Client(const std::string& host, int port)
    {
        addrinfo hints = addrinfo(), *found = nullptr;
        hints.ai_family = AF_INET;
        hints.ai_socktype = SOCK_STREAM;
        if (getaddrinfo(host.c_str(), std::to_string(port).c_str(), &hints, &found) != 0)
            throw LinkLost(host + ": unknown address");
        socket_ = ::socket(AF_INET, SOCK_STREAM, 0);
        const timeval limit = {2, 0}; // of connecting and sending
        setsockopt(socket_, SOL_SOCKET, SO_SNDTIMEO, &limit, sizeof limit);
        const int on = 1;
        setsockopt(socket_, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
        const bool isConnected = ::connect(socket_, found->ai_addr, found->ai_addrlen) == 0;
        freeaddrinfo(found);
        try
        {
            if (!isConnected)
                fail(host + ": cannot be reached: " + std::strerror(errno));
            call(SERVICE_START, {",WDT=200,InvokeTimeout=180000"});
        }
        catch (...)
        {
            ::close(socket_);
            throw;
        }
    }
    Client(const Client&) = delete;
    Client& operator=(const Client&) = delete;

    ~Client()
    {
        try
        {
            if (!isLost_ && !isBusy_)
                call(SERVICE_STOP, {}, 0.5);
        }
        catch (const std::exception&)
        {}
        ::close(socket_);
    }

    //! The controller's answer; Refused, or LinkLost where none comes within `seconds`.
    Value call(Function function, const List& arguments, double seconds = 2.0)
    {
        begin(function, arguments);
        Value answer;
        if (!poll(seconds, answer))
            fail("no answer to function " + std::to_string(function) + " in time");
        return answer;
    }

    //! Sends a request; `poll` for its answer.
    void begin(Function function, const List& arguments)
    {
        if (isLost_ || isBusy_)
            throw LinkLost(isLost_ ? "the connection was lost" : "another call is under way");
        serial_ = uint16_t(serial_ % 65535 + 1);
        std::string body;
        for (const Value& argument : arguments)
        {
            std::string bytes;
            detail::putValue(bytes, argument);
            detail::put(body, uint32_t(bytes.size()));
            body += bytes;
        }
        std::string packet(1, '\x01');
        detail::put(packet, uint32_t(16 + body.size()));
        detail::put(packet, serial_);
        detail::put(packet, uint16_t(0));
        detail::put(packet, uint32_t(function));
        detail::put(packet, uint16_t(arguments.size()));
        packet += body + '\x04';
        if (::send(socket_, packet.data(), packet.size(), MSG_NOSIGNAL) != ssize_t(packet.size()))
            fail(std::string("cannot send: ") + std::strerror(errno));
        isBusy_ = true;
        heard_ = Clock::now();
    }

    //! Whether the answer came within `seconds`; Refused, or LinkLost after a second of silence.
    bool poll(double seconds, Value& answer)
    {
        const auto end = Clock::now() + std::chrono::duration<double>(seconds);
        for (;;)
        {
            std::string packet;
            while (takePacket(packet))
                if (accept(packet, answer))
                    return true;
            const double left = std::chrono::duration<double>(end - Clock::now()).count();
            if (!receive(std::max(0.0, std::min(left, 0.1))))
            {
                if (Clock::now() - heard_ > std::chrono::seconds(1))
                    fail("the controller is silent");
                if (left <= 0)
                    return false;
            }
        }
    }

private:
    [[noreturn]] void fail(const std::string& why)
    {
        isLost_ = true;
        throw LinkLost(why);
    }

    bool receive(double seconds)
    {
        pollfd ready = {socket_, POLLIN, 0};
        if (::poll(&ready, 1, int(1000 * seconds)) <= 0)
            return false;
        char bytes[65536];
        const ssize_t size = ::recv(socket_, bytes, sizeof bytes, 0);
        if (size <= 0)
            fail("the controller closed the connection");
        buffer_.append(bytes, size_t(size));
        return true;
    }

    bool takePacket(std::string& packet)
    {
        if (buffer_.size() < 5)
            return false;
        uint32_t size;
        std::memcpy(&size, buffer_.data() + 1, sizeof size);
        if (buffer_[0] != 1 || size < 16 || size > detail::maxPacket)
            fail("the answer is no b-CAP packet");
        if (buffer_.size() < size)
            return false;
        packet = buffer_.substr(0, size);
        buffer_.erase(0, size);
        if (packet.back() != 4)
            fail("the answer is no b-CAP packet");
        return true;
    }

    //! Whether this is the answer, and not a keep-alive or the answer to an earlier call.
    bool accept(const std::string& packet, Value& answer)
    {
        detail::Reader reader(packet, 5, packet.size() - 1);
        const bool isOurs = reader.get<uint16_t>() == serial_;
        reader.get<uint16_t>();
        const uint32_t code = reader.get<uint32_t>();
        if (!isOurs)
            return false;
        heard_ = Clock::now();
        if (code == detail::executing)
            return false;
        isBusy_ = false;
        if (code & 0x80000000u)
        {
            char text[32];
            std::snprintf(text, sizeof text, "refused with %08X", unsigned(code));
            throw Refused(code, text);
        }
        answer = Value();
        if (reader.get<uint16_t>() > 0)
        {
            reader.get<uint32_t>();
            answer = reader.value();
        }
        return true;
    }

    int socket_ = -1;
    uint16_t serial_ = 0;
    bool isBusy_ = false, isLost_ = false;
    std::string buffer_;
    Clock::time_point heard_;
};

} // namespace bcap

#endif
