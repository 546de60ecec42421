#include <algorithm>
#include <cmath>
#include <optional>

#include "kinome/block_points.h"
#include "kinome/plugin.h"
#include "kinome/shape.h"
#include "kinome/wide/mesh.h"
#include "kinome/wide/textures.h"

/// Values that a mesh file has for each vertex (interpolated over triangles) or for each face. PLY
/// files may have `vertex_color` (from r, g, b), and any properties NAME_x, NAME_y, NAME_z or
/// similar; glTF files may have COLOR_0. As in Mitsuba, values are not converted: integers from 0
/// to 255 need a scale of 1/255.
///
///     <shape type="ply">
///       <string name="filename" value="painted.ply"/>
///       <bsdf type="diffuse">
///         <texture type="mesh_attribute" name="reflectance">
///           <string name="name" value="vertex_color"/>
///         </texture>
///       </bsdf>
///     </shape>
namespace kinome {
namespace {

using namespace wide::formulas;

constexpr Parameter kParameters[] = {
    {"name", ParameterType::kString, nullptr, "vertex_NAME or face_NAME", true},
    {"scale", ParameterType::kFloat, "1", "scale factor of the values"},
};

/// Vertices of a triangle, and the barycentric coordinates of a point.
template <class F>
struct Corners {
  IntOf<F> i0, i1, i2;  ///< indices of the vertices
  F b1, b2;             ///< barycentric coordinates of the second and third vertex
};

/// Computes the barycentric coordinates from the position, because surface points store it. They
/// are clamped to the triangle.
template <class F>
KINOME_WIDE Corners<F> corners_of(const AttributeArrays& arrays, const IntOf<F>& triangle,
                                  const VecOf<F>& world) {
  using V = VecOf<F>;
  const IntOf<F> first = triangle * 3;
  Corners<F> c;
  c.i0 = as_int(gather(arrays.triangles, first));
  c.i1 = as_int(gather(arrays.triangles + 1, first));
  c.i2 = as_int(gather(arrays.triangles + 2, first));
  const V p = glm::mat3(arrays.to_mesh) * world + V(glm::vec3(arrays.to_mesh[3]));
  const V p0 = wide::gather3(arrays.positions, c.i0 * 3);
  const V e1 = wide::gather3(arrays.positions, c.i1 * 3) - p0;
  const V e2 = wide::gather3(arrays.positions, c.i2 * 3) - p0;
  // Scales edges to a length of about 1, so that products don't underflow.
  const F scale = 1.f / max(max_component(abs(e1)), max_component(abs(e2)));
  const V a = e1 * scale, b = e2 * scale, d = (p - p0) * scale;
  const V n = cross(a, b);
  const F per_area2 = 1.f / dot(n, n);
  const F b1 = dot(cross(d, b), n) * per_area2, b2 = dot(cross(a, d), n) * per_area2;
  const MaskOf<F> is_one = is_finite(b1) && is_finite(b2);
  c.b1 = select(is_one, clamp(b1, F(0.f), F(1.f)), F(0.f));
  c.b2 = select(is_one, clamp(b2, F(0.f), 1.f - c.b1), F(0.f));
  return c;
}

/// Returns value k of the attribute.
template <class F>
KINOME_WIDE F number_at(const MeshAttribute& attribute, const IntOf<F>& triangle,
                        const Corners<F>& c, uint32_t k) {
  const float* const values = attribute.values.data() + k;
  const IntOf<F> size(static_cast<int32_t>(attribute.size));
  if (attribute.is_of_faces()) return gather(values, triangle * size);
  return (1.f - c.b1 - c.b2) * gather(values, c.i0 * size) + c.b1 * gather(values, c.i1 * size) +
         c.b2 * gather(values, c.i2 * size);
}

class AttributeTexture final : public Texture {
 public:
  explicit AttributeTexture(const Properties& props)
      : where_(props.where()),
        name_(props.string("name")),
        scale_(props.real("scale", "must be finite", [](float s) { return std::isfinite(s); })) {
    if (!name_.starts_with("vertex_") && !name_.starts_with("face_")) {
      throw props.error("name", "must begin with 'vertex_' or 'face_', got '" + name_ + "'");
    }
  }

  std::string attribute() const override { return name_; }

  Rgb eval_at(const SurfaceInteraction& si) const override {
    const AttributeArrays arrays = arrays_of(*si.shape);
    const auto triangle = static_cast<int32_t>(si.primitive);
    const auto corners = corners_of<float>(arrays, triangle, si.p);
    Rgb value;
    for (uint32_t k = 0; k < 3; ++k) {
      const uint32_t at = arrays.attribute->size == 1 ? 0 : k;
      value[static_cast<int>(k)] =
          number_at<float>(*arrays.attribute, triangle, corners, at) * scale_;
    }
    return value;
  }
  float eval_1_at(const SurfaceInteraction& si) const override {
    const AttributeArrays arrays = arrays_of(*si.shape, true);
    const auto triangle = static_cast<int32_t>(si.primitive);
    const auto corners = corners_of<float>(arrays, triangle, si.p);
    return number_at<float>(*arrays.attribute, triangle, corners, 0) * scale_;
  }
  void eval_block_at(const SurfaceBlock& points, const Columns3& out) const override {
    for_points(
        points, false,
        [&](const AttributeArrays& arrays, const wide::Int& triangle, const auto& corners,
            size_t i) {
          const MeshAttribute& a = *arrays.attribute;
          const wide::Float x = number_at<wide::Float>(a, triangle, corners, 0) * scale_;
          if (a.size == 1) return wide::Rgb(x).store(out, i);
          wide::Rgb(x, number_at<wide::Float>(a, triangle, corners, 1) * scale_,
                    number_at<wide::Float>(a, triangle, corners, 2) * scale_)
              .store(out, i);
        },
        [&](size_t i) { out.set(i, eval_at(interaction_of(points, i))); });
  }
  void eval_1_block_at(const SurfaceBlock& points, float* out) const override {
    for_points(
        points, true,
        [&](const AttributeArrays& arrays, const wide::Int& triangle, const auto& corners,
            size_t i) {
          (number_at<wide::Float>(*arrays.attribute, triangle, corners, 0) * scale_).store(out + i);
        },
        [&](size_t i) { out[i] = eval_1_at(interaction_of(points, i)); });
  }

  /// Without a surface, returns a guess: most attributes are colours in [0, 1]. BSDFs use it for
  /// the sampling weights of their lobes.
  Rgb eval(const Vec2&) const override { return mean(); }
  Rgb mean() const override { return Rgb(0.5f); }
  float max() const override { return scale_ == 0 ? 0.f : 1.f; }
  float min() const override { return 0; }

 private:
  AttributeArrays arrays_of(const Shape& shape, bool as_number = false) const {
    const auto arrays = shape.attribute(name_);
    if (!arrays) throw Error(where_, "the shape has no attribute '" + name_ + "'");
    if (as_number && arrays->attribute->size != 1) {
      throw Error(where_, "must be a single number here, but the mesh's attribute '" + name_ +
                              "' has " + std::to_string(arrays->attribute->size) + " values");
    }
    return *arrays;
  }

  /// Calls wide_fn(arrays, triangle, corners, i) for vectors whose points are all on one shape, and
  /// point_fn(i) for each point of the other vectors.
  template <class Wide, class Point>
  void for_points(const SurfaceBlock& points, bool as_number, const Wide& wide_fn,
                  const Point& point_fn) const {
    const Shape* known = nullptr;
    std::optional<AttributeArrays> arrays;
    wide::for_lanes(points.count, [&](size_t i) {
      const size_t end = std::min(i + wide::kLanes, points.count);
      for (size_t k = i; k < end; ++k) {
        if (points.shape[k] == points.shape[i]) continue;
        for (k = i; k < end; ++k) point_fn(k);
        return;
      }
      if (points.shape[i] != known) {
        known = points.shape[i];
        arrays = arrays_of(*known, as_number);
      }
      const wide::Uint own = wide::Uint::load(points.primitive + i);
      const wide::Int triangle =
          as_int(select(wide::first_lanes(end - i), own, wide::Uint(points.primitive[i])));
      wide_fn(*arrays, triangle,
              corners_of<wide::Float>(*arrays, triangle, wide::Vec3::load(points.p, i)), i);
    });
  }

  Location where_;
  std::string name_;
  float scale_;
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::AttributeTexture, kinome::Category::kTexture, "mesh_attribute",
              "Numbers or colours from a mesh file, for its vertices or faces.",
              kinome::kParameters);
