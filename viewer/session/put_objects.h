#pragma once

#include <string>

#include "kinome/scene_editor.h"

namespace kinome::viewer {

/// What textures and maps are to the scene's editor, as people choose them. `file`: an image, by
/// the name that a scene file would have for it.

/// Of a parameter of this type: what stands for numbers, as roughness, is read as it is in the
/// file.
ObjectDescription bitmap(const std::string& file, ParameterType type);
ObjectDescription checkerboard();
/// To be put around a BSDF. Normals are read as they are in the file.
ObjectDescription normal_map(const std::string& file);
ObjectDescription bump_map(const std::string& file);

}  // namespace kinome::viewer
