#include "client/conversion.h"

#include <utility>

namespace rivage::client {
namespace {

using proto::Json;

constexpr std::chrono::milliseconds kGiveUpPatience{2000};

/// One job from its submission to its result.
class Attempt {
public:
    Attempt(Transport& transport, const ByteStore& store, const JobWatch& watch)
        : transport_(transport), store_(store), watch_(watch) {}

    Outcome<Conversion> run(const Upload& upload) {
        auto id = submitJob(transport_, upload);
        if (!id) return tl::unexpected(id.error());
        auto report = finish(*id);
        if (report) return Conversion{*std::move(id), *std::move(report)};
        Failure failure = std::move(report.error());
        if (transport_.interrupt().requested())
            transport_.sendAtLast(makeDeletion(*id), kGiveUpPatience);
        else if (!ended_ || succeeded_)
            failure.job = *std::move(id);
        return tl::unexpected(std::move(failure));
    }

private:
    Outcome<Json> finish(const std::string& id) {
        auto job = followJob(transport_, id, watch_);
        if (!job) return job;
        ended_ = true;
        auto report = reportOf(*job);
        if (!report) return report;
        succeeded_ = true;
        if (auto fetched = fetchResult(transport_, id, store_); !fetched)
            return tl::unexpected(fetched.error());
        return report;
    }

    Transport& transport_;
    const ByteStore& store_;
    const JobWatch& watch_;
    bool ended_ = false;
    bool succeeded_ = false;
};

/// Whether the server does not know a job any more that it took: the input is not at fault.
bool isLost(const Failure& failure) {
    return !failure.job.empty() && failure.exit == ExitCode::refused;
}

}  // namespace

Outcome<Conversion> convertGrid(Transport& transport, const Upload& upload, const ByteStore& store,
                                const JobWatch& watch) {
    auto done = Attempt(transport, store, watch).run(upload);
    if (done || !isLost(done.error())) return done;
    if (!store.restart()) return fail(ExitCode::notWritten, "The result could not be kept");
    done = Attempt(transport, store, watch).run(upload);
    if (!done && isLost(done.error())) {
        done.error().exit = ExitCode::failed;
        done.error().job.clear();
    }
    return done;
}

}  // namespace rivage::client
