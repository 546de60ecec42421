#pragma once

#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <string>
#include <vector>

#include "kinome/error.h"
#include "kinome/math.h"

/// Reader of Mitsuba's grids of voxels (.vol, version 3).
namespace kinome {

/// Values of a grid of voxels. The value of channel c at voxel (x, y, z) is
/// values[((z * size.y + y) * size.x + x) * channels + c].
struct VoxelGrid {
  glm::uvec3 size{1};
  uint32_t channels = 1;
  Aabb box{Vec3(0.f), Vec3(1.f)};  ///< of the file
  std::vector<float> values;
  float min = 0, max = 0;
};

/// Grids have fewer values than this, so that an int32_t can number them.
inline constexpr uint64_t kMaxVoxelValues = uint64_t{1} << 31;

/// Returns "voxel (x, y, z)" for value i of a grid.
inline std::string voxel_of(const VoxelGrid& grid, size_t i) {
  const size_t voxel = i / grid.channels, row = voxel / grid.size.x;
  return "voxel (" + std::to_string(voxel % grid.size.x) + ", " +
         std::to_string(row % grid.size.y) + ", " + std::to_string(row / grid.size.y) + ")";
}

/// Sets `min` and `max` of a grid from `where`. Throws Error if a value isn't finite.
inline void find_range(VoxelGrid& grid, const Location& where) {
  float lo = std::numeric_limits<float>::infinity(), hi = -lo;
  int is_fine = 1;
  for (const float v : grid.values) {
    lo = v < lo ? v : lo;
    hi = v > hi ? v : hi;
    is_fine &= static_cast<int>(std::abs(v) <= std::numeric_limits<float>::max());
  }
  grid.min = lo, grid.max = hi;
  if (is_fine != 0) return;
  size_t i = 0;
  while (std::isfinite(grid.values[i])) ++i;
  throw Error(where, voxel_of(grid, i) + " has the value " + format_number(grid.values[i]));
}

/// Reads a .vol file. Throws Error if it isn't a valid one.
inline VoxelGrid read_vol_file(const std::string& file) {
  const auto fail = [&](const std::string& what) { throw Error(Location{file, 0, 0}, what); };
  std::error_code failed;
  const auto bytes = std::filesystem::file_size(file, failed);
  std::ifstream stream(file, std::ios::binary);
  if (failed || !stream) fail("can't be read as a file");
  constexpr size_t kHeader = 48;
  char header[kHeader];
  if (bytes < kHeader || !stream.read(header, kHeader)) {
    fail("is too short for a .vol file: " + std::to_string(bytes) + " bytes, expected at least " +
         std::to_string(kHeader));
  }
  if (std::memcmp(header, "VOL", 3) != 0) fail("is not a .vol file: it doesn't begin with 'VOL'");
  if (header[3] != 3) {
    fail("has version " + std::to_string(header[3]) + " of the .vol format, expected 3");
  }
  int32_t numbers[5];
  std::memcpy(numbers, header + 4, sizeof numbers);
  const auto [type, x, y, z, channels] = numbers;
  if (type != 1) fail("has values of type " + std::to_string(type) + ", expected 1 (float32)");
  const std::string size =
      std::to_string(x) + " x " + std::to_string(y) + " x " + std::to_string(z) + " voxels";
  if (x < 1 || y < 1 || z < 1) fail("has " + size + ", expected at least one along each axis");
  if (channels != 1 && channels != 3 && channels != 6) {
    fail("has " + std::to_string(channels) + " channels, expected 1, 3 or 6");
  }
  // Neither product overflows: each factor is below 2^31, and the first product is compared before
  // the second.
  uint64_t count = uint64_t(x) * uint64_t(y);
  for (const int32_t factor : {z, channels}) {
    if (count < kMaxVoxelValues) count *= uint64_t(factor);
  }
  if (count >= kMaxVoxelValues) {
    fail("has " + size + " with " + std::to_string(channels) +
         " channels, expected fewer than 2147483648 values");
  }
  if (bytes != kHeader + 4 * count) {
    fail("has " + std::to_string(bytes) + " bytes, expected " +
         std::to_string(kHeader + 4 * count) + " for " + size + " with " +
         std::to_string(channels) + " channels");
  }
  VoxelGrid grid;
  grid.size = {x, y, z};
  grid.channels = static_cast<uint32_t>(channels);
  std::memcpy(&grid.box, header + 24, sizeof grid.box);
  static_assert(sizeof grid.box == 24);
  grid.values.resize(count);
  if (!stream.read(reinterpret_cast<char*>(grid.values.data()),
                   static_cast<std::streamsize>(4 * count))) {
    fail("can't be read to its end");
  }
  find_range(grid, Location{file, 0, 0});
  return grid;
}

}  // namespace kinome
