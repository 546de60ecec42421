#pragma once

#include <functional>
#include <map>
#include <memory>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "loader/edits.h"
#include "loader/scene_parameters.h"

namespace kinome::loader {

/// A value that a parameter is set to.
struct Edit {
  ParameterList::Place place;
  EditedValue value;
  Location where;
  std::shared_ptr<Node> put = nullptr;  ///< of a description: what it says; of Placed: its steps
};

/// The nodes of an object that is to stand in a scene, in place of a parameter's value or around a
/// BSDF. Throws Errors where it can't.
std::shared_ptr<Node> node_to_put(const ObjectDescription& said, const ParameterList::Place& place,
                                  const Builder& builder, Faults& faults);

/// Meshes that have been edited, by the nodes of their shapes.
using EditedMeshes = std::map<const Node*, EditedMesh>;

/// What `function` does, all of its mistakes told together: throws Errors where there are any.
void run_or_throw(Faults& faults, const std::function<void()>& function);

/// One update of a scene: its nodes, the objects made of them, and meshes change by edits, or, where
/// it isn't committed, stay what they were. All that it refers to must outlive it.
class SceneUpdate {
 public:
  SceneUpdate(Builder& builder, EditedMeshes& meshes, Faults& faults);
  ~SceneUpdate();
  SceneUpdate(const SceneUpdate&) = delete;
  SceneUpdate& operator=(const SceneUpdate&) = delete;

  /// In the order in which they were set. `table`: of the object's plugin. `edit` must outlive
  /// this.
  void add(const Edit& edit, std::span<const Parameter> table);
  /// Makes anew what depends on the edits, and then the scene's contents, by `contents`. Throws
  /// Errors.
  Scene::Contents make(const std::function<Scene::Contents()>& contents);
  /// Once the scene is as it should be.
  void commit();

  /// Shapes that were kept, and got another BSDF or emitter, or other triangles.
  size_t refitted() const { return refitted_; }
  bool has_mesh_edits() const { return !mesh_edits_.empty(); }

 private:
  bool try_to_make(const std::function<Scene::Contents()>& contents, Scene::Contents& result);
  bool refit_shapes(const std::set<const Node*>& shapes, const std::set<const Node*>& made_anew);
  void edit_meshes();
  std::shared_ptr<Object> made(const Node& node);
  void undo_shapes();
  static std::vector<std::string> replaced_sources(const Edit& edit,
                                                   std::span<const Parameter> table);
  void put_around(const Edit& edit);
  void take_off(Node& node);

  struct Text {
    std::vector<ObjectDescription::Value> given;
    std::vector<std::string> taken;
    std::vector<std::shared_ptr<Node>> put;
    std::vector<std::shared_ptr<const Node>> steps;
  };

  Builder& builder_;
  EditedMeshes& meshes_;
  Faults& faults_;
  const Builder::Objects objects_before_;
  const EditedMeshes meshes_before_;
  std::map<Node*, Text> texts_before_;
  EditedMeshes meshes_after_;  ///< but for what edit_meshes() adds
  std::set<const Node*> to_make_;
  std::map<const Node*, MeshEdits> mesh_edits_;
  std::map<const Node*, Location> mesh_places_;  ///< of their first edits
  std::vector<std::function<void()>> undo_;
  std::vector<const Edit*> around_;  ///< after all others, whose paths are those of before
  std::vector<std::function<void()>> undo_around_;
  size_t refitted_ = 0;
  bool is_through_ = false;
};

}  // namespace kinome::loader
