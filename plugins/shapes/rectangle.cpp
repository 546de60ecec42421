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
    Hit hit;
    hit.primitive = u.x >= u.y ? 0 : 1;
    hit.u = std::abs(u.x - u.y);
    hit.v = u.x >= u.y ? u.y : 1 - u.y;
    return sampled_at(hit);
  }
  /// The place is linear in u and v; of all else, only the error is the triangle's.
  void sample_surface_block(const Columns2& u, const SurfaceBlock& out) const override {
    const Plane plane(*this);
    const SurfaceInteraction& any = plane.corner;
    wide::ShapePoint<wide::Float> point;
    const float other_error = sample_surface(Vec2(0.f, 1.f)).p_error;
    point.n = any.n;
    point.frame = {any.frame.s, any.frame.t, any.frame.n};
    point.dp_du = any.dp_du, point.dp_dv = any.dp_dv;
    point.wi = any.wi;
    wide::for_lanes(out.count, [&](size_t i) {
      point.uv = wide::Vec2::load(u, i);
      point.p = plane.at(point.uv);
      const wide::Mask is_first = point.uv.x >= point.uv.y;
      point.p_error = select(is_first, any.p_error, other_error);
      store(point, out, i);
      select(is_first, wide::Uint(0), wide::Uint(1)).store(out.primitive + i);
    });
  }
  void sample_solid_angle_block(const Columns3& p, const Columns2& u, size_t count,
                                const SurfaceSampleBlock& out) const override {
    const Plane plane(*this);
    const wide::Vec3 n(plane.corner.n), sn(plane.corner.frame.n);
    const float whole = area();
    wide::for_lanes(count, [&](size_t i) {
      const wide::Vec2 uv = wide::Vec2::load(u, i);
      const wide::Vec3 place = plane.at(uv);
      const wide::Vec3 to = place - wide::Vec3::load(p, i);
      place.store(out.p, i);
      sn.store(out.sn, i);
      uv.store(out.uv, i);
      wide::formulas::solid_angle_density(to, n, whole).store(out.pdf + i);
    });
  }

 private:
  struct Plane {
    explicit Plane(const Rectangle& shape)
        : corner(shape.sample_surface(Vec2(0.f))),
          origin(shape.mesh_.positions[0]),
          along_u(shape.mesh_.positions[1] - shape.mesh_.positions[0]),
          along_v(shape.mesh_.positions[3] - shape.mesh_.positions[0]) {}
    wide::Vec3 at(wide::Vec2 uv) const { return origin + along_u * uv.x + along_v * uv.y; }

    SurfaceInteraction corner;
    wide::Vec3 origin, along_u, along_v;
  };
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::Rectangle, kinome::Category::kShape, "rectangle",
              "The square [-1, 1] x [-1, 1] in the plane z = 0, facing +z.", kinome::kTable);
