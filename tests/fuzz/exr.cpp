#include "fuzz.h"

/// Reads the input as an environment map.
extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static const kinome::fuzz::InputFile file(".exr");
  kinome::fuzz::load_file(kinome::Category::kEmitter, "envmap", file.write(data, size));
  return 0;
}
