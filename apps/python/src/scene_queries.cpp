#include "scene_queries.h"

#include <set>

#include "kinome/reconstruction_filter.h"
#include "kinome/scene.h"
#include "kinome/shape_group.h"
#include "scene/traceable.h"

namespace kinome::python {
namespace {

/// Returns an object's path, or "" if it is nullptr or has none.
std::string path_of(const SceneEditor& editor, const Object* object) {
  return object ? editor.path_of(*object) : "";
}

}  // namespace

const Object* object_at(const SceneEditor& editor, const std::string& path) {
  const auto found = editor.object_at(path);
  if (!found) throw Error("there is no object '" + path + "' in the scene");
  return found->object;
}

std::vector<std::string> sensor_paths(const SceneEditor& editor) {
  std::vector<std::string> found;
  for (const auto& sensor : editor.scene()->sensors()) found.push_back(editor.path_of(*sensor));
  return found;
}

std::vector<std::string> shape_paths(const SceneEditor& editor) {
  const auto scene = editor.scene();
  std::set<const Object*> hit;
  for (const auto& shape : scene->shapes()) hit.insert(shape.get());
  std::vector<std::string> found;
  for (const SceneObject& one : editor.objects()) {
    const auto* const shape = dynamic_cast<const Shape*>(one.object);
    if (!shape || dynamic_cast<const ShapeGroup*>(shape)) continue;
    // The scene contains the parts of such a shape in its place.
    const auto parts = shape->parts();
    if (hit.count(shape) || (!parts.empty() && hit.count(parts.front().get()))) {
      found.push_back(one.path);
    }
  }
  return found;
}

std::vector<std::string> emitter_paths(const SceneEditor& editor) {
  std::vector<std::string> found;
  for (const Emitter* const emitter : editor.scene()->emitters()) {
    found.push_back(editor.path_of(*emitter));
  }
  return found;
}

std::vector<std::string> hit_shape_paths(const SceneEditor& editor, const Scene& scene) {
  std::vector<std::string> found;
  for (const auto& shape : scene.shapes()) found.push_back(editor.path_of(*shape));
  return found;
}

std::string environment_path(const SceneEditor& editor) {
  return path_of(editor, editor.scene()->environment());
}

std::map<std::string, std::string> part_paths(const SceneEditor& editor, const std::string& path) {
  const Object* const object = object_at(editor, path);
  std::map<std::string, std::string> found;
  const auto add = [&](const char* role, const Object* part) {
    if (const std::string at = path_of(editor, part); !at.empty()) found[role] = at;
  };
  if (const auto* const shape = dynamic_cast<const Shape*>(object)) {
    add("bsdf", shape->bsdf_pointer().get());
    add("emitter", shape->emitter());
    add("sensor", shape->sensor_pointer().get());
    add("interior", shape->interior());
    add("exterior", shape->exterior());
  } else if (const auto* const sensor = dynamic_cast<const Sensor*>(object)) {
    add("film", &sensor->film());
    add("sampler", &sensor->sampler());
    add("medium", sensor->medium());
  } else if (const auto* const film = dynamic_cast<const Film*>(object)) {
    add("rfilter", &film->filter());
  }
  return found;
}

nb::object bounds_of(const SceneEditor& editor, const std::string& path) {
  Aabb bounds = editor.scene()->bounds();
  if (!path.empty()) {
    const auto* const shape = dynamic_cast<const Shape*>(object_at(editor, path));
    if (!shape) throw Error("'" + path + "' is not a shape");
    bounds = shape->bounds();
  }
  if (bounds.empty()) return nb::none();
  const auto triple = [](const Vec3& v) { return nb::make_tuple(v.x, v.y, v.z); };
  return nb::make_tuple(triple(bounds.lo), triple(bounds.hi));
}

float max_ray_coordinate_of(const SceneEditor& editor) {
  std::vector<const ShapeInstance*> instances;
  for (const SceneObject& one : editor.objects()) {
    const auto* const instance = dynamic_cast<const ShapeInstance*>(one.object);
    if (instance) instances.push_back(instance);
  }
  return max_ray_coordinate(instances);
}

float relative_index_of(const SceneEditor& editor, const std::string& path) {
  const auto* const bsdf = dynamic_cast<const Bsdf*>(object_at(editor, path));
  if (!bsdf) throw Error("'" + path + "' is not a BSDF");
  return bsdf->relative_index();
}

nb::tuple filter_values(const SceneEditor& editor, const std::string& path, size_t count) {
  const auto* const filter = dynamic_cast<const ReconstructionFilter*>(object_at(editor, path));
  if (!filter) throw Error("'" + path + "' is not a reconstruction filter");
  nb::list values;
  for (size_t i = 0; i < count; ++i) {
    values.append(
        filter->eval(filter->radius() * static_cast<float>(i) / static_cast<float>(count - 1)));
  }
  return nb::make_tuple(filter->radius(), values);
}

BorrowedSensor::BorrowedSensor(Sensor& sensor, const Scene& owner, const Scene& borrower)
    : sensor_(sensor), owner_(owner) {
  if (sensor.is_surface() || sensor.medium()) {
    throw Error("a sensor at a surface or in a medium must be part of the rendered scene");
  }
  sensor.set_scene_bounds(borrower.bounds());
}

BorrowedSensor::~BorrowedSensor() {
  sensor_.set_scene_bounds(owner_.bounds());
}

}  // namespace kinome::python
