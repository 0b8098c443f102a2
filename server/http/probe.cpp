#include "server/http/probe.h"

#include <httplib.h>
#include <sys/socket.h>

#include <chrono>

#include "server/net/address.h"

namespace rivage::server {
namespace {

using core::ErrorCode;
using core::fail;

/// Shorter than what any caller gives a probe, so that our words are heard and not its time-out.
constexpr std::chrono::seconds kPatience{2};

httplib::Client makeClient(const Address& address) {
    httplib::Client client = address.isUnix() ? httplib::Client(address.path, 80)
                                              : httplib::Client(address.host, address.port);
    if (address.isUnix()) client.set_address_family(AF_UNIX);
    client.set_connection_timeout(kPatience);
    client.set_max_timeout(kPatience);
    return client;
}

}  // namespace

core::Result<void> probe(const std::string& adminListen, const std::string& question) {
    if (adminListen == "off")
        return fail(ErrorCode::invalidOption, "--admin-listen is off: there is nothing to ask");
    auto address = parseAddress(adminListen);
    if (!address) return fail(address.error());
    if (!address->isUnix() && address->port == 0)
        return fail(ErrorCode::invalidOption,
                    "--admin-listen has port 0: nobody knows which it is");
    // What listens everywhere is asked on the loopback.
    if (address->host.empty() || address->host == "0.0.0.0") address->host = "127.0.0.1";
    if (address->host == "::") address->host = "::1";

    const std::string path = question == "started" ? "/startupz" : "/" + question + "z";
    const auto answer = makeClient(*address).Get(path);
    if (!answer)
        return fail(ErrorCode::timedOut,
                    address->url() + path + ": " + httplib::to_string(answer.error()));
    if (answer->status == 200) return {};
    return fail(ErrorCode::internal, answer->body);
}

}  // namespace rivage::server
