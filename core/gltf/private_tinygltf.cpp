#define TINYGLTF_IMPLEMENTATION
#include "core/gltf/private_tinygltf.h"
