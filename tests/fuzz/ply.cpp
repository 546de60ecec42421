// Reads any bytes as a PLY file.

#include "mesh.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  kinome::fuzz::load_mesh("ply", data, size);
  return 0;
}
