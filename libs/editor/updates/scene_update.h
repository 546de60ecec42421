#pragma once

#include <functional>
#include <map>
#include <memory>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "editor/updates/edits.h"
#include "editor/updates/scene_parameters.h"

namespace kinome::loader {

/// An edit of a parameter, or of a BSDF.
struct Edit {
  ParameterList::Target target;
  EditedValue value;
  Location where;
  /// Nodes of a description, or the <transform> of Placed.
  std::shared_ptr<Node> inserted = nullptr;
};

/// Returns the nodes of an object that a program inserts as a parameter's value or wraps around a
/// BSDF. Throws Errors if it is invalid.
std::shared_ptr<Node> node_to_insert(const ObjectDescription& description,
                                     const ParameterList::Target& target, const Builder& builder,
                                     Faults& faults);

/// Edited meshes, by the nodes of their shapes.
using EditedMeshes = std::map<const Node*, EditedMesh>;

/// Runs `function`, and throws Errors with all errors that it reports.
void run_or_throw(Faults& faults, const std::function<void()>& function);

/// One update of a scene: applies edits to its nodes, objects and meshes. The destructor reverts
/// all changes unless commit() was called. All constructor arguments must outlive it.
class SceneUpdate {
 public:
  SceneUpdate(Builder& builder, EditedMeshes& meshes, Faults& faults);
  ~SceneUpdate();
  SceneUpdate(const SceneUpdate&) = delete;
  SceneUpdate& operator=(const SceneUpdate&) = delete;

  /// Adds an edit, in the order in which edits were made. `table` is that of the object's plugin.
  /// `edit` must outlive this.
  void add(const Edit& edit, std::span<const Parameter> table);
  /// Makes all objects that depend on the edits, and then the scene's contents, by `contents`.
  /// Throws Errors.
  Scene::Contents make(const std::function<Scene::Contents()>& contents);
  /// Keeps all changes.
  void commit();

  /// Number of shapes that were kept, and got another BSDF, emitter or mesh.
  size_t refitted() const { return refitted_; }
  bool has_mesh_edits() const { return !mesh_edits_.empty(); }

 private:
  bool try_to_make(const std::function<Scene::Contents()>& contents, Scene::Contents& result);
  bool refit_shapes(const std::set<const Node*>& shapes, const std::set<const Node*>& remade);
  void edit_meshes();
  std::shared_ptr<Object> made(const Node& node);
  void undo_shapes();
  static std::vector<std::string> replaced_sources(const Edit& edit,
                                                   std::span<const Parameter> table);
  void wrap(const Edit& edit);
  void unwrap(Node& node);

  struct NodeEdits {
    std::vector<ObjectDescription::Value> overrides;
    std::vector<std::string> removed;
    std::vector<std::shared_ptr<Node>> inserted;
    std::vector<std::shared_ptr<const Node>> steps;
  };

  Builder& builder_;
  EditedMeshes& meshes_;
  Faults& faults_;
  const Builder::Objects objects_before_;
  const EditedMeshes meshes_before_;
  std::map<Node*, NodeEdits> nodes_before_;
  EditedMeshes meshes_after_;  ///< without the edits that edit_meshes() adds
  std::set<const Node*> to_make_;
  std::map<const Node*, MeshEdits> mesh_edits_;
  std::map<const Node*, Location> mesh_locations_;  ///< locations of the first edits
  std::vector<std::function<void()>> undo_;
  std::vector<const Edit*> wraps_;  ///< applied last, because they change the paths of other edits
  std::vector<std::function<void()>> undo_wraps_;
  size_t refitted_ = 0;
  bool is_committed_ = false;
};

}  // namespace kinome::loader
