#include "editor/saving/saved_grid.h"

#include <cstdint>
#include <iterator>

namespace kinome::loader {

namespace {

template <class T>
void append(std::string& bytes, const T* values, size_t count) {
  bytes.append(reinterpret_cast<const char*>(values), count * sizeof(T));
}

}  // namespace

std::string saved_grid(const Image& grid, int slices) {
  constexpr char kVersion = 3;
  const int32_t numbers[] = {1, grid.width, grid.height / slices, slices, grid.channel_count()};
  const float box[] = {0, 0, 0, 1, 1, 1};
  std::string bytes = "VOL";
  bytes += kVersion;
  append(bytes, numbers, std::size(numbers));
  append(bytes, box, std::size(box));
  append(bytes, grid.data.data(), grid.data.size());
  return bytes;
}

}  // namespace kinome::loader
