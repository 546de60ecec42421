#pragma once

#include <nanobind/nanobind.h>

#include <map>
#include <string>
#include <vector>

#include "kinome/scene_editor.h"

namespace kinome::python {

namespace nb = nanobind;

/// Returns the paths of the scene's sensors in their order; "" for a sensor that is a default.
std::vector<std::string> sensor_paths(const SceneEditor& editor);
/// Returns the paths of all shapes that are part of the scene, without those of shape groups.
std::vector<std::string> shape_paths(const SceneEditor& editor);
/// Returns the object with a path. Throws Error if there is none.
const Object* object_at(const SceneEditor& editor, const std::string& path);
/// Returns the paths of the scene's emitters, without indirect ones, in the order of
/// Scene::emitters(); "" for an emitter without a path.
std::vector<std::string> emitter_paths(const SceneEditor& editor);
/// Returns the paths of the shapes that rays can hit, in the order of Scene::shapes() of `scene`,
/// which may be from before an update. Parts of a shape have its path; "" for unknown shapes.
std::vector<std::string> hit_shape_paths(const SceneEditor& editor, const Scene& scene);
/// Returns the path of the environment emitter, or "".
std::string environment_path(const SceneEditor& editor);
/// Returns the paths of the objects that a shape, sensor or film uses, by their roles: "bsdf",
/// "emitter", "sensor", "film", "sampler", "rfilter", "interior", "exterior", "medium". Defaults,
/// which have no path, are left out.
std::map<std::string, std::string> part_paths(const SceneEditor& editor, const std::string& path);
/// Returns the bounding box (min, max) of a shape, or of the scene if `path` is empty; None if it
/// is empty.
nb::object bounds_of(const SceneEditor& editor, const std::string& path);

/// Returns the largest coordinate that origins of rays may have. Rays from beyond hit nothing.
float max_ray_coordinate_of(const SceneEditor& editor);

/// Returns Bsdf::relative_index() of a BSDF.
float relative_index_of(const SceneEditor& editor, const std::string& path);

/// Returns the radius of a reconstruction filter, and its values at `count` equidistant offsets
/// from 0 to the radius.
nb::tuple filter_values(const SceneEditor& editor, const std::string& path, size_t count);

/// Lends a sensor to another scene, for its lifetime.
class BorrowedSensor {
 public:
  /// Throws Error if the sensor depends on objects of its own scene.
  BorrowedSensor(Sensor& sensor, const Scene& owner, const Scene& borrower);
  ~BorrowedSensor();
  BorrowedSensor(const BorrowedSensor&) = delete;
  BorrowedSensor& operator=(const BorrowedSensor&) = delete;

 private:
  Sensor& sensor_;
  const Scene& owner_;
};

}  // namespace kinome::python
