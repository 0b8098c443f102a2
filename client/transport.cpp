#include "client/transport.h"

#include <sys/socket.h>

#include <algorithm>
#include <charconv>
#include <optional>
#include <utility>

namespace rivage::client {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds kConnectTimeout{5000};
/// Longer than the longest long poll, so that a server that says nothing is noticed.
constexpr milliseconds kSilence{60'000};
/// A problem or a job document; results go into a sink.
constexpr std::size_t kMaxDocument = std::size_t{64} << 20;

bool isBusy(int status) {
    return status == 408 || status == 429 || (status >= 502 && status <= 504);
}

bool couldNotConnect(httplib::Error error) {
    return error == httplib::Error::Connection || error == httplib::Error::ConnectionTimeout;
}

bool isUntrusted(httplib::Error error) {
    return error == httplib::Error::SSLServerVerification ||
           error == httplib::Error::SSLServerHostnameVerification ||
           error == httplib::Error::SSLLoadingCerts;
}

/// Seconds of a Retry-After header; 0 if there is none, or a date.
milliseconds retryAfter(const httplib::Response& response) {
    const std::string text = response.get_header_value("Retry-After");
    int seconds = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), seconds);
    const bool good = error == std::errc() && end == text.data() + text.size() && seconds > 0;
    return milliseconds(good ? std::int64_t{1000} * seconds : 0);
}

Failure timeIsOver() {
    return fail(ExitCode::busy, "The time is over", "the limit is set by --timeout").value();
}

/// Sends what comes to the sink if the answer is a success, else into `body`.
void receiveInto(httplib::Request& request, const BodySink* sink, int& status, std::string& body) {
    request.response_handler = [&status](const httplib::Response& response) {
        status = response.status;
        return true;
    };
    request.content_receiver = [&status, &body, sink](const char* data, std::size_t size,
                                                      std::size_t, std::size_t) {
        if (sink != nullptr && status == 200) return sink->write({data, size});
        if (body.size() + size > kMaxDocument) return false;
        body.append(data, size);
        return true;
    };
}

}  // namespace

httplib::Request makeRequest(std::string method, std::string path) {
    httplib::Request request;
    request.method = std::move(method);
    request.path = std::move(path);
    return request;
}

Transport::Transport(ServerAccess server, Interrupt& interrupt, RetryPolicy policy)
    : server_(std::move(server)),
      interrupt_(interrupt),
      policy_(policy),
      random_(std::random_device{}()) {}

httplib::Client Transport::makeClient() const {
    const Endpoint& endpoint = server_.endpoint;
    httplib::Client client =
        endpoint.tls ? httplib::Client(toText(endpoint))
                     : httplib::Client(endpoint.host, endpoint.isUnix() ? 80 : endpoint.port);
    if (endpoint.isUnix()) client.set_address_family(AF_UNIX);
    if (endpoint.tls && !server_.caFile.empty()) client.set_ca_cert_path(server_.caFile);
    if (!server_.apiKey.empty()) client.set_bearer_token_auth(server_.apiKey);
    client.set_connection_timeout(kConnectTimeout);
    client.set_read_timeout(kSilence);
    client.set_write_timeout(kSilence);
    return client;
}

Transport::Answer Transport::sendOnce(httplib::Request request, const BodySink* sink) {
    httplib::Client client = makeClient();
    if (deadline_ != Clock::time_point::max()) {
        const auto left = std::chrono::duration_cast<milliseconds>(deadline_ - Clock::now());
        client.set_max_timeout(std::max(left, milliseconds(0)) + milliseconds(1));
    }
    request.start_time_ = Clock::now();  // send() does not set what set_max_timeout counts from
    Answer answer;
    std::string body;
    int status = 0;
    receiveInto(request, sink, status, body);
    httplib::Result result = [&] {
        const BreakOff breakOff(interrupt_, [&client] { client.stop(); });
        return client.send(request);
    }();
    answer.error = result.error();
    if (!result) return answer;
    answer.response = *std::move(result);
    answer.response.body = std::move(body);
    return answer;
}

bool Transport::worthAnotherTry(const httplib::Request& request, const Answer& answer,
                                int tries) const {
    if (couldNotConnect(answer.error)) return tries < policy_.connectTries;
    if (answer.error == httplib::Error::Success) return isBusy(answer.response.status);
    const bool broken = answer.error == httplib::Error::Read ||
                        answer.error == httplib::Error::Write ||
                        answer.error == httplib::Error::ConnectionClosed;
    return broken && request.method != "POST" && tries < policy_.connectTries;
}

Failure Transport::failureOf(const Answer& answer) const {
    if (answer.error == httplib::Error::Success)
        return client::failureOf(answer.response.status, answer.response.body);
    if (answer.error == httplib::Error::Canceled)
        return fail(ExitCode::notWritten, "The result could not be kept").value();
    if (Clock::now() >= deadline_ || answer.error == httplib::Error::Timeout) return timeIsOver();
    if (isUntrusted(answer.error))
        return fail(ExitCode::unreachable, "The certificate of the server is not trusted",
                    toText(server_.endpoint) + ": " + httplib::to_string(answer.error) +
                        "; --ca-file names a PEM file of who signed it")
            .value();
    const bool absent = couldNotConnect(answer.error);
    return fail(ExitCode::unreachable,
                absent ? "No server answers" : "The connection to the server broke",
                toText(server_.endpoint) + ": " + httplib::to_string(answer.error))
        .value();
}

milliseconds Transport::delay(const Answer& answer, int tries) {
    const auto doubled = policy_.base.count() << std::min(tries, 16);
    const auto most = std::min<std::int64_t>(doubled, policy_.cap.count());
    std::uniform_int_distribution<std::int64_t> jitter(0, std::max<std::int64_t>(most, 1));
    return retryAfter(answer.response) + milliseconds(jitter(random_));
}

Outcome<httplib::Response> Transport::send(const httplib::Request& request, const BodySink* sink) {
    std::optional<Failure> refusal;  // why the server refused tells more than that time is over
    for (int tries = 1;; ++tries) {
        if (interrupt_.requested()) return fail(ExitCode::cancelled, "Cancelled");
        if (Clock::now() >= deadline_) return tl::unexpected(refusal.value_or(timeIsOver()));
        Answer answer = sendOnce(request, sink);
        if (interrupt_.requested()) return fail(ExitCode::cancelled, "Cancelled");
        if (answer.error == httplib::Error::Success && answer.response.status < 400)
            return std::move(answer.response);

        Failure failure = failureOf(answer);
        if (answer.error == httplib::Error::Success)
            refusal = failure;
        else if (refusal && Clock::now() >= deadline_)
            failure = *refusal;
        if (!worthAnotherTry(request, answer, tries)) return tl::unexpected(std::move(failure));
        const milliseconds pause = delay(answer, tries);
        if (pause >= deadline_ - Clock::now()) return tl::unexpected(std::move(failure));
        if (!interrupt_.sleep(pause)) return fail(ExitCode::cancelled, "Cancelled");
        if (sink != nullptr && !sink->restart())
            return fail(ExitCode::notWritten, "The result could not be kept");
    }
}

void Transport::sendAtLast(httplib::Request request, milliseconds patience) {
    httplib::Client client = makeClient();
    client.set_connection_timeout(patience);
    client.set_max_timeout(patience);
    request.start_time_ = Clock::now();
    const httplib::Result ignored = client.send(request);
    static_cast<void>(ignored);
}

}  // namespace rivage::client
