#pragma once

#include <string>

#include "kinome/scene_editor.h"

namespace kinome::viewer {

/// Descriptions of textures and maps for SceneEditor::set(). `file` is an image, named as in a
/// scene file.

inline ObjectDescription checkerboard() {
  return {.tag = "texture", .type = "checkerboard", .where = Location{"checkerboard"}};
}

/// Returns a bitmap texture. The values of `raw` ones are read as stored, without conversion from
/// sRGB. `name` is its name in the object that has it.
inline ObjectDescription bitmap(const std::string& file, bool raw, const std::string& name = "") {
  ObjectDescription description{
      .tag = "texture", .type = "bitmap", .name = name, .where = Location{"bitmap"}};
  description.values.push_back({"filename", file, description.where});
  if (raw) description.values.push_back({"raw", true, description.where});
  return description;
}

/// Returns a BSDF that wraps another one: a "normalmap" or a "bumpmap".
inline ObjectDescription map_around(const std::string& plugin, const std::string& file) {
  const char* const name = plugin == "normalmap" ? "normalmap" : "texture";
  return {.tag = "bsdf",
          .type = plugin,
          .where = Location{plugin},
          .parts = {bitmap(file, true, name)}};
}

}  // namespace kinome::viewer
