#pragma once

#include <functional>
#include <map>
#include <set>
#include <vector>

#include "kinome/scene_editor.h"
#include "loader/build.h"

namespace kinome::loader {

/// What of a scene depends on objects that have changed.
class Dependents {
 public:
  explicit Dependents(const Builder& builder);
  /// Of an object whose parameters have changed.
  void add(const Node& node);
  /// Of a shape that is kept, and has another BSDF, emitter or mesh.
  void add_refitted(const Node& shape);

  const std::set<const Node*>& to_make() const { return to_make_; }
  /// Shapes that are kept, and are to be given what of theirs is made anew.
  const std::set<const Node*>& to_refit() const { return to_refit_; }

 private:
  bool can_be_refitted(const Node& shape) const;

  const Builder& builder_;
  std::map<const Node*, std::vector<const Node*>> holders_;
  std::set<const Node*> to_make_;
  std::set<const Node*> to_refit_;
};

/// Arrays that are set for a mesh at once.
using MeshEdits = std::map<std::string, EditedValue>;
/// Names of the arrays that a shape has as parameters; none where it is no mesh.
std::vector<const char*> mesh_arrays(const Object* shape);
/// One of them.
EditedValue mesh_array(const Object& shape, const std::string& name);
/// An Error where the value is none that array `name` could have.
void check_mesh_array(const std::string& name, const EditedValue& value, const Location& where);

/// Which arrays of a mesh are not those of its file any more.
struct EditedMesh {
  bool has_positions = false;
  bool has_uvs = false;
  bool has_faces = false;
  /// Whether normals were computed from edited positions or faces.
  bool has_computed_normals = false;
  /// Those that were set last, as they were set (a shape normalises them), with nothing computed
  /// since; nullptr: none were.
  std::shared_ptr<const std::vector<Vec3>> normals;
};

/// The mesh as edited; returns what undoes that. `edited`: what was edited so far, which this adds
/// to.
std::function<void()> edit_mesh(Object& shape, const MeshEdits& edits, EditedMesh& edited,
                                const Location& where);
/// The same edits of a shape that is made once more, from the shape that it was; returns what undoes
/// that. An Error where they don't fit it any more.
std::function<void()> carry_over(const Object& former, const EditedMesh& edited, Object& shape,
                                 const Location& where);

/// Gives to a shape what was made anew of its BSDF and emitter; returns what undoes that. Empty,
/// and nothing done, where their textures read attributes that the shape hasn't read from its file.
std::function<void()> refit(Shape& shape, const Node& node, Builder& builder);

}  // namespace kinome::loader
