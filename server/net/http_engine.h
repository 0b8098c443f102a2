#pragma once

#include <httplib.h>

#include <atomic>

#include "server/net/connection.h"

namespace rivage::server {

/// cpp-httplib without its sockets and threads: it parses, routes and writes; `Front` runs it.
class HttpEngine : public httplib::Server {
public:
    HttpEngine();

    /// Called with each answer just before its head is written.
    void onAnswer(Handler handler) { onAnswer_ = std::move(handler); }

    /// Answers the request whose head is at the start of the connection's input.
    /// @param stopping  whether the answer shall be the last of its connection
    void answer(Connection& connection, const NetLimits& limits, const std::atomic<bool>& stopping);

private:
    void settle(const httplib::Request& request, httplib::Response& response);

    Handler onAnswer_;
};

}  // namespace rivage::server
