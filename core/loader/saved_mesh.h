#pragma once

#include <string>
#include <vector>

#include "kinome/object_description.h"
#include "kinome/shape.h"
#include "loader/edits.h"

namespace kinome::loader {

/// Writes an edited mesh as a binary PLY file, in world space, and returns the parameters of a
/// "ply" shape that make it once more of that file, bit for bit; "filename" among them, as `name`.
/// Throws Error where the file can't be written.
std::vector<ObjectDescription::Value> save_mesh(const MeshShape& shape, const EditedMesh& edited,
                                                const std::string& path, const std::string& name);

}  // namespace kinome::loader
