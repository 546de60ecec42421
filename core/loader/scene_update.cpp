#include "loader/scene_update.h"

#include <algorithm>

namespace kinome::loader {

void run_or_throw(Faults& faults, const std::function<void()>& function) {
  faults = {};
  try {
    faults.attempt(function);
  } catch (const Faults::Stop&) {
  }
  faults.check();
}

SceneUpdate::SceneUpdate(Builder& builder, EditedMeshes& meshes, Faults& faults)
    : builder_(builder),
      meshes_(meshes),
      faults_(faults),
      objects_before_(builder.objects()),
      meshes_before_(meshes),
      meshes_after_(meshes) {}

SceneUpdate::~SceneUpdate() {
  if (is_through_) return;
  undo_shapes();
  for (auto& [node, text] : texts_before_) {
    node->given = std::move(text.given);
    node->taken = std::move(text.taken);
  }
  builder_.take_made();
}

void SceneUpdate::undo_shapes() {
  for (auto undo = undo_.rbegin(); undo != undo_.rend(); ++undo) (*undo)();
  undo_.clear();
  builder_.set_objects(objects_before_);
  meshes_ = meshes_before_;
}

void SceneUpdate::add(const Edit& edit, std::span<const Parameter> table) {
  Node& node = *edit.place.node;
  if (!edit.place.row) {
    mesh_edits_[&node][edit.place.name] = edit.value;
    mesh_places_.emplace(&node, edit.where);
    return;
  }
  texts_before_.emplace(&node, Text{node.given, node.taken});
  // Of a file and pixels in its place, the one that is set last counts.
  constexpr ParameterType kSources[] = {ParameterType::kImage, ParameterType::kFile};
  const auto has = [&](ParameterType type) {
    return std::any_of(table.begin(), table.end(), [&](const auto& r) { return r.type == type; });
  };
  const auto* const own = std::find(std::begin(kSources), std::end(kSources), edit.place.row->type);
  std::vector<std::string> replaced;
  for (const Parameter& row : table) {
    if (own == std::end(kSources) || !has(ParameterType::kImage) || &row == edit.place.row) continue;
    if (row.type == kSources[0] || row.type == kSources[1]) replaced.emplace_back(row.name);
  }
  std::erase_if(node.given, [&](const auto& other) {
    return other.name == edit.place.name ||
           std::find(replaced.begin(), replaced.end(), other.name) != replaced.end();
  });
  std::erase_if(node.taken, [&](const std::string& name) {
    return name == edit.place.name ||
           std::find(replaced.begin(), replaced.end(), name) != replaced.end();
  });
  node.taken.insert(node.taken.end(), replaced.begin(), replaced.end());
  node.given.push_back({edit.place.name, *as_property(edit.value), edit.where});
  to_make_.insert(&node);
  // What it is then is what its own parameters say.
  mesh_edits_.erase(&node);
  meshes_after_.erase(&node);
}

Scene::Contents SceneUpdate::make(const std::function<Scene::Contents()>& contents) {
  Scene::Contents result;
  // Once more where a shape must read its file again, for attributes that it had no use for.
  while (!try_to_make(contents, result)) undo_shapes();
  return result;
}

/// False where shapes were added to `to_make_`, and all is to be done again.
bool SceneUpdate::try_to_make(const std::function<Scene::Contents()>& contents,
                              Scene::Contents& result) {
  Dependents dependents(builder_);
  for (const Node* const node : to_make_) dependents.add(*node);
  for (const auto& [node, edits] : mesh_edits_) dependents.add_refitted(*node);
  auto objects = builder_.objects();
  for (const Node* const node : dependents.to_make()) objects.erase(node);
  builder_.set_objects(std::move(objects));
  builder_.take_made();
  meshes_ = meshes_after_;
  bool is_done = false;
  run_or_throw(faults_, [&] {
    // Before what takes over their geometry, as groups do.
    for (const auto& [node, edited] : meshes_after_) {
      if (!dependents.to_make().count(node)) continue;
      const auto former = objects_before_.find(node);
      if (former == objects_before_.end() || !former->second) continue;
      undo_.push_back(carry_over(*former->second, edited, *made(*node), node->where));
    }
    is_done = refit_shapes(dependents.to_refit(), dependents.to_make());
    if (!is_done) return;
    edit_meshes();
    result = contents();
  });
  return is_done;
}

/// False as try_to_make().
bool SceneUpdate::refit_shapes(const std::set<const Node*>& shapes,
                               const std::set<const Node*>& made_anew) {
  const size_t before = to_make_.size();
  refitted_ = 0;
  for (const Node* const node : shapes) {
    if (made_anew.count(node)) continue;
    const auto shape = std::dynamic_pointer_cast<Shape>(builder_.made_of(*node));
    auto put_back = refit(*shape, *node, builder_);
    if (put_back) {
      undo_.push_back(std::move(put_back));
    } else {
      to_make_.insert(node);
    }
    ++refitted_;
  }
  faults_.check();
  return to_make_.size() == before;
}

void SceneUpdate::edit_meshes() {
  for (const auto& [node, edits] : mesh_edits_) {
    undo_.push_back(edit_mesh(*made(*node), edits, meshes_[node], mesh_places_.at(node)));
  }
}

std::shared_ptr<Object> SceneUpdate::made(const Node& node) {
  auto object = builder_.object(node);
  faults_.check();
  return object;
}

}  // namespace kinome::loader
