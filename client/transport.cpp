#include "client/transport.h"

#include <sys/socket.h>

#include <algorithm>
#include <condition_variable>
#include <mutex>
#include <thread>
#include <utility>

namespace rivage::client {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds kConnectTimeout{5000};
/// A problem or a job document; results go into a sink.
constexpr std::size_t kMaxDocument = std::size_t{64} << 20;
constexpr const char* kInProgress = "/problems/idempotency-in-progress";

bool couldNotConnect(httplib::Error error) {
    return error == httplib::Error::Connection || error == httplib::Error::ConnectionTimeout;
}

bool isBroken(httplib::Error error) {
    switch (error) {
        case httplib::Error::Read:
        case httplib::Error::Write:
        case httplib::Error::ConnectionClosed:
        case httplib::Error::Timeout:
        case httplib::Error::SSLPeerCouldBeClosed_: return true;
        default: return false;
    }
}

bool isUntrusted(httplib::Error error) {
    return error == httplib::Error::SSLServerVerification ||
           error == httplib::Error::SSLServerHostnameVerification ||
           error == httplib::Error::SSLLoadingCerts;
}

bool isDone(const httplib::Response& response) { return response.status < 300; }

/// Whether a request may be sent again although the server may have acted on it.
bool isRepeatable(const httplib::Request& request) {
    return request.method != "POST" || request.has_header("Idempotency-Key");
}

/// Answers that say "later". With an Idempotency-Key that includes the one to its own first try,
/// which the server still works on.
bool isBusy(const httplib::Request& request, const httplib::Response& response) {
    const int status = response.status;
    if (status == 408 || status == 429 || (status >= 502 && status <= 504)) return true;
    return status == 409 && request.has_header("Idempotency-Key") &&
           response.body.find(kInProgress) != std::string::npos;
}

Failure timeIsOver() {
    return failureWith(ExitCode::busy, "The time is over", "the limit is set by --timeout");
}

Failure notKept() { return failureWith(ExitCode::notWritten, "The result could not be kept"); }

/// A redirection is not followed: where an upload and a key go is for the user to say.
Failure redirected(const httplib::Response& response) {
    const std::string place = response.get_header_value("Location");
    return failureWith(ExitCode::failed, "The server sends its clients elsewhere",
                       (place.empty() ? "it does not say where" : "to " + place) + " (status " +
                           std::to_string(response.status) +
                           "); rivage does not follow, but --server can name that address");
}

/// Where the body of one answer goes, and why it was given up.
struct Reception {
    BodySink* sink = nullptr;
    Clock::time_point deadline;
    std::string body = {};
    bool toSink = false;
    bool late = false;
    bool tooLarge = false;
};

/// Sends what comes to the sink if the answer is a success, else into `body`.
void receiveInto(httplib::Request& request, Reception& reception) {
    request.response_handler = [&reception](const httplib::Response& response) {
        BodySink* const sink = reception.sink;
        reception.toSink = sink != nullptr && (response.status == 200 || response.status == 206);
        return !reception.toSink || sink->begin(response);
    };
    request.content_receiver = [&reception](const char* data, std::size_t size, std::size_t,
                                            std::size_t) {
        reception.late = Clock::now() >= reception.deadline;
        if (reception.late) return false;
        if (reception.toSink) return reception.sink->write({data, size});
        reception.tooLarge = reception.body.size() + size > kMaxDocument;
        if (reception.tooLarge) return false;
        reception.body.append(data, size);
        return true;
    };
}

/// Breaks off a request when its time is over: the time limits of the HTTP library do not hold
/// while an upload is not read, nor while bytes keep coming.
class TimeKeeper {
public:
    TimeKeeper(httplib::Client& client, Clock::time_point deadline) {
        if (deadline == Clock::time_point::max()) return;
        thread_ = std::thread([this, &client, deadline] { keep(client, deadline); });
    }
    ~TimeKeeper() {
        if (!thread_.joinable()) return;
        {
            const std::lock_guard lock(mutex_);
            over_ = true;
        }
        changed_.notify_all();
        thread_.join();
    }
    TimeKeeper(const TimeKeeper&) = delete;
    TimeKeeper& operator=(const TimeKeeper&) = delete;

private:
    void keep(httplib::Client& client, Clock::time_point deadline) {
        constexpr milliseconds kAgain{20};  // the first may come before there is a connection
        std::unique_lock lock(mutex_);
        for (auto next = deadline; !changed_.wait_until(lock, next, [&] { return over_; });
             next = Clock::now() + kAgain)
            client.stop();
    }

    std::mutex mutex_;
    std::condition_variable changed_;
    bool over_ = false;
    std::thread thread_;
};

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
    client.set_read_timeout(policy_.silence);
    client.set_write_timeout(policy_.silence);
    return client;
}

Transport::Answer Transport::sendOnce(httplib::Request request, BodySink* sink) {
    httplib::Client client = makeClient();
    if (deadline_ != Clock::time_point::max()) {
        const auto left = std::chrono::duration_cast<milliseconds>(deadline_ - Clock::now());
        const milliseconds most = std::max(left, milliseconds(0)) + milliseconds(1);
        client.set_max_timeout(most);
        client.set_connection_timeout(std::min(most, kConnectTimeout));
    }
    request.start_time_ = Clock::now();  // send() does not set what set_max_timeout counts from
    Answer answer;
    Reception reception{.sink = sink, .deadline = deadline_};
    if (sink != nullptr) sink->prepare(request);
    receiveInto(request, reception);
    httplib::Result result = [&] {
        const TimeKeeper timeKeeper(client, deadline_);
        const BreakOff breakOff(interrupt_, [&client] { client.stop(); });
        return client.send(request);
    }();
    answer.error = reception.late       ? httplib::Error::Timeout
                   : reception.tooLarge ? httplib::Error::ExceedMaxPayloadSize
                                        : result.error();
    if (!result) return answer;
    answer.response = *std::move(result);
    answer.response.body = std::move(reception.body);
    return answer;
}

Failure Transport::failureOf(const Answer& answer) const {
    if (answer.error == httplib::Error::Success && answer.response.status < 400)
        return redirected(answer.response);
    if (answer.error == httplib::Error::Success)
        return client::failureOf(answer.response.status, answer.response.body);
    if (answer.error == httplib::Error::ExceedMaxPayloadSize)
        return failureWith(ExitCode::failed, "The server's answer is not understood",
                           "a document of more than 64 MiB");
    if (answer.error == httplib::Error::Canceled) return notKept();
    if (Clock::now() >= deadline_) return timeIsOver();
    if (isUntrusted(answer.error))
        return failureWith(ExitCode::unreachable, "The certificate of the server is not trusted",
                           toText(server_.endpoint) + ": " + httplib::to_string(answer.error) +
                               "; --ca-file names a PEM file of who signed it");
    const bool absent = couldNotConnect(answer.error);
    return failureWith(ExitCode::unreachable,
                       absent ? "No server answers" : "The connection to the server broke",
                       toText(server_.endpoint) + ": " + httplib::to_string(answer.error));
}

std::optional<Failure> Transport::waitToRetry(const Answer& answer, int tries, Failure failure) {
    const milliseconds pause = retryAfter(answer.response.get_header_value("Retry-After"),
                                          std::chrono::system_clock::now()) +
                               jitter(policy_, tries, random_);
    if (pause >= deadline_ - Clock::now()) return failure;
    if (!interrupt_.sleep(pause)) return failureWith(ExitCode::cancelled, "Cancelled");
    return std::nullopt;
}

Outcome<httplib::Response> Transport::send(const httplib::Request& request,
                                           const SendOptions& options) {
    const int most = options.patient ? policy_.patientTries : policy_.tries;
    BodySink* const sink = options.sink;
    std::optional<Failure> refusal;  // why the server refused tells more than that time is over
    for (int tries = 1;; ++tries) {
        if (interrupt_.requested()) return fail(ExitCode::cancelled, "Cancelled");
        if (Clock::now() >= deadline_) return tl::unexpected(refusal.value_or(timeIsOver()));
        const std::uint64_t kept = sink != nullptr ? sink->received() : 0;
        Answer answer = sendOnce(request, sink);
        if (interrupt_.requested()) return fail(ExitCode::cancelled, "Cancelled");
        const bool answered = answer.error == httplib::Error::Success;
        if (answered && isDone(answer.response)) return std::move(answer.response);

        Failure failure = failureOf(answer);
        if (answered) refusal = failure;
        if (!answered && refusal && Clock::now() >= deadline_) failure = *refusal;
        const bool noSuchPart = answered && answer.response.status == 416 && kept > 0;
        const bool again = answered ? isBusy(request, answer.response) || noSuchPart
                                    : couldNotConnect(answer.error) ||
                                          (isBroken(answer.error) && isRepeatable(request));
        if (sink != nullptr && sink->received() > kept) tries = 0;
        const bool inVain = (!answered || noSuchPart) && tries >= most;
        if (!again || inVain) return tl::unexpected(std::move(failure));
        if (noSuchPart && !sink->restart()) return tl::unexpected(notKept());
        if (auto over = waitToRetry(answer, std::max(tries, 1), std::move(failure)))
            return tl::unexpected(*std::move(over));
    }
}

void Transport::sendAtLast(httplib::Request request, milliseconds patience) {
    httplib::Client client = makeClient();
    client.set_connection_timeout(patience);
    client.set_max_timeout(patience);
    request.start_time_ = Clock::now();
    const TimeKeeper timeKeeper(client, Clock::now() + patience);
    const httplib::Result ignored = client.send(request);
    static_cast<void>(ignored);
}

}  // namespace rivage::client
