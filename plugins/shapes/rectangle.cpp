/// The square [-1, 1] x [-1, 1] in the plane z = 0, facing +z. u runs along x, v along y.
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

constexpr Parameter kTable[] = {kToWorld, kFlipNormals, kIgnoredFaceNormals,
                                KINOME_NESTED_IN_SHAPES};

class Rectangle final : public wide::Mesh {
 public:
  explicit Rectangle(const Properties& props) : Mesh(props) {
    mesh_.positions = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
    mesh_.normals.assign(4, Vec3(0, 0, 1));
    mesh_.uvs = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    mesh_.triangles = {{0, 1, 2}, {2, 3, 0}};
    finish(props, to_world_of(props), false, props.boolean("flip_normals"));
  }

  /// Only the position, uv and wi vary over the rectangle.
  void interaction_block(const RayHit16* rays, const SurfaceBlock& out) const override {
    if (!(area() > 0) || is_replaced()) return Mesh::interaction_block(rays, out);
    const Plane plane(*this);
    wide::ShapePoint<wide::Float> point = plane.common();
    wide::for_lanes(out.count, [&](size_t i) {
      const wide::GatheredRays ray(rays, out.ray + i);
      const wide::Uint primitive = ray.primitive();
      const wide::Float b1 = ray.u(), b2 = ray.v(), b12 = b1 + b2;
      const wide::Mask is_first = primitive == 0u;
      point.uv = {select(is_first, b12, 1.f - b12), select(is_first, b2, 1.f - b2)};
      plane.set_position(point, is_first);
      point.wi = point.frame.to_local(wide::formulas::opposite_of(ray.d()));
      store(point, out, i);
      primitive.store(out.primitive + i);
    });
  }

  /// Maps u linearly, so that well-distributed samples of the unit square stay well distributed.
  SurfaceInteraction sample_surface(const Vec2& u) const override {
    if (is_replaced()) return Mesh::sample_surface(u);
    Hit hit;
    hit.primitive = u.x >= u.y ? 0 : 1;
    hit.u = std::abs(u.x - u.y);
    hit.v = u.x >= u.y ? u.y : 1 - u.y;
    return sampled_at(hit);
  }
  void sample_surface_block(const Columns2& u, const SurfaceBlock& out) const override {
    if (is_replaced()) return Mesh::sample_surface_block(u, out);
    const Plane plane(*this);
    wide::ShapePoint<wide::Float> point = plane.common();
    wide::for_lanes(out.count, [&](size_t i) {
      point.uv = wide::Vec2::load(u, i);
      const wide::Mask is_first = point.uv.x >= point.uv.y;
      plane.set_position(point, is_first);
      store(point, out, i);
      select(is_first, wide::Uint(0), wide::Uint(1)).store(out.primitive + i);
    });
  }
  void sample_solid_angle_block(const Columns3& p, const Columns2& u, size_t count,
                                const SurfaceSampleBlock& out) const override {
    if (is_replaced()) return Mesh::sample_solid_angle_block(p, u, count, out);
    const Plane plane(*this);
    const wide::Vec3 n(plane.corner.n), sn(plane.corner.frame.n);
    const float whole = area();
    wide::for_lanes(count, [&](size_t i) {
      const wide::Vec2 uv = wide::Vec2::load(u, i);
      const wide::Vec3 point = plane.at(uv);
      const wide::Vec3 to = point - wide::Vec3::load(p, i);
      point.store(out.p, i);
      sn.store(out.sn, i);
      if (out.uv.x) uv.store(out.uv, i);
      wide::formulas::solid_angle_density(to, n, whole).store(out.pdf + i);
    });
  }

 private:
  /// The position is linear in u and v. The error depends on the triangle; all else is constant.
  struct Plane {
    explicit Plane(const Rectangle& shape)
        : corner(shape.sample_surface(Vec2(0.f))),
          other_error(shape.sample_surface(Vec2(0.f, 1.f)).p_error),
          origin(shape.mesh_.positions[0]),
          along_u(shape.mesh_.positions[1] - shape.mesh_.positions[0]),
          along_v(shape.mesh_.positions[3] - shape.mesh_.positions[0]) {}
    wide::Vec3 at(wide::Vec2 uv) const { return origin + along_u * uv.x + along_v * uv.y; }
    wide::ShapePoint<wide::Float> common() const {
      wide::ShapePoint<wide::Float> point;
      point.n = corner.n;
      point.frame = {corner.frame.s, corner.frame.t, corner.frame.n};
      point.dp_du = corner.dp_du, point.dp_dv = corner.dp_dv;
      point.wi = corner.wi;
      return point;
    }
    void set_position(wide::ShapePoint<wide::Float>& point, wide::Mask is_first) const {
      point.p = at(point.uv);
      point.p_error = select(is_first, corner.p_error, other_error);
    }

    SurfaceInteraction corner;
    float other_error;
    wide::Vec3 origin, along_u, along_v;
  };
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::Rectangle, kinome::Category::kShape, "rectangle",
              "The square [-1, 1] x [-1, 1] in the plane z = 0, facing +z.", kinome::kTable);
