#include "scene_queries.h"

#include <algorithm>
#include <set>

#include "kinome/reconstruction_filter.h"
#include "kinome/scene.h"
#include "kinome/shape_group.h"

namespace kinome::python {
namespace {

std::map<const Object*, std::string> paths_of_objects(const SceneEditor& editor) {
  std::map<const Object*, std::string> paths;
  for (SceneObject& one : editor.objects()) paths.emplace(one.object, std::move(one.path));
  return paths;
}

/// Returns an object's path, or "" if it has none.
std::string path_in(const std::map<const Object*, std::string>& paths, const Object* object) {
  const auto found = paths.find(object);
  return found == paths.end() ? "" : found->second;
}

const Object* object_at(const SceneEditor& editor, const std::string& path) {
  const std::vector<SceneObject> all = editor.objects();
  const auto found = std::ranges::find(all, path, &SceneObject::path);
  if (found == all.end()) throw Error("there is no object '" + path + "' in the scene");
  return found->object;
}

}  // namespace

std::vector<std::string> sensor_paths(const SceneEditor& editor) {
  const auto paths = paths_of_objects(editor);
  std::vector<std::string> found;
  for (const auto& sensor : editor.scene()->sensors()) {
    found.push_back(path_in(paths, sensor.get()));
  }
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

std::string environment_path(const SceneEditor& editor) {
  return path_in(paths_of_objects(editor), editor.scene()->environment());
}

std::map<std::string, std::string> part_paths(const SceneEditor& editor, const std::string& path) {
  const Object* const object = object_at(editor, path);
  const auto paths = paths_of_objects(editor);
  std::map<std::string, std::string> found;
  const auto add = [&](const char* role, const Object* part) {
    if (const std::string at = path_in(paths, part); !at.empty()) found[role] = at;
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
