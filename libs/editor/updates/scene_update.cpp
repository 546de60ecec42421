#include "editor/updates/scene_update.h"

#include <algorithm>
#include <iterator>

namespace kinome::loader {

namespace {

/// Completes inserted nodes. Their files are searched for in the folders of their holder.
void finish(Node& node, const Node& holder, const Builder& builder) {
  node.is_inserted = true;
  node.folders = holder.folders;
  if (node.tag != "ref" && node.find("id"))
    throw Error(node.where, "inserted objects can't have an id");
  if (node.tag == "ref") {
    // Aliases are replaced by ids, because a saved scene may not have them.
    const Node* const target = builder.resolved(node);
    if (!target) throw Error(node.where, "unknown id '" + node.value("id") + "'");
    node.find("id")->value = target->value("id");
  }
  for (Node& child : node.children) finish(child, holder, builder);
}

}  // namespace

std::shared_ptr<Node> node_to_insert(const ObjectDescription& description,
                                     const ParameterList::Target& target, const Builder& builder,
                                     Faults& faults) {
  const bool is_volume = target.row && target.row->type == ParameterType::kVolume;
  const char* const expected = target.is_object() ? "bsdf" : is_volume ? "volume" : "texture";
  const bool is_fine = description.tag == expected ||
                       (description.tag == "ref" && !target.is_object() && !description.id.empty());
  if (!is_fine) {
    throw Error(description.where,
                "must be a " + std::string(expected) + ", got <" + description.tag + ">");
  }
  ObjectDescription named = description;
  named.name = target.name;
  auto node = std::make_shared<Node>();
  run_or_throw(faults, [&] { *node = node_of(named, faults, target.node); });
  finish(*node, *target.node, builder);
  return node;
}

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
  if (is_committed_) return;
  undo_shapes();
  for (auto undo = undo_wraps_.rbegin(); undo != undo_wraps_.rend(); ++undo) (*undo)();
  for (auto& [node, edits] : nodes_before_) {
    node->overrides = std::move(edits.overrides);
    node->removed = std::move(edits.removed);
    node->inserted = std::move(edits.inserted);
    node->steps = std::move(edits.steps);
  }
  builder_.take_made();
}

void SceneUpdate::commit() {
  is_committed_ = true;
  builder_.forget_gone();
}

void SceneUpdate::undo_shapes() {
  for (auto undo = undo_.rbegin(); undo != undo_.rend(); ++undo) (*undo)();
  undo_.clear();
  builder_.set_objects(objects_before_);
  meshes_ = meshes_before_;
}

/// Returns the parameters that an edit replaces: a file and pixels replace each other.
std::vector<std::string> SceneUpdate::replaced_sources(const Edit& edit,
                                                       std::span<const Parameter> table) {
  const auto is_source = [](const Parameter& row) {
    return row.type == ParameterType::kImage || row.type == ParameterType::kFile;
  };
  const bool has_pixels = std::any_of(table.begin(), table.end(), [](const Parameter& row) {
    return row.type == ParameterType::kImage;
  });
  if (!has_pixels || !is_source(*edit.target.row) || std::holds_alternative<Unset>(edit.value)) {
    return {};
  }
  std::vector<std::string> replaced;
  for (const Parameter& row : table) {
    if (is_source(row) && row.name != edit.target.name) replaced.emplace_back(row.name);
  }
  return replaced;
}

void SceneUpdate::add(const Edit& edit, std::span<const Parameter> table) {
  Node& node = *edit.target.node;
  if (edit.target.is_object()) {
    wraps_.push_back(&edit);
    return;
  }
  if (!edit.target.row) {
    mesh_edits_[&node][edit.target.name] = edit.value;
    mesh_locations_.emplace(&node, edit.where);
    return;
  }
  nodes_before_.emplace(&node, NodeEdits{node.overrides, node.removed, node.inserted, node.steps});
  const std::vector<std::string> replaced = replaced_sources(edit, table);
  const auto is_meant = [&](const std::string& name) {
    return name == edit.target.name ||
           std::find(replaced.begin(), replaced.end(), name) != replaced.end();
  };
  std::erase_if(node.overrides, [&](const auto& other) { return is_meant(other.name); });
  std::erase_if(node.removed, is_meant);
  std::erase_if(node.inserted,
                [&](const auto& inserted) { return is_meant(inserted->value("name")); });
  std::erase_if(node.steps, [&](const auto& steps) { return is_meant(steps->value("name")); });
  if (std::holds_alternative<AsWritten>(edit.value)) {
    std::copy_if(node.described.begin(), node.described.end(), std::back_inserter(node.overrides),
                 [&](const auto& value) { return is_meant(value.name); });
  } else if (std::holds_alternative<Unset>(edit.value)) {
    node.removed.push_back(edit.target.name);
  } else if (std::holds_alternative<ObjectDescription>(edit.value)) {
    node.removed.push_back(edit.target.name);
    node.inserted.push_back(edit.inserted);
  } else {
    node.removed.insert(node.removed.end(), replaced.begin(), replaced.end());
    node.overrides.push_back({edit.target.name, *as_property(edit.value), edit.where});
    if (edit.inserted) node.steps.push_back(edit.inserted);
  }
  to_make_.insert(&node);
  // The edited parameters determine the mesh again, so that earlier edits of its arrays are void.
  mesh_edits_.erase(&node);
  meshes_after_.erase(&node);
}

/// Wraps a BSDF. The node keeps its address, and becomes the outer BSDF around its former contents.
void SceneUpdate::wrap(const Edit& edit) {
  Node& node = *edit.target.node;
  to_make_.insert(&node);
  if (node.inner) unwrap(node);
  if (!edit.inserted) return;
  const auto inner = std::make_shared<Node>(std::move(node));
  node = *edit.inserted;
  const auto before = inner->attributes;
  for (const char* const name : {"id", "name"}) {
    if (const Attribute* const moved = inner->find(name)) node.attributes.push_back(*moved);
  }
  std::erase_if(inner->attributes,
                [](const Attribute& a) { return a.name == "id" || a.name == "name"; });
  node.inner = inner;
  undo_wraps_.push_back([&node, inner, before] {
    node = std::move(*inner);
    node.attributes = before;
  });
}

void SceneUpdate::unwrap(Node& node) {
  const auto outer = std::make_shared<Node>(std::move(node));
  Node& inner = *outer->inner;
  const auto before = inner.attributes;
  node = std::move(inner);
  for (const char* const name : {"id", "name"}) {
    if (const Attribute* const moved = outer->find(name)) node.attributes.push_back(*moved);
  }
  undo_wraps_.push_back([&node, outer, before] {
    *outer->inner = std::move(node);
    outer->inner->attributes = before;
    node = std::move(*outer);
  });
}

Scene::Contents SceneUpdate::make(const std::function<Scene::Contents()>& contents) {
  for (const Edit* const edit : wraps_) wrap(*edit);
  Scene::Contents result;
  // Repeated if a shape must read its file again, for attributes that it hasn't read before.
  while (!try_to_make(contents, result)) undo_shapes();
  return result;
}

/// Returns false if shapes were added to `to_make_`, so that the update must be repeated.
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
    // Done before shape groups and others copy the geometry.
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

/// Returns false under the same condition as try_to_make().
bool SceneUpdate::refit_shapes(const std::set<const Node*>& shapes,
                               const std::set<const Node*>& remade) {
  const size_t before = to_make_.size();
  refitted_ = 0;
  for (const Node* const node : shapes) {
    if (remade.count(node)) continue;
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
    undo_.push_back(edit_mesh(*made(*node), edits, meshes_[node], mesh_locations_.at(node)));
  }
}

std::shared_ptr<Object> SceneUpdate::made(const Node& node) {
  auto object = builder_.object(node);
  faults_.check();
  return object;
}

}  // namespace kinome::loader
