#pragma once

#include "fuzz.h"
#include "kinome/shape.h"

namespace kinome::fuzz {

/// Loads the input as a mesh, and checks the result.
inline void load_mesh(const std::string& type, const uint8_t* data, size_t size) {
  static const InputFile file("." + type);
  const auto shape =
      std::dynamic_pointer_cast<Shape>(load_file(Category::kShape, type, file.write(data, size)));
  if (!shape) return;
  const TriangleMesh& mesh = *shape->mesh();
  for (const glm::uvec3& triangle : mesh.triangles) {
    for (int i = 0; i < 3; ++i) {
      if (triangle[i] >= mesh.positions.size()) throw std::logic_error("an index out of range");
    }
  }
  for (const Vec3& position : mesh.positions) {
    if (!is_finite(position)) throw std::logic_error("a position that is not finite");
  }
  if (shape->area() > 0) shape->sample_surface(Vec2(0.25f, 0.75f));
}

}  // namespace kinome::fuzz
