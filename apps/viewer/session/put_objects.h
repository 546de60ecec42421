#pragma once

#include <string>

#include "kinome/scene_editor.h"

namespace kinome::viewer {

/// Descriptions of textures and maps for SceneEditor::set(). `file` is an image, named as in a
/// scene file.

/// Returns a bitmap texture for a parameter of this type. The values of unitless parameters, such
/// as roughness, are read as stored, without conversion from sRGB.
ObjectDescription bitmap(const std::string& file, ParameterType type);
ObjectDescription checkerboard();
/// Return a BSDF that wraps another one. Values are read as stored in the file.
ObjectDescription normal_map(const std::string& file);
ObjectDescription bump_map(const std::string& file);

}  // namespace kinome::viewer
