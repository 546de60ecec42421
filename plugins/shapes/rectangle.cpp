/// The square [-1, 1] x [-1, 1] in the plane z = 0, seen from +z. u runs along x, v along y.
///
///     <shape type="rectangle">
///       <transform name="to_world"><scale value="10"/></transform>
///     </shape>

#include <cmath>

#include "kinome/plugin.h"
#include "kinome/wide/mesh.h"
#include "shape_parameters.h"

namespace kinome {
namespace {

constexpr Parameter kTable[] = {kToWorld, kFlipNormals, kNestedBsdf, kNestedEmitter};

class Rectangle final : public wide::Mesh {
 public:
  explicit Rectangle(const Properties& props) : Mesh(props) {
    mesh_.positions = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
    mesh_.normals.assign(4, Vec3(0, 0, 1));
    mesh_.uvs = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    mesh_.triangles = {{0, 1, 2}, {2, 3, 0}};
    finish(props, to_world_of(props), false, props.boolean("flip_normals"));
  }

  /// By u and v, so that numbers are spread over it as evenly as they are over the square.
  SurfaceInteraction sample_surface(const Vec2& u) const override {
    const Vec2 place = place_in_triangle(u);
    Hit hit;
    hit.primitive = u.x >= u.y ? 0 : 1;
    hit.u = place.x;
    hit.v = place.y;
    return sampled_at(hit);
  }
  void sample_surface_block(const Columns2& u, const SurfaceBlock& out) const override {
    store_places(out, [&](size_t i) {
      const wide::Vec2 at = wide::Vec2::load(u, i);
      return Place{select(at.x >= at.y, wide::Int(0), wide::Int(1)), place_in_triangle(at)};
    });
  }
  /// The place is linear in u and v.
  void sample_solid_angle_block(const Columns3& p, const Columns2& u, size_t count,
                                const SurfaceSampleBlock& out) const override {
    const SurfaceInteraction corner = sample_surface(Vec2(0.f));
    const wide::Vec3 origin(mesh_.positions[0]), n(corner.n), sn(corner.frame.n);
    const wide::Vec3 along_u(mesh_.positions[1] - mesh_.positions[0]);
    const wide::Vec3 along_v(mesh_.positions[3] - mesh_.positions[0]);
    const float whole = area();
    wide::for_lanes(count, [&](size_t i) {
      const wide::Vec2 uv = wide::Vec2::load(u, i);
      const wide::Vec3 place = origin + along_u * uv.x + along_v * uv.y;
      const wide::Vec3 to = place - wide::Vec3::load(p, i);
      place.store(out.p, i);
      sn.store(out.sn, i);
      uv.store(out.uv, i);
      wide::formulas::solid_angle_density(to, n, whole).store(out.pdf + i);
    });
  }

 private:
  template <class V2>
  static V2 place_in_triangle(const V2& u) {
    using namespace wide::formulas;
    return {abs(u.x - u.y), select(u.x >= u.y, u.y, 1.f - u.y)};
  }
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::Rectangle, kinome::Category::kShape, "rectangle",
              "The square [-1, 1] x [-1, 1] in the plane z = 0, facing +z.", kinome::kTable);
