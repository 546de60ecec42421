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

/// Edit that removes the scene's value, so that the parameter has its default. For a BSDF, it
/// removes the BSDF that was set around it.
struct Unset {};
/// Edit that restores the value of the scene's file.
struct AsWritten {};
/// Transform that keeps the form of the scene's file if possible. Only the last step in the file is
/// changed, if it is a `<lookat>` or a `<translate>`; otherwise a `<translate>` is added. The
/// transform is then rounded to the file's precision (some millionths). If that isn't possible, the
/// transform is set as it is.
struct Placed {
  Transform transform;
};

/// Value of a scene parameter, or an edit of it. Arrays belong to meshes, with three floats (or
/// two, for texture coordinates) per vertex, and three vertex indices per face. The last four types
/// are edits only; see SceneEditor::set().
using EditedValue =
    std::variant<bool, int64_t, double, std::string, Vec3, UniformColor, Transform,
                 std::shared_ptr<const Image>, std::vector<float>, std::vector<uint32_t>,
                 ObjectDescription, Unset, AsWritten, Placed>;

/// Editable parameter, with the data that a program needs to show it and let users edit it.
struct SceneParameter {
  std::string path;  ///< unique path, for example "floor.bsdf.reflectance.value"
  /// Parameter type; nullopt for an array of a mesh.
  std::optional<ParameterType> kind;
  std::string type;    ///< type as text: "float", "reflectance texture", "array"
  std::string plugin;  ///< plugin of the object that has the parameter: "bsdf/diffuse"
  std::string doc;     ///< description in one sentence
  std::vector<std::string> choices;  ///< valid names; empty if any value is valid
  /// Current value: the edit, the scene's value, or the default. nullopt if there is none, and for
  /// arrays of meshes and pixels, which may be large (see SceneEditor::get()).
  std::optional<EditedValue> value;
  /// Value if nothing is set; nullopt if the parameter is optional or required.
  std::optional<EditedValue> default_value;
  bool is_set = false;  ///< true if set by the scene or an edit; otherwise `value` is the default
  bool is_edited = false;  ///< true if changed since the scene's file
  /// Range of the type, for example [0,1] for each channel of a reflectance. Plugins may be more
  /// restrictive; update() then throws.
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
  /// Path of the texture in place of a value, for SceneEditor::textured_parameters().
  std::string texture;
};

/// Object of a scene.
struct SceneObject {
  std::string path;
  std::string plugin;      ///< "bsdf/diffuse"
  bool is_around = false;  ///< true if set around another object; setting Unset removes it
  const Object* object = nullptr;  ///< the object itself, valid until the next update; not nullptr
};

/// Changes by an update. All objects that are not listed are unchanged.
struct SceneChanges {
  /// "category/name" of each new object, in order of creation.
  std::vector<std::string> made;
  /// Number of shapes that were kept and got another BSDF, other emitter or other triangles.
  size_t refitted = 0;
  /// True if the ray tracer's structure over all shapes was rebuilt.
  bool has_new_structure = false;
};

/// Scene whose parameters can be edited by path, named as in Mitsuba's traverse(): ids or names of
/// objects, then the parameter, as in "red.reflectance.value". An object without an id is called by
/// its name in the enclosing object, or by its category: "sensor.film", "shape_1.bsdf". Objects
/// with an id may also be called in this way. Values that a texture could replace end in ".value",
/// which may be omitted.
///
/// set() records edits; update() applies them and recreates only the objects that depend on them:
/// the edited objects and those that contain them. Shapes are kept if only their material, emitter
/// or triangles change.
///
/// Not thread-safe. Must not be used while the scene is rendered.
class KINOME_EXPORT SceneEditor {
 public:
  /// Loads a scene as load_scene() does. `registry` must outlive the editor.
  SceneEditor(const std::string& path, const LoadOptions& options, PluginRegistry& registry,
              RenderStats* stats = nullptr);
  /// Loads a scene as load_scene_from_string() does.
  SceneEditor(const std::string& xml, const std::string& name, const LoadOptions& options,
              PluginRegistry& registry, RenderStats* stats = nullptr);
  /// Creates a scene from a description.
  SceneEditor(const ObjectDescription& scene, const LoadOptions& options, PluginRegistry& registry,
              RenderStats* stats = nullptr);
  ~SceneEditor();
  SceneEditor(const SceneEditor&) = delete;
  SceneEditor& operator=(const SceneEditor&) = delete;

  /// Scene as of the last update. Scenes from before an update share objects with it, and must not
  /// be rendered any more.
  std::shared_ptr<const Scene> scene() const;
  /// Returns the current scene with another integrator, sharing everything else. Throws Errors.
  std::shared_ptr<const Scene> scene_with(const ObjectDescription& integrator);

  /// All editable parameters, in scene order. For each object, lists all parameters of its plugin's
  /// table, whether the scene's file sets them or not. A parameter whose value is a texture is
  /// replaced by the texture's own parameters.
  std::vector<SceneParameter> parameters() const;
  /// Parameters whose value is a texture. set() can replace it by a value or another texture; they
  /// have no value of their own.
  std::vector<SceneParameter> textured_parameters() const;
  /// All objects with paths, in scene order.
  std::vector<SceneObject> objects() const;
  /// Returns the object with a path that objects() lists; nullopt if there is none. This function
  /// and path_of() take logarithmic time.
  std::optional<SceneObject> object_at(const std::string& path) const;
  /// Prefix of the paths of an object's parameters. A part of a shape, such as an instance's copy
  /// of a shape, has that of the whole shape. Returns "" if there is none, as for objects that are
  /// defaults of the loader.
  std::string path_of(const Object& object) const;
  /// Returns the edit, the scene's value, or the default; nullopt if there is none. Throws Error if
  /// the path is unknown or its value is a texture.
  std::optional<EditedValue> get(const std::string& path) const;
  /// Returns the edit that set() needs to restore the current state: a value, a texture, Unset, or
  /// AsWritten if not edited. For the path of a BSDF: the BSDF set around it, or Unset. Throws
  /// Error as get() does.
  EditedValue edit_of(const std::string& path) const;
  /// Records an edit for update(). Throws Error, and records nothing, if the path is unknown or the
  /// plugin doesn't accept the value. Pixels (`data`) replace a file (`filename`) and vice versa.
  /// Arrays of a mesh are kept until a parameter of the mesh (`to_world`, `filename`, ...) is set.
  ///
  /// A description of a texture, or a "ref" to one, replaces a value where textures are allowed. A
  /// description of a BSDF at the path of a BSDF is put around it, for example a bump map: all
  /// users of the inner BSDF get the outer one, which takes over its path and id, and replaces an
  /// earlier one around it. Neither description may contain ids. Its objects have paths after
  /// update().
  void set(const std::string& path, EditedValue value);
  /// Records several edits in order; if one of them is invalid, records none.
  void set(std::vector<std::pair<std::string, EditedValue>> values);
  /// Applies the recorded edits to the scene. Throws Errors if they are invalid; the scene is then
  /// unchanged, and the edits are discarded.
  SceneChanges update();

  /// Writes the scene as of the last update to a file that renders the same image, bit by bit. The
  /// file is the text of the scene's own file with the edits, including comments. File names become
  /// relative to the new location, and -D definitions become <default>s at the top. Edited meshes
  /// and pixels are written beside it as PLY and EXR files "STEM-PATH.ply", and so are includes
  /// with edits. Scenes without such a text (created from a description, or older than version
  /// 2.0.0) are written without comments and includes. Throws Error if a file can't be written.
  void save(const std::string& path) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace kinome
