/// glTF, text and binary.

#include "scene_target.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    return metrolux::core::fuzz::runScene("scene.gltf", data, size);
}
