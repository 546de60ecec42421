#pragma once

#include <algorithm>
#include <iterator>
#include <string>
#include <string_view>

#include "mesh_file.h"

/// Required extensions of glTF files (glTF 2.0, 3.12).
namespace kinome {

/// True for required extensions that are implemented, or that don't affect meshes.
inline bool is_supported(const std::string& extension) {
  constexpr std::string_view kRead[] = {"EXT_mesh_gpu_instancing", "KHR_mesh_quantization",
                                        "KHR_node_visibility"};
  constexpr std::string_view kAppearance[] = {
      "KHR_materials_", "KHR_texture_", "KHR_lights_",    "KHR_xmp",          "KHR_animation_",
      "EXT_texture_",   "EXT_lights_",  "EXT_materials_", "MSFT_texture_dds", "ADOBE_materials_"};
  return std::find(std::begin(kRead), std::end(kRead), extension) != std::end(kRead) ||
         std::any_of(std::begin(kAppearance), std::end(kAppearance),
                     [&](std::string_view prefix) { return extension.starts_with(prefix); });
}

/// Error message for an unsupported required extension.
inline std::string unsupported(const std::string& extension) {
  const bool is_compression = extension.find("compression") != std::string::npos;
  return "the file requires the extension '" + TextCursor::shorten(extension) +
         (is_compression
              ? "': compressed meshes are unsupported; export it without compression"
              : "', which is unsupported; supported are EXT_mesh_gpu_instancing, "
                "KHR_mesh_quantization and KHR_node_visibility; extensions of materials, "
                "textures and lights are ignored");
}

}  // namespace kinome
