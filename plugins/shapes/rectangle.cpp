/// The square [-1, 1] x [-1, 1] in the plane z = 0, seen from +z. u runs along x, v along y.
///
///     <shape type="rectangle">
///       <transform name="to_world"><scale value="10"/></transform>
///     </shape>

#include <cmath>

#include "kinome/plugin.h"
#include "kinome/shape.h"
#include "shape_parameters.h"

namespace kinome {
namespace {

constexpr Parameter kTable[] = {kToWorld, kFlipNormals, kNestedBsdf, kNestedEmitter};

class Rectangle final : public MeshShape {
 public:
  explicit Rectangle(const Properties& props) : MeshShape(props) {
    mesh_.positions = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
    mesh_.normals.assign(4, Vec3(0, 0, 1));
    mesh_.uvs = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    mesh_.triangles = {{0, 1, 2}, {2, 3, 0}};
    finish(props, to_world_of(props), false, props.boolean("flip_normals"));
  }

  /// By u and v, so that numbers are spread over it as evenly as they are over the square.
  SurfaceInteraction sample_surface(const Vec2& u) const override {
    Hit hit;
    hit.primitive = u.x >= u.y ? 0 : 1;
    hit.u = std::abs(u.x - u.y);
    hit.v = u.x >= u.y ? u.y : 1 - u.y;
    return sampled_at(hit);
  }
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::Rectangle, kinome::Category::kShape, "rectangle",
              "The square [-1, 1] x [-1, 1] in the plane z = 0, facing +z.", kinome::kTable);
