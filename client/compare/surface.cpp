#include "client/compare/surface.h"

#include <exception>
#include <new>
#include <string_view>
#include <utility>

namespace rivage::client {

tl::unexpected<Failure> malformed(std::string detail) {
    return fail(ExitCode::refused, "The file is malformed", std::move(detail));
}

tl::unexpected<Failure> unsupported(std::string detail) {
    return fail(ExitCode::refused, "The file cannot be compared", std::move(detail));
}

Outcome<Surface> readSurface(const std::string& bytes, const SurfaceLimits& limits) {
    const std::string_view start = std::string_view(bytes).substr(0, 1024);
    if (start.empty()) return malformed("it is empty");
    const bool glb = start.starts_with("glTF");
    if (!glb && start.find('\0') != std::string_view::npos)
        return unsupported("it is neither GLB nor OBJ");
    if (start.starts_with('{')) return unsupported("it is glTF as text; only GLB is read");
    try {
        auto surface = glb ? readGlb(bytes, limits) : readObj(bytes, limits);
        if (surface && surface->triangles.empty())
            return unsupported(glb ? "it has no triangle" : "it is no OBJ file with faces");
        return surface;
    } catch (const std::bad_alloc&) {
        return unsupported("there is not enough memory for it");
    } catch (const std::exception& exception) {
        return malformed(exception.what());
    }
}

}  // namespace rivage::client
