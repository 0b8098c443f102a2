#pragma once

/// tinygltf under a name of our own. libdraco carries a second, older copy of `tinygltf`, and a
/// program that links both would mix their functions; see core/gltf/README.md.
#include <fstream>
#include <nlohmann/json.hpp>

#define tinygltf rivage_tinygltf
#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#define TINYGLTF_NO_EXTERNAL_IMAGE
#define TINYGLTF_NO_INCLUDE_STB_IMAGE
#define TINYGLTF_NO_INCLUDE_STB_IMAGE_WRITE
#define TINYGLTF_NO_FS
#include <tiny_gltf.h>
