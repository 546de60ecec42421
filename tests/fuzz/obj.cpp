// Reads any bytes as an OBJ file.

#include "mesh.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  kinome::fuzz::load_mesh("obj", data, size);
  return 0;
}
