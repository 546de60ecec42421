#pragma once

#include <string>
#include <vector>

#include "kinome/object_description.h"
#include "kinome/shape.h"
#include "loader/edits.h"

namespace kinome::loader {

struct SavedMesh {
  /// Parameters of a "ply" shape that make the mesh once more of the file, bit for bit.
  std::vector<ObjectDescription::Value> values;
  std::string bytes;  ///< of the file
};
/// An edited mesh as a binary PLY file, in world space. `name`: of that file, for "filename".
SavedMesh saved_mesh(const MeshShape& shape, const EditedMesh& edited, const std::string& name);

}  // namespace kinome::loader
