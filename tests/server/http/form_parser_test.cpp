#include "server/http/form_parser.h"

#include <doctest/doctest.h>

#include <vector>

using namespace rivage::server;

namespace {

/// The parts of a form, fed in pieces of one size.
struct Form {
    bool right = true;
    bool complete = false;
    std::vector<std::string> names;
    std::vector<std::string> bodies;
};

Form read(const std::string& text, std::size_t piece = ~std::size_t{0}) {
    Form form;
    FormParser parser(
        "xyz",
        [&](const FormPart& part) {
            form.names.push_back(part.name + "|" + part.filename);
            form.bodies.emplace_back();
            return true;
        },
        [&](const char* data, std::size_t size) {
            form.bodies.back().append(data, size);
            return true;
        });
    for (std::size_t at = 0; at < text.size() && form.right; at += std::min(piece, text.size()))
        form.right = parser.parse(text.data() + at, std::min(piece, text.size() - at));
    form.complete = parser.complete();
    return form;
}

const std::string kGrid =
    "--xyz\r\nContent-Disposition: form-data; name=\"grid\"; filename=\"a \\\"b\\\".vox\"\r\n"
    "Content-Type: application/octet-stream\r\n\r\n";
const std::string kOptions = "\r\n--xyz\r\ncontent-disposition:form-data;name=options\r\n\r\n";
const std::string kEnd = "\r\n--xyz--\r\n";

}  // namespace

TEST_SUITE_BEGIN("server/http");

TEST_CASE("formBoundary: of multipart/form-data only") {
    CHECK(formBoundary("multipart/form-data; boundary=xyz") == "xyz");
    CHECK(formBoundary("Multipart/Form-Data; charset=x; Boundary=\"x y\"") == "x y");
    for (const char* other : {"", "text/plain", "multipart/mixed; boundary=x", "multipart"})
        CHECK_FALSE(formBoundary(other));
    for (const std::string& bad :
         {std::string("multipart/form-data"), std::string("multipart/form-data; boundary="),
          std::string("multipart/form-data; boundary=\"x"),
          "multipart/form-data; boundary=" + std::string(71, 'x'),
          std::string("multipart/form-data; boundary=a\x01")})
        CHECK(formBoundary(bad) == "");
}

TEST_CASE("FormParser: the same parts in pieces of any size") {
    const std::string body = "\r\n--xy\r\n--\r\r\n--xyq" + std::string(40000, '\r');
    for (const std::string before : {"", "\r\n", "\r\n\r\n"})
        for (const std::size_t piece : {1, 2, 3, 7, 4096, 1000000}) {
            CAPTURE(piece);
            const Form form = read(before + kGrid + body + kOptions + "{}" + kEnd, piece);
            CHECK(form.right);
            CHECK(form.complete);
            REQUIRE(form.names == std::vector<std::string>{"grid|a \"b\".vox", "options|"});
            CHECK(form.bodies[0] == body);
            CHECK(form.bodies[1] == "{}");
        }
    const Form empty = read(kGrid + kEnd);
    CHECK(empty.complete);
    CHECK(empty.bodies == std::vector<std::string>{""});
}

TEST_CASE("reject: no prefix of a form is complete") {
    const std::string form = kGrid + "12" + kOptions + "{}" + kEnd;
    for (std::size_t i = 0; i + 2 < form.size(); ++i) CHECK_FALSE(read(form.substr(0, i)).complete);
}

TEST_CASE("reject: forms that are broken, or too big where nothing is kept") {
    const std::string head = "--xyz\r\n";
    const std::string name = "Content-Disposition: form-data; name=a\r\n";
    std::string crowd;
    for (int i = 0; i < 20; ++i) crowd += "X-" + std::to_string(i) + ": y\r\n";
    for (const std::string& bad :
         {std::string("preamble\r\n") + kGrid, std::string("--xyq"), std::string("--xyzqq"),
          head + "\r\nx" + kEnd, head + "no colon\r\n\r\nx" + kEnd,
          head + "Content-Disposition: form-data\r\n\r\nx" + kEnd,
          head + "Content-Disposition: attachment; name=a\r\n\r\nx" + kEnd,
          head + "Content-Disposition: form-data; name=\"a\r\n\r\nx" + kEnd,
          head + name + name + "\r\nx" + kEnd, head + name + crowd + "\r\nx" + kEnd,
          head + "X: " + std::string(9000, 'x'), head + "X: " + std::string(9000, 'x') + "\r\n",
          kGrid + "x" + kEnd + std::string(5000, 'e'), std::string(10000, '\r'), [] {
              std::string ends;
              for (int i = 0; i < 5000; ++i) ends += "\r\n";
              return ends;
          }()}) {
        CAPTURE(bad.substr(0, 80));
        CHECK_FALSE(read(bad).right);
        CHECK_FALSE(read(bad, 1).right);
    }
}

TEST_SUITE_END();
