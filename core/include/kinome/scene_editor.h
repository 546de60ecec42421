#pragma once

#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "kinome/object_description.h"
#include "kinome/scene_loader.h"

namespace kinome {

/// What a parameter of a scene is, and may be set to: arrays are those of meshes, three numbers (or
/// two, of texture coordinates) for each vertex, three vertices for each face.
using EditedValue =
    std::variant<bool, int64_t, double, std::string, Vec3, UniformColor, Transform,
                 std::shared_ptr<const Image>, std::vector<float>, std::vector<uint32_t>>;

/// One that can be set.
struct SceneParameter {
  std::string path;    ///< as "floor.bsdf.reflectance.value"
  std::string type;    ///< in words: "float", "reflectance texture", "array"
  std::string plugin;  ///< of the object that it is of: "bsdf/diffuse"
  std::string doc;
};

/// What an update has made anew; everything else is what it was before.
struct SceneChanges {
  /// "category/name" of each object, in the order in which they were made.
  std::vector<std::string> made;
  /// Shapes that were kept, and got another BSDF or emitter, or other triangles.
  size_t refitted = 0;
  /// The ray tracer's structure, which is over all shapes.
  bool has_new_structure = false;
};

/// A scene whose parameters can be set by their paths, as Mitsuba's traverse() names them: ids or
/// names of objects, then the parameter, "red.reflectance.value". An object without an id is called
/// by the name that it has where it stands, or by its category: "sensor.film", "shape_1.bsdf". What
/// has an id may be called by either. Values that a texture could stand for end in ".value", which
/// may be left out.
///
/// set() notes a value, update() makes the scene anew from all that were noted, of which it makes
/// only what depends on them: an object whose parameter was set, and those that it is part of, but
/// for shapes, which are kept when nothing but their material, light or triangles changes.
///
/// Not thread-safe, and not to be used while the scene is rendered.
class KINOME_EXPORT SceneEditor {
 public:
  /// Loads a scene as load_scene() does. `registry` must outlive it.
  SceneEditor(const std::string& path, const LoadOptions& options, PluginRegistry& registry,
              RenderStats* stats = nullptr);
  /// As load_scene_from_string().
  SceneEditor(const std::string& xml, const std::string& name, const LoadOptions& options,
              PluginRegistry& registry, RenderStats* stats = nullptr);
  /// A scene that a program says.
  SceneEditor(const ObjectDescription& scene, const LoadOptions& options,
              PluginRegistry& registry, RenderStats* stats = nullptr);
  ~SceneEditor();
  SceneEditor(const SceneEditor&) = delete;
  SceneEditor& operator=(const SceneEditor&) = delete;

  /// As it is by the last update. The one before an update shares objects with it, and must not be
  /// rendered any more.
  std::shared_ptr<const Scene> scene() const;
  /// The scene as it is, with another integrator: it shares all else. Throws Errors.
  std::shared_ptr<const Scene> scene_with(const ObjectDescription& integrator);

  /// All that can be set, by the scene's order.
  std::vector<SceneParameter> parameters() const;
  /// What it was set to, or what the scene says, or its default. Error where there is none of this
  /// path, or it has no value.
  EditedValue get(const std::string& path) const;
  /// Notes a value for update(). Error, and nothing noted, where there is no parameter of this
  /// path, or its plugin doesn't take such a value. Arrays of a mesh stay until a parameter of its own is
  /// set.
  void set(const std::string& path, EditedValue value);
  /// Makes the scene anew. Throws Errors where what was set can't be; then the scene is as it was,
  /// and what was noted is forgotten.
  SceneChanges update();

 private:
  class State;
  std::unique_ptr<State> state_;
};

}  // namespace kinome
