#include "proto/job.h"

#include <array>
#include <cstdio>
#include <ctime>

namespace rivage::proto {
namespace {

constexpr std::array<const char*, 5> kStates{"queued", "running", "succeeded", "failed",
                                             "canceled"};

Json optionalTime(const std::optional<WallTime>& time) {
    return time ? Json(timestamp(*time)) : Json();
}

Json links(const JobView& job) {
    const std::string self = "/v1/jobs/" + job.id;
    Json links{{"self", self}};
    if (!hasEnded(job.state) || job.hasResult) links["result"] = self + "/result";
    return links;
}

}  // namespace

const char* stateName(JobState state) { return kStates[static_cast<std::size_t>(state)]; }

std::optional<JobState> stateFromName(std::string_view name) {
    for (std::size_t i = 0; i < kStates.size(); ++i)
        if (name == kStates[i]) return static_cast<JobState>(i);
    return std::nullopt;
}

std::string timestamp(WallTime time) {
    using namespace std::chrono;
    const auto total = duration_cast<milliseconds>(time.time_since_epoch()).count();
    const std::time_t seconds = total / 1000;
    std::tm parts{};
    gmtime_r(&seconds, &parts);
    char text[64];
    const std::size_t length = std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%S", &parts);
    std::snprintf(text + length, sizeof text - length, ".%03dZ", static_cast<int>(total % 1000));
    return text;
}

Json progressJson(const JobView& job) {
    const bool solving = job.state == JobState::running && job.solver.has_value();
    return Json{
        {"state", stateName(job.state)},
        {"stage", job.stage ? Json(core::stageName(*job.stage)) : Json()},
        {"progress", job.progress},
        {"step", solving ? Json(job.solver->step) : Json()},
        {"energy", solving ? Json(job.solver->energy) : Json()},
        {"queue_position", job.queuePosition ? Json(*job.queuePosition) : Json()},
    };
}

Json toJson(const JobView& job) {
    Json json{{"id", job.id}, {"name", job.name}};
    json.update(progressJson(job));
    json.update(Json{
        {"attempt", job.attempt},
        {"created", timestamp(job.created)},
        {"started", optionalTime(job.started)},
        {"finished", optionalTime(job.finished)},
        {"expires_at", optionalTime(job.expiresAt)},
        {"options", job.options},
        {"report", job.report},
        {"error", job.error ? toJson(*job.error) : Json()},
        {"links", links(job)},
    });
    return json;
}

Json toJson(const ServiceLimits& limits) {
    const core::Limits& conversion = limits.conversion;
    return Json{
        {"upload_bytes", limits.maxUploadBytes},
        {"voxels", conversion.maxVoxels},
        {"extent_voxels", conversion.maxExtent},
        {"materials", conversion.maxMaterials},
        {"labels", conversion.maxLabels},
        {"models", conversion.maxModels},
        {"memory_bytes", conversion.maxMemory},
        {"output_bytes", conversion.maxOutputBytes},
        {"workers", limits.workers},
        {"queue_jobs", limits.queueLimit},
        {"deadline_ms", limits.deadline.count()},
        {"result_ttl_s", limits.resultTtl.count()},
        {"kept_result_bytes", limits.keptResultBytes},
        {"kept_jobs", limits.keptJobs},
        {"uploads_in_flight_bytes", limits.uploadBudget},
        {"streams", limits.streams},
        {"long_polls", limits.longPolls},
        {"body_timeout_s", limits.bodyTimeout.count()},
        {"min_body_bytes_per_s", limits.minBodyRate},
        {"idle_timeout_s", limits.idleTimeout.count()},
    };
}

Json describeFormats() {
    const auto format = [](const char* name, const char* type, const char* extension,
                           const char* description) {
        return Json{{"name", name},
                    {"media_type", type},
                    {"extension", extension},
                    {"description", description}};
    };
    return Json{
        {"input",
         {format("vox", "application/octet-stream", "vox",
                 "MagicaVoxel 150 and 200 with scene graph, layers, palette and materials"),
          format("npy", "application/octet-stream", "npy",
                 "NumPy array of labels in three dimensions"),
          format("nrrd", "application/x-nrrd", "nrrd",
                 "NRRD volume of labels, also a segmentation of 3D Slicer (.seg.nrrd) with its "
                 "names and colours"),
          format("nifti", "application/octet-stream", "nii",
                 "NIfTI-1 or NIfTI-2 volume of labels, also .nii.gz"),
          format("vol", "application/octet-stream", "vol", "DGtal's .vol and .longvol"),
          format("raw", "application/octet-stream", "raw",
                 "labels as u8 or u16, little-endian, x fastest; needs dims")}},
        {"output",
         {format("glb", "model/gltf-binary", "glb",
                 "binary glTF 2.0, compressed with Draco unless compression=none"),
          format("obj", "model/obj", "obj", "Wavefront OBJ with quads"),
          format("vox", "application/x-magicavoxel", "vox",
                 "MagicaVoxel 200: the smooth model as voxels, see scale"),
          format("nrrd", "application/x-nrrd", "nrrd",
                 "NRRD labels with the segments of 3D Slicer; name it .seg.nrrd for that")}},
    };
}

}  // namespace rivage::proto
