// Reads any bytes as a file of serialized meshes. After an odd first byte, the rest is the content
// of one mesh before compression, because mutations of compressed data hardly ever decompress.

#include <zlib.h>

#include <string>

#include "mesh.h"

namespace {

std::string file_around(const uint8_t* data, size_t size, uint16_t version) {
  uLongf packed_size = compressBound(size);
  std::string packed(packed_size, '\0');
  compress2(reinterpret_cast<Bytef*>(packed.data()), &packed_size, data, size, 1);
  packed.resize(packed_size);
  std::string file{'\x1c', '\x04', static_cast<char>(version), '\0'};
  file += packed;
  file.append(version == 4 ? 8 : 4, '\0');  // the only mesh begins at 0
  return file + std::string{'\1', '\0', '\0', '\0'};
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  if (size == 0 || data[0] % 2 == 0) {
    kinome::fuzz::load_mesh("serialized", data, size);
    return 0;
  }
  const std::string file = file_around(data + 1, size - 1, data[0] & 2 ? 3 : 4);
  kinome::fuzz::load_mesh("serialized", reinterpret_cast<const uint8_t*>(file.data()), file.size());
  return 0;
}
