#include <algorithm>
#include <optional>
#include <thread>

#include "client/commands/local.h"
#include "client/commands/regularize.h"
#include "client/local_server.h"
#include "client/printable.h"

namespace rivage::client {
namespace {

constexpr std::size_t kForeignWorkers = 2;  ///< conversions at a time at a server of others

std::size_t processors() { return std::max<std::size_t>(std::thread::hardware_concurrency(), 1); }

ExitCode dispatch(Session& session, const RegularizePlan& plan) {
    switch (session.invocation.command) {
        case Command::regularize:
            return session.invocation.watch ? runWatch(session, plan)
                                            : runRegularize(session, plan);
        case Command::inspect: return runInspect(session);
        case Command::sample: return runSample(session);
        case Command::listSamples: return runListSamples(session);
        case Command::options: return runOptions(session);
        case Command::health: return runHealth(session);
        case Command::jobsList: return runJobsList(session);
        case Command::jobsStatus: return runJobsStatus(session);
        case Command::jobsWait: return runJobsWait(session);
        case Command::jobsCancel: return runJobsCancel(session);
        case Command::jobsFetch: return runJobsFetch(session);
        case Command::compare:
        case Command::completions:
        case Command::man: break;  // need no server
    }
    return ExitCode::usage;
}

bool needsJobs(Command command) {
    return command == Command::jobsList || command == Command::jobsStatus ||
           command == Command::jobsWait || command == Command::jobsCancel ||
           command == Command::jobsFetch;
}

/// How many conversions run at a time at a server of our own.
std::size_t ownWorkers(const Invocation& invocation, const RegularizePlan& plan) {
    if (invocation.workers > 0) return invocation.workers;
    const std::size_t most = invocation.watch ? processors() : plan.files.size();
    return std::clamp<std::size_t>(most, 1, processors());
}

void warnOfOpenKey(const Invocation& invocation, const Endpoint& endpoint, Console& console) {
    if (invocation.apiKey.empty() || invocation.quiet || endpoint.tls || isLoopback(endpoint))
        return;
    console.err << "rivage: warning: the API key goes to " << printable(toText(endpoint))
                << " unencrypted; https:// keeps it secret\n"
                << std::flush;
}

/// Runs a command at the server that is named, or else at one of our own.
ExitCode runAt(Invocation invocation, Console& console, Interrupt& interrupt,
               const RegularizePlan& plan) {
    std::optional<LocalServer> own;
    Outcome<Endpoint> endpoint;
    if (invocation.server.empty()) {
        invocation.workers = ownWorkers(invocation, plan);
        auto started = LocalServer::start(serverBeside(), invocation.workers, interrupt);
        if (!started) return complain(invocation, console, {}, started.error());
        own.emplace(*std::move(started));
        endpoint = own->endpoint();
    } else {
        if (invocation.workers == 0) invocation.workers = kForeignWorkers;
        endpoint = parseEndpoint(invocation.server);
        if (!endpoint) return complain(invocation, console, {}, endpoint.error());
    }
    if (!own) warnOfOpenKey(invocation, *endpoint, console);
    const ServerAccess server = own ? ServerAccess{*endpoint, {}, {}}
                                    : ServerAccess{*endpoint, invocation.apiKey, invocation.caFile};
    Session session{invocation, console, interrupt, server, own.has_value()};
    return dispatch(session, plan);
}

ExitCode runChecked(const Invocation& invocation, Console& console, Interrupt& interrupt) {
    if (invocation.command == Command::compare) return runCompare(invocation, console, interrupt);
    if (invocation.command == Command::completions) return runCompletions(invocation, console);
    if (invocation.command == Command::man) return runMan(console);
    if (needsJobs(invocation.command) && invocation.server.empty())
        return complain(invocation, console, {},
                        failureWith(ExitCode::usage, "Jobs are at a server",
                                    "name it with --server or RIVAGE_SERVER"));
    RegularizePlan plan;
    if (invocation.command == Command::regularize) {
        auto planned = planRegularize(invocation);
        if (!planned) return complain(invocation, console, {}, planned.error());
        plan = *std::move(planned);
        for (const Unread& unread : plan.inputs.unread)
            complain(
                invocation, console, unread.path,
                failureWith(ExitCode::usage, "It cannot be read, and is left out", unread.why));
        if (auto made = makeFolders(invocation, plan); !made)
            return complain(invocation, console, {}, made.error());
    }
    return runAt(invocation, console, interrupt, plan);
}

}  // namespace

ExitCode runCommand(const Invocation& invocation, Console& console, Interrupt& interrupt) {
    const ExitCode exit = runChecked(invocation, console, interrupt);
    if (exit != ExitCode::ok || outputArrived(console, "rivage")) return exit;
    return ExitCode::notWritten;
}

}  // namespace rivage::client
