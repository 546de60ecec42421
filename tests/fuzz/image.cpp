#include "fuzz.h"

/// Reads PNG, JPEG and Radiance files as textures. Other formats are skipped, because OpenImageIO
/// reads them.
extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static const kinome::fuzz::InputFile file(".image");
  const std::string bytes(reinterpret_cast<const char*>(data), size);
  for (const char* magic : {"\x89PNG", "\xff\xd8", "#?"}) {
    if (!bytes.starts_with(magic)) continue;
    kinome::fuzz::load_file(kinome::Category::kTexture, "bitmap", file.write(data, size));
  }
  return 0;
}
