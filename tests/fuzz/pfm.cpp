#include "fuzz.h"

/// Reads the input as an environment map and as a texture.
extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static const kinome::fuzz::InputFile file(".pfm");
  const std::string& path = file.write(data, size);
  kinome::fuzz::load_file(kinome::Category::kEmitter, "envmap", path);
  if (size > 1 && data[0] == 'P') {
    kinome::fuzz::load_file(kinome::Category::kTexture, "bitmap", path);
  }
  return 0;
}
