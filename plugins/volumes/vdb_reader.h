#pragma once

#include <string>

#include "vol_file.h"

namespace kinome {

/// Reads a grid of an OpenVDB file, without its range of values. An empty `name` selects the first
/// grid of numbers or vectors. Returns false with a reason in `error` if that fails.
using ReadVdbFunction = bool (*)(const std::string& path, const std::string& name, VoxelGrid& grid,
                                 std::string& error);
inline constexpr const char* kReadVdbSymbol = "kinome_read_vdb";
/// Library with that function, relative to the folder of volume plugins. It exists only if Kinome
/// was built with OpenVDB.
inline constexpr const char* kReadVdbLibrary = "../support/openvdb_reader.so";

/// Returns true if a file begins as OpenVDB files do.
inline bool is_vdb_file(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  char magic[4] = {};
  return file.read(magic, sizeof magic) && std::memcmp(magic, " BDV", sizeof magic) == 0;
}

}  // namespace kinome
