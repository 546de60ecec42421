#pragma once

#include <string>
#include <vector>

#include "editor/updates/edits.h"
#include "kinome/mesh_shape.h"
#include "kinome/object_description.h"
#include "kinome/shape.h"

namespace kinome::loader {

struct SavedMesh {
  /// Parameters of a "ply" shape that reads the same mesh from the file, bit by bit.
  std::vector<ObjectDescription::Value> values;
  std::string bytes;  ///< contents of the file
};
/// Converts an edited mesh to a binary PLY file in world space. `name` is the file's name, for the
/// parameter "filename".
SavedMesh saved_mesh(const MeshShape& shape, const EditedMesh& edited, const std::string& name);

}  // namespace kinome::loader
