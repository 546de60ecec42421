/// The cube [-1, 1]³. Each face has its own normals, and texture coordinates from 0 to 1 with the
/// orientation of Mitsuba 3.
///
///     <shape type="cube">
///       <transform name="to_world"><translate z="1"/></transform>
///     </shape>

#include <array>

#include "kinome/plugin.h"
#include "kinome/wide/mesh.h"
#include "shape_parameters.h"

namespace kinome {
namespace {

constexpr Parameter kTable[] = {kToWorld, kFlipNormals, kIgnoredFaceNormals,
                                KINOME_NESTED_IN_SHAPES};

/// Outward normal, and the directions of u and v. u x v points inward on every face.
struct Face {
  Vec3 n, u, v;
};
const std::array<Face, 6> kFaces = {{
    {{1, 0, 0}, {0, 1, 0}, {0, 0, -1}},
    {{-1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
    {{0, 1, 0}, {-1, 0, 0}, {0, 0, -1}},
    {{0, -1, 0}, {0, 0, 1}, {1, 0, 0}},
    {{0, 0, 1}, {0, 1, 0}, {1, 0, 0}},
    {{0, 0, -1}, {0, -1, 0}, {1, 0, 0}},
}};

class Cube final : public wide::Mesh {
 public:
  explicit Cube(const Properties& props) : Mesh(props) {
    for (const Face& face : kFaces) {
      const auto first = static_cast<uint32_t>(mesh_.positions.size());
      for (const Vec2 uv : {Vec2(0, 0), Vec2(1, 0), Vec2(1, 1), Vec2(0, 1)}) {
        mesh_.positions.push_back(face.n + face.u * (2 * uv.x - 1) + face.v * (2 * uv.y - 1));
        mesh_.normals.push_back(face.n);
        mesh_.uvs.push_back(uv);
      }
      mesh_.triangles.emplace_back(first, first + 2, first + 1);
      mesh_.triangles.emplace_back(first, first + 3, first + 2);
    }
    finish(props, to_world_of(props), false, props.boolean("flip_normals"));
  }
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::Cube, kinome::Category::kShape, "cube", "The cube [-1, 1] in all axes.",
              kinome::kTable);
