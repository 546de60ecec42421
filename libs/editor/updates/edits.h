#pragma once

#include <functional>
#include <map>
#include <set>
#include <vector>

#include "kinome/scene_editor.h"
#include "scene_xml/objects/build.h"

namespace kinome::loader {

/// Objects of a scene that depend on changed objects.
class Dependents {
 public:
  explicit Dependents(const Builder& builder);
  /// Adds an object whose parameters have changed, and its dependents.
  void add(const Node& node);
  /// Adds a shape that is kept, but gets another BSDF, emitter or mesh, and its dependents.
  void add_refitted(const Node& shape);

  /// Objects to make again.
  const std::set<const Node*>& to_make() const { return to_make_; }
  /// Shapes that are kept, but get a new BSDF or emitter.
  const std::set<const Node*>& to_refit() const { return to_refit_; }

 private:
  bool can_be_refitted(const Node& shape) const;

  const Builder& builder_;
  std::map<const Node*, std::vector<const Node*>> holders_;
  std::set<const Node*> to_make_;
  std::set<const Node*> to_refit_;
};

/// Arrays of a mesh that are set together, by name.
using MeshEdits = std::map<std::string, EditedValue>;
/// Returns the names of a mesh's arrays; empty for other shapes.
std::vector<const char*> mesh_arrays(const Object* shape);
/// Returns one of a mesh's arrays.
EditedValue mesh_array(const Object& shape, const std::string& name);
/// Throws Error if the value has the wrong type or size for array `name`.
void check_mesh_array(const std::string& name, const EditedValue& value, const Location& where);

/// Arrays of a mesh that differ from its file.
struct EditedMesh {
  bool has_positions = false;
  bool has_uvs = false;
  bool has_faces = false;
  /// True if normals were computed from edited positions or faces.
  bool has_computed_normals = false;
  /// Normals that were set last, before the shape normalised them; nullptr if none were set, or if
  /// normals were computed since.
  std::shared_ptr<const std::vector<Vec3>> normals;
};

/// Edits a mesh, and returns a function that undoes this. Updates `edited`, the edits so far.
std::function<void()> edit_mesh(Object& shape, const MeshEdits& edits, EditedMesh& edited,
                                const Location& where);
/// Applies earlier edits of `former` to `shape`, which has replaced it. Returns a function that
/// undoes this. Throws Error if the edits no longer fit.
std::function<void()> carry_over(const Object& former, const EditedMesh& edited, Object& shape,
                                 const Location& where);

/// Sets a shape's new BSDF and emitter, and returns a function that undoes this. Returns an empty
/// function and changes nothing if their textures read attributes that the shape hasn't read from
/// its file.
std::function<void()> refit(Shape& shape, const Node& node, Builder& builder);

}  // namespace kinome::loader
