# Run at build time by rivage_embed: writes the C++ source that holds the files.
set(mime_html "text/html; charset=utf-8")
set(mime_js "text/javascript; charset=utf-8")
set(mime_css "text/css; charset=utf-8")
set(mime_svg "image/svg+xml")
set(mime_png "image/png")
set(mime_ico "image/x-icon")
set(mime_json "application/json")
set(mime_yaml "application/json")  # openapi.yaml keeps to the JSON subset of YAML
set(mime_wasm "application/wasm")
set(mime_txt "text/plain; charset=utf-8")
set(mime_map "application/json")

string(REPLACE "|" ";" files "${FILES}")
set(data "")
set(declarations "")
set(entries "")
set(number 0)
foreach(file IN LISTS files)
    set(path "${ROOT}/${file}")
    file(SHA256 "${path}" hash)
    file(SIZE "${path}" size)
    string(REGEX MATCH "[^.]*$" extension "${file}")
    if(DEFINED mime_${extension})
        set(mime "${mime_${extension}}")
    else()
        set(mime "application/octet-stream")
    endif()
    set(symbol "rivage_${FUNCTION}_${number}")
    string(APPEND data
        "asm(\".section .rodata\\n.balign 16\\n.globl ${symbol}\\n${symbol}:\\n\"\n"
        "    \".incbin \\\"${path}\\\"\\n.byte 0\\n.previous\\n\");\n")
    string(APPEND declarations "extern const std::byte ${symbol}[];\n")
    string(APPEND entries
        "        {\"/${file}\", \"${mime}\", {${symbol}, ${size}}, \"\\\"${hash}\\\"\"},\n")
    math(EXPR number "${number} + 1")
endforeach()

file(WRITE "${OUTPUT}" "#include <array>

#include \"server/web/assets.h\"

${data}
extern \"C\" {
${declarations}}

namespace rivage::server {

std::span<const WebAsset> ${FUNCTION}();
std::span<const WebAsset> ${FUNCTION}() {
    static const std::array<WebAsset, ${number}> kAssets = {{
${entries}    }};
    return kAssets;
}

}  // namespace rivage::server
")
