#include <algorithm>

#include "proto/options.h"
#include "server/http/routes.h"
#include "server/jobs/digest.h"

#ifndef RIVAGE_VERSION
#error "RIVAGE_VERSION comes from the build"
#endif

namespace rivage::server {

/// Made by rivage_embed from proto/openapi.yaml, which keeps to the JSON subset of YAML.
std::span<const WebAsset> schemaAssets();

void writeAsset(const httplib::Request& request, httplib::Response& response,
                const WebAsset& asset) {
    response.set_header("ETag", std::string(asset.etag));
    response.set_header("Cache-Control", "no-cache");
    if (asset.mime.starts_with("text/html"))
        response.set_header("Content-Security-Policy", kPagePolicy);
    if (matchesEtag(listField(request, "If-None-Match"), std::string(asset.etag))) {
        response.status = 304;
        response.set_header("Content-Length", std::to_string(asset.bytes.size()));
        return;
    }
    response.status = 200;
    response.set_content(reinterpret_cast<const char*>(asset.bytes.data()), asset.bytes.size(),
                         std::string(asset.mime));
}

/// GET /v1/limits -> 200
void getLimits(Exchange& exchange) {
    writeJson(exchange.response, 200, proto::toJson(exchange.service.limits));
}

/// GET /v1/formats -> 200
void getFormats(Exchange& exchange) { writeJson(exchange.response, 200, proto::describeFormats()); }

/// GET /v1/options -> 200
void getOptions(Exchange& exchange) { writeJson(exchange.response, 200, proto::describeOptions()); }

/// GET /v1/samples -> 200 {samples: [{name, href}]}
void listSamples(Exchange& exchange) {
    proto::Json list = proto::Json::array();
    for (const std::string& name : exchange.service.samples.names)
        list.push_back({{"name", name}, {"href", "/v1/samples/" + name}});
    writeJson(exchange.response, 200, {{"samples", std::move(list)}});
}

/// GET /v1/samples/{name} -> 200 the bytes of a .vox file | 404
void getSample(Exchange& exchange) {
    const Samples& samples = exchange.service.samples;
    const std::string& name = exchange.request.path_params.at("name");
    if (std::find(samples.names.begin(), samples.names.end(), name) == samples.names.end())
        return writeError(exchange, {core::ErrorCode::notFound,
                                     "there is no sample " + proto::inQuotes(name), "/name"});
    const auto bytes = samples.make(name);
    if (!bytes) return writeError(exchange, bytes.error());
    exchange.response.status = 200;
    exchange.response.set_header("Content-Disposition",
                                 "attachment; filename=\"" + name + ".vox\"");
    exchange.response.set_content(reinterpret_cast<const char*>(bytes->data()), bytes->size(),
                                  "application/octet-stream");
}

/// GET /openapi.json -> 200 | 304
void getSchema(Exchange& exchange) {
    writeAsset(exchange.request, exchange.response, schemaAssets().front());
}

/// GET /version -> 200
void getVersion(Exchange& exchange) {
    writeJson(exchange.response, 200,
              {{"name", "rivage"},
               {"version", RIVAGE_VERSION},
               {"api", "v1"},
               {"compiler", __VERSION__},
               {"httplib", CPPHTTPLIB_VERSION}});
}

/// GET / -> 200 the viewer, or a list of the routes where no viewer is built in | 304
void getIndex(Exchange& exchange) {
    for (const WebAsset& asset : exchange.service.assets)
        if (asset.path == "/index.html")
            return writeAsset(exchange.request, exchange.response, asset);
    proto::Json list = proto::Json::array();
    for (const Route& route : routes())
        list.push_back({{"method", route.method}, {"path", route.path}});
    writeJson(exchange.response, 200, {{"name", "rivage"}, {"routes", std::move(list)}});
}

}  // namespace rivage::server
