// Reads any bytes as a glTF file.

#include "mesh.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  kinome::fuzz::load_mesh("gltf", data, size);
  return 0;
}
