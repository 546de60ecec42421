#include "query_points.h"

#include <set>
#include <string>

#include "kinome/texture.h"
#include "queries.h"

namespace kinome::python {
namespace {

/// Names of the mesh attributes that an object's textures read.
std::set<std::string> attributes_of(const Object& object) {
  std::set<std::string> names;
  if (const auto* const texture = dynamic_cast<const Texture*>(&object)) {
    if (!texture->attribute().empty()) names.insert(texture->attribute());
  }
  for (const auto& part : object.nested()) names.merge(attributes_of(*part));
  return names;
}

}  // namespace

PointArrays::PointArrays(const nb::tuple& arrays) {
  scene = arrays[0].is_none() ? nullptr : nb::cast<HeldScene&>(arrays[0]).scene.get();
  for (size_t k = 0; k < kTriples; ++k) triples[k] = nb::cast<Floats>(arrays[1 + k], false).data();
  uv = nb::cast<Floats>(arrays[kTriples + 1], false).data();
  p_error = nb::cast<Floats>(arrays[kTriples + 2], false).data();
  primitive = nb::cast<Indices>(arrays[kTriples + 3], false).data();
  const auto shapes = nb::cast<Indices>(arrays[kTriples + 4], false);
  shape = shapes.data(), count = shapes.size();
}

const Shape* PointArrays::shape_of(size_t i) const {
  const bool is_known = scene && shape[i] < scene->shapes().size();
  return is_known ? scene->shapes()[shape[i]].get() : nullptr;
}

SurfaceBlock PointArrays::gather(size_t first, std::span<const uint32_t> rows,
                                 Columns& memory) const {
  const SurfaceBlock points = memory.points(rows.size());
  for (size_t i = 0; i < rows.size(); ++i) {
    const size_t from = first + rows[i];
    for (size_t k = 0; k < kTriples; ++k) {
      (points.*kTripleColumns[k]).set(i, row3(triples[k], from));
    }
    points.uv.set(i, {uv[2 * from], uv[2 * from + 1]});
    points.p_error[i] = p_error[from];
    points.primitive[i] = primitive[from];
    points.shape[i] = shape_of(from);
  }
  return points;
}

void check_attributes(const Object& object, const PointArrays& points) {
  for (const std::string& name : attributes_of(object)) {
    std::set<const Shape*> known;
    for (size_t i = 0; i < points.count; ++i) {
      const Shape* const shape = points.shape_of(i);
      if (!known.insert(shape).second) continue;
      if (!shape || !shape->attribute(name)) {
        throw Error("a texture reads the mesh attribute '" + name +
                    "', which the surface point's shape lacks");
      }
    }
  }
}

}  // namespace kinome::python
