#include "server/http/routes.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <set>
#include <sstream>

#include "tests/server/test_server.h"

using namespace rivage;
using namespace rivage::server;

namespace {

std::string readSource(const std::string& path) {
    std::ifstream file(std::string(RIVAGE_SOURCE_DIR) + "/" + path);
    REQUIRE(file);
    std::ostringstream text;
    text << file.rdbuf();
    return text.str();
}

std::string lower(std::string_view text) {
    std::string result(text);
    for (char& c : result) c = static_cast<char>(std::tolower(c));
    return result;
}

/// Whether a text of JSON has this member with this value, written as a real or as an integer.
bool hasNumber(const std::string& text, const std::string& name, const proto::Json& value) {
    const std::string member = "\"" + name + "\":";
    const double number = value;
    const bool whole = number == std::floor(number) && std::abs(number) < 1e15;
    return text.find(member + proto::writeJson(value)) != std::string::npos ||
           (whole &&
            text.find(member + std::to_string(static_cast<long>(number))) != std::string::npos);
}

std::set<std::string> words(const std::string& text) {
    std::istringstream stream(text);
    std::set<std::string> result;
    for (std::string word; stream >> word;) result.insert(word);
    return result;
}

}  // namespace

TEST_SUITE_BEGIN("server/http");

TEST_CASE("matchesRoute: segment by segment, braces take anything but nothing") {
    const Route route{"GET", "/v1/jobs/{id}/result", "", nullptr};
    CHECK(matchesRoute(route, "/v1/jobs/x/result"));
    for (const char* path :
         {"/v1/jobs//result", "/v1/jobs/x", "/v1/jobs/x/result/", "/v1/jobs/x/y/result", "", "/"})
        CHECK_FALSE(matchesRoute(route, path));
    CHECK(matchesRoute({"GET", "/", "", nullptr}, "/"));
}

TEST_CASE("routes: the table in server/README.md is this one") {
    const std::string readme = readSource("server/README.md");
    for (const Route& route : routes()) {
        const std::string line = "| `" + std::string(route.method) + " " + std::string(route.path) +
                                 "` | " + std::string(route.statuses) + " |";
        CAPTURE(line);
        CHECK(readme.find(line) != std::string::npos);
    }
    const auto lines = std::count(readme.begin(), readme.end(), '`');
    CHECK(lines > 0);
}

TEST_CASE("routes: the schema has each of them with its statuses, and no others") {
    const auto schema =
        proto::readJson(readSource("proto/openapi.yaml"), "", {.maxBytes = 1 << 20});
    REQUIRE(schema);
    std::size_t described = 0;
    for (const auto& [path, item] : (*schema)["paths"].items())
        if (!item.contains("servers")) described += item.size();  // else it is the admin port's
    CHECK(described == routes().size());

    for (const Route& route : routes()) {
        CAPTURE(route.path);
        const auto& operation = (*schema)["paths"][std::string(route.path)][lower(route.method)];
        REQUIRE(operation.contains("responses"));
        std::set<std::string> statuses;
        for (const auto& [status, response] : operation["responses"].items())
            if (status != "default") statuses.insert(status);
        // What a key may be refused with is the same for all routes under /v1.
        for (const char* status : {"401", "403", "429"})
            CHECK(statuses.erase(status) == route.path.starts_with("/v1/"));
        CHECK(statuses == words(std::string(route.statuses)));
    }
}

TEST_CASE("routes: the schema names every option with its values and bounds") {
    const auto schema =
        proto::readJson(readSource("proto/openapi.yaml"), "", {.maxBytes = 1 << 20});
    REQUIRE(schema);
    const auto& properties = (*schema)["components"]["schemas"]["Options"]["properties"];
    const auto described = proto::describeOptions()["options"];
    CHECK(properties.size() == described.size());
    for (const auto& option : described) {
        const std::string name = option["name"];
        CAPTURE(name);
        REQUIRE(properties.contains(name));
        const std::string text = proto::writeJson(properties[name]);
        if (option["type"] == "choice") CHECK(properties[name]["enum"] == option["values"]);
        if (option["type"] == "number" || option["type"] == "integer") {
            CHECK(hasNumber(text, "minimum", option["minimum"]));
            CHECK(hasNumber(text, "maximum", option["maximum"]));
        }
    }
}

TEST_CASE("routes: the schema lists every problem type") {
    const auto schema =
        proto::readJson(readSource("proto/openapi.yaml"), "", {.maxBytes = 1 << 20});
    REQUIRE(schema);
    std::set<std::string> listed;
    const auto& type = (*schema)["components"]["schemas"]["Problem"]["properties"]["type"];
    for (const auto& uri : type["enum"]) listed.insert(uri.get<std::string>());
    std::set<std::string> known;
    for (const auto& problem : proto::problemCatalogue())
        known.insert("/problems/" + std::string(problem.slug));
    CHECK(listed == known);
}

TEST_SUITE_END();
