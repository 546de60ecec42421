#pragma once

#include <fstream>
#include <string>
#include <string_view>

namespace kinome::openimageio {

/// Bytes of a file's header.
struct HeaderBytes {
  int first = 0;
  int size = 0;
};

/// Returns the bytes of a format's header that differ if OpenImageIO writes the same image again:
/// the time ("rla"), the name of the file that is written ("dpx"), or a description that it doesn't
/// initialize unless there is one ("sgi"). Readers accept 0 there.
constexpr HeaderBytes varying_bytes(std::string_view format, bool has_description) {
  if (format == "rla") return {528, 20};
  if (format == "dpx") return {36, 100};
  if (format == "sgi" && !has_description) return {24, 80};
  return {};
}

/// Sets these bytes of a file to 0, so that the same image has the same bytes again. Returns false
/// if the file can't be written.
inline bool clear_varying_bytes(const std::string& path, std::string_view format,
                                bool has_description) {
  const HeaderBytes bytes = varying_bytes(format, has_description);
  if (bytes.size == 0) return true;
  std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
  file.seekp(bytes.first);
  file << std::string(static_cast<size_t>(bytes.size), '\0');
  file.close();
  return !file.fail();
}

}  // namespace kinome::openimageio
