#include "proto/job.h"

#include <doctest/doctest.h>

using namespace rivage;
using proto::JobState;

TEST_SUITE_BEGIN("proto");

TEST_CASE("stateName: every state comes back from its name") {
    for (const JobState state : {JobState::queued, JobState::running, JobState::succeeded,
                                 JobState::failed, JobState::canceled})
        CHECK(proto::stateFromName(proto::stateName(state)) == state);
    CHECK_FALSE(proto::stateFromName("cancelled"));
    CHECK_FALSE(proto::hasEnded(JobState::running));
    CHECK(proto::hasEnded(JobState::canceled));
}

TEST_CASE("timestamp: RFC 3339 in UTC with milliseconds") {
    const proto::WallTime time{std::chrono::milliseconds(1700000000042)};
    CHECK(proto::timestamp(time) == "2023-11-14T22:13:20.042Z");
}

TEST_CASE("toJson: a job shows every member in every state") {
    proto::JobView job;
    job.id = "x";
    const auto queued = proto::toJson(job);
    CHECK(queued["links"].contains("result"));
    CHECK(queued["started"].is_null());
    job.state = JobState::failed;
    job.error = proto::makeProblem({core::ErrorCode::emptyGrid, "no voxel"});
    const auto failed = proto::toJson(job);
    CHECK(failed.size() == queued.size());
    CHECK(failed["error"]["status"] == 422);
    CHECK_FALSE(failed["links"].contains("result"));
}

TEST_CASE("toJson: the limits have their units in their names") {
    const auto limits = proto::toJson(proto::ServiceLimits{.maxUploadBytes = 5});
    CHECK(limits["upload_bytes"] == 5);
    CHECK(limits["labels"] == core::Limits().maxLabels);
}

TEST_SUITE_END();
