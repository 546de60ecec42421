#pragma once

#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "kinome/object_description.h"
#include "kinome/scene_loader.h"

namespace kinome {

/// In place of a value: nothing is said of the parameter, so that its default counts. Of a BSDF:
/// what was put around it is taken off.
struct Unset {};
/// In place of a value: the parameter is again what the scene's file says.
struct AsWritten {};
/// A transform that is said as the scene's file says its own, if it can be by a change of its last
/// step: a `<lookat>`, or a `<translate>`, which is added where the last is neither. It is rounded
/// for that to what such a file has (some millionths); otherwise it is set as it is.
struct Placed {
  Transform transform;
};

/// What a parameter of a scene is, and may be set to: arrays are those of meshes, three numbers (or
/// two, of texture coordinates) for each vertex, three vertices for each face. The last four are
/// what it may be set to in place of a value; see SceneEditor::set().
using EditedValue =
    std::variant<bool, int64_t, double, std::string, Vec3, UniformColor, Transform,
                 std::shared_ptr<const Image>, std::vector<float>, std::vector<uint32_t>,
                 ObjectDescription, Unset, AsWritten, Placed>;

/// A parameter that can be set, and what a program needs to show it and to let people enter it.
struct SceneParameter {
  std::string path;  ///< as "floor.bsdf.reflectance.value"; no two are the same
  /// What it takes; nullopt: an array of a mesh.
  std::optional<ParameterType> kind;
  std::string type;    ///< the same in words: "float", "reflectance texture", "array"
  std::string plugin;  ///< of the object that it is of: "bsdf/diffuse"
  std::string doc;     ///< what it means, in a sentence
  std::vector<std::string> choices;  ///< all names that it may be; empty: it is no such name
  /// What it is now: what was set, or what the scene says, or its default. nullopt: nothing of
  /// these, or an array of a mesh or of pixels, which may be large: see SceneEditor::get().
  std::optional<EditedValue> value;
  /// What it is where nothing is set; nullopt: the plugin then does without, or must have it.
  std::optional<EditedValue> default_value;
  bool is_set = false;  ///< by the scene or by an edit: otherwise `value` is the default
  bool is_edited = false;  ///< not by the scene's file
  /// What its type allows: [0,1] for each channel of a reflectance. Plugins may allow less, which
  /// update() tells.
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
  /// Path of the texture that stands in place of a value, of SceneEditor::textured_parameters().
  std::string texture;
};

/// An object of a scene.
struct SceneObject {
  std::string path;
  std::string plugin;      ///< "bsdf/diffuse"
  bool is_around = false;  ///< was put around another one: SceneEditor::set() of Unset takes it off
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
  SceneEditor(const ObjectDescription& scene, const LoadOptions& options, PluginRegistry& registry,
              RenderStats* stats = nullptr);
  ~SceneEditor();
  SceneEditor(const SceneEditor&) = delete;
  SceneEditor& operator=(const SceneEditor&) = delete;

  /// As it is by the last update. The one before an update shares objects with it, and must not be
  /// rendered any more.
  std::shared_ptr<const Scene> scene() const;
  /// The scene as it is, with another integrator: it shares all else. Throws Errors.
  std::shared_ptr<const Scene> scene_with(const ObjectDescription& integrator);

  /// All that can be set, by the scene's order: of each object all that its plugin's table has, be
  /// it in the scene's file or not, but for what another object stands for (a texture, whose own
  /// parameters are listed).
  std::vector<SceneParameter> parameters() const;
  /// All that a texture stands for, which set() may give a value or another texture; they have
  /// none.
  std::vector<SceneParameter> textured_parameters() const;
  /// All objects that have paths, by the scene's order.
  std::vector<SceneObject> objects() const;
  /// What the paths of an object's parameters begin with; "": it has none, as what stands in where
  /// the scene says nothing.
  std::string path_of(const Object& object) const;
  /// What it was set to, or what the scene says, or its default; nullopt where it is none of these.
  /// Error where there is no parameter of this path, or it is a texture.
  std::optional<EditedValue> get(const std::string& path) const;
  /// What set() takes to make it what it is now: a value that was set, the texture that was put in
  /// its place, Unset, or AsWritten where it wasn't edited. Of a BSDF's path: what was put around
  /// it, or Unset. Error as get().
  EditedValue edit_of(const std::string& path) const;
  /// Notes a value for update(). Error, and nothing noted, where there is no parameter of this
  /// path, or its plugin doesn't take such a value. Pixels (`data`) take the place of a file
  /// (`filename`), and the other way round. Arrays of a mesh stay until a parameter of its own
  /// (`to_world`, `filename`, ...) is set.
  ///
  /// A description of a texture, or a "ref" to one, takes the place of a value that textures can
  /// stand for. One of a BSDF, for the path of a BSDF, is put around that, as a bump map is: all
  /// that has that BSDF has the one around it instead, which takes over its path and its id. It
  /// takes the place of what was put there before. Neither has ids of its own. What is in them has
  /// paths once update() has made them.
  void set(const std::string& path, EditedValue value);
  /// Notes several, in their order: where one of them can't be noted, none is.
  void set(std::vector<std::pair<std::string, EditedValue>> values);
  /// Makes the scene anew. Throws Errors where what was set can't be; then the scene is as it was,
  /// and what was noted is forgotten.
  SceneChanges update();

  /// Writes the scene, as it is by the last update, as a file that gives the same picture, to the
  /// bit. It is the text of the scene's own file, with comments and all that wasn't edited as they
  /// stand there, but for names of files, which are made relative to the new place; -D become
  /// <default>s before all else. Edited meshes and pixels are written beside it, as PLY and EXR
  /// files "STEM-PATH.ply", and so are includes that hold edits. What can't be said so (a scene
  /// that a program says, files older than 2.0.0) is written without comments and includes. Throws
  /// Error where a file can't be written.
  void save(const std::string& path) const;

 private:
  class State;
  std::unique_ptr<State> state_;
};

}  // namespace kinome
