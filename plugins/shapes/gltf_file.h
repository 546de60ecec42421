#pragma once

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include <tiny_gltf.h>

#include "gltf_extensions.h"
#include "json_nesting.h"
#include "kinome/error.h"
#include "kinome/read_files.h"

/// Parsing of glTF files and their buffers by tinygltf.
namespace kinome {

/// Returns the first line of a message from the library, which may quote megabytes of the file.
inline std::string first_line(const std::string& text) {
  constexpr size_t kMaxLength = 200;
  const size_t start = text.find_first_not_of(" \t\r\n");
  if (start == std::string::npos) return "the file is broken";
  const std::string line = text.substr(start, text.find_first_of("\r\n", start) - start);
  return line.size() > kMaxLength ? line.substr(0, kMaxLength) + "…" : line;
}

/// Bytes of a binary file before the JSON text. The last eight are the text's length and type.
inline constexpr size_t kBinaryHeader = 20;

/// Parses a file without its images. Throws Error at the file.
inline tinygltf::Model parse_gltf(const std::string& file) {
  const std::string bytes = file_contents(file);
  const auto fail = [&](const std::string& message) {
    throw Error(Location{file, 0, 0}, "can't be read as a glTF file: " + message);
  };
  if (bytes.size() > std::numeric_limits<unsigned>::max()) fail("it is larger than 4 GB");
  const auto size = static_cast<unsigned>(bytes.size());
  const bool is_binary = bytes.starts_with("glTF");
  std::string_view json = bytes;
  if (is_binary && bytes.size() >= kBinaryHeader) {
    uint32_t length = 0;
    std::memcpy(&length, bytes.data() + kBinaryHeader - 8, sizeof length);
    json = json.substr(kBinaryHeader, length);
  }
  if (is_nested_too_deeply(json)) fail("its JSON is nested too deeply");
  const std::string folder = std::filesystem::path(file).parent_path().string();
  tinygltf::TinyGLTF reader;
  // Shapes don't need images.
  reader.SetImageLoader([](tinygltf::Image*, const int, std::string*, std::string*, int, int,
                           const unsigned char*, int, void*) { return true; },
                        nullptr);
  // Pipes and devices, which may be endless, aren't accepted as buffers.
  const auto exists = [](const std::string& path, void*) {
    std::error_code failed;
    return std::filesystem::is_regular_file(path, failed);
  };
  const auto read = [](std::vector<unsigned char>* contents, std::string* /*fault*/,
                       const std::string& path, void*) {
    record_read_file(path);
    const std::string buffer = file_contents(path);
    contents->assign(buffer.begin(), buffer.end());
    return true;
  };
  reader.SetFsCallbacks(
      {exists, tinygltf::ExpandFilePath, read, tinygltf::WriteWholeFile, nullptr});
  tinygltf::Model model;
  std::string error;
  std::string warning;
  bool ok = false;
  try {
    ok = is_binary
             ? reader.LoadBinaryFromMemory(&model, &error, &warning,
                                           reinterpret_cast<const unsigned char*>(bytes.data()),
                                           size, folder)
             : reader.LoadASCIIFromString(&model, &error, &warning, bytes.data(), size, folder);
  } catch (const std::exception& e) {
    fail(first_line(e.what()));
  }
  // Compressed buffers have no bytes for readers that don't support the compression.
  for (const char* const compression : {"EXT_meshopt_compression", "KHR_meshopt_compression"}) {
    if (!ok && bytes.find(compression) != std::string::npos) {
      throw Error(Location{file, 0, 0}, unsupported(compression));
    }
  }
  if (!ok) fail(first_line(error));
  if (!model.asset.version.starts_with("2.")) {
    fail("its version is '" + model.asset.version.substr(0, 20) + "', expected 2.0");
  }
  return model;
}

}  // namespace kinome
