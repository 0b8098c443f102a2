#include "client/upload.h"

#include <cctype>
#include <random>

#include "client/transport.h"

namespace rivage::client {
namespace {

/// Servers and proxies take request lines of 8 KiB or more.
constexpr std::size_t kMaxQuery = 4096;

/// The given options as JSON, with the types that the wire asks for.
proto::Json optionsJson(const std::vector<proto::OptionText>& options) {
    const auto parsed = proto::parseOptions(options);
    const proto::Json all = parsed ? proto::toJson(*parsed) : proto::Json::object();
    proto::Json given = proto::Json::object();
    for (const proto::OptionText& option : options)
        if (all.contains(option.name)) given[option.name] = all[option.name];
    return given;
}

/// `; filename="..."` for a header; characters other than these become '_', one each.
std::string fileName(const std::string& name) {
    if (name.empty()) return {};
    std::string safe;
    for (const char c : name) {
        const auto byte = static_cast<unsigned char>(c);
        const bool continues = (byte & 0xC0U) == 0x80U;  // of a character in UTF-8
        const bool plain = byte < 0x80U && (std::isalnum(byte) != 0 || c == '.' || c == '-');
        if (!continues) safe += plain ? c : '_';
    }
    return "; filename=\"" + safe + '"';
}

std::string multipart(const Upload& upload, const std::string& boundary) {
    const std::string begin = "--" + boundary + "\r\nContent-Disposition: form-data; name=";
    std::string body = begin + "\"options\"\r\nContent-Type: application/json\r\n\r\n" +
                       proto::writeJson(optionsJson(upload.options)) + "\r\n";
    body += begin + "\"grid\"" + fileName(upload.name) +
            "\r\nContent-Type: application/octet-stream\r\n\r\n";
    body += upload.bytes;
    return body + "\r\n--" + boundary + "--\r\n";
}

}  // namespace

std::string randomKey() {
    std::random_device random;
    std::string key;
    for (int i = 0; i < 32; ++i) key += "0123456789abcdef"[random() % 16];
    return key;
}

httplib::Request makeUpload(const std::string& path, const Upload& upload) {
    httplib::Params params;
    for (const proto::OptionText& option : upload.options)
        params.emplace(option.name, option.value);
    const std::string target = params.empty() ? path : httplib::append_query_params(path, params);

    if (target.size() <= kMaxQuery) {
        httplib::Request request = makeRequest("POST", target);
        request.set_header("Content-Type", "application/octet-stream");
        if (!upload.name.empty())
            request.set_header("Content-Disposition", "attachment" + fileName(upload.name));
        request.body = upload.bytes;
        return request;
    }
    const std::string boundary = "rivage-" + randomKey();
    httplib::Request request = makeRequest("POST", path);
    request.set_header("Content-Type", "multipart/form-data; boundary=" + boundary);
    request.body = multipart(upload, boundary);
    return request;
}

}  // namespace rivage::client
