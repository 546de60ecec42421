#include "loader/scene_update.h"

#include <algorithm>
#include <iterator>

namespace kinome::loader {

namespace {

/// What stands in it is said by no text; its files are looked for where its holder's are.
void finish(Node& node, const Node& holder, const Builder& builder) {
  node.is_put = true;
  node.folders = holder.folders;
  if (node.tag != "ref" && node.find("id")) throw Error(node.where, "what is put has no id");
  if (node.tag == "ref") {
    // Not by an alias, which what is saved may not have.
    const Node* const target = builder.resolved(node);
    if (!target) throw Error(node.where, "nothing has the id '" + node.value("id") + "'");
    node.find("id")->value = target->value("id");
  }
  for (Node& child : node.children) finish(child, holder, builder);
}

}  // namespace

std::shared_ptr<Node> node_to_put(const ObjectDescription& said, const ParameterList::Place& place,
                                  const Builder& builder, Faults& faults) {
  const char* const expected = place.is_object() ? "bsdf" : "texture";
  const bool is_fine =
      said.tag == expected || (said.tag == "ref" && !place.is_object() && !said.id.empty());
  if (!is_fine) {
    throw Error(said.where,
                "only a " + std::string(expected) + " can be put there, not a <" + said.tag + ">");
  }
  ObjectDescription named = said;
  named.name = place.name;
  auto node = std::make_shared<Node>();
  run_or_throw(faults, [&] { *node = node_of(named, faults, place.node); });
  finish(*node, *place.node, builder);
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
  if (is_through_) return;
  undo_shapes();
  for (auto undo = undo_around_.rbegin(); undo != undo_around_.rend(); ++undo) (*undo)();
  for (auto& [node, text] : texts_before_) {
    node->given = std::move(text.given);
    node->taken = std::move(text.taken);
    node->put = std::move(text.put);
    node->steps = std::move(text.steps);
  }
  builder_.take_made();
}

void SceneUpdate::commit() {
  is_through_ = true;
  builder_.forget_gone();
}

void SceneUpdate::undo_shapes() {
  for (auto undo = undo_.rbegin(); undo != undo_.rend(); ++undo) (*undo)();
  undo_.clear();
  builder_.set_objects(objects_before_);
  meshes_ = meshes_before_;
}

/// Of a file and pixels in its place, the one that is set last counts: names of the others.
std::vector<std::string> SceneUpdate::replaced_sources(const Edit& edit,
                                                       std::span<const Parameter> table) {
  const auto is_source = [](const Parameter& row) {
    return row.type == ParameterType::kImage || row.type == ParameterType::kFile;
  };
  const bool has_pixels = std::any_of(table.begin(), table.end(), [](const Parameter& row) {
    return row.type == ParameterType::kImage;
  });
  if (!has_pixels || !is_source(*edit.place.row) || std::holds_alternative<Unset>(edit.value)) {
    return {};
  }
  std::vector<std::string> replaced;
  for (const Parameter& row : table) {
    if (is_source(row) && row.name != edit.place.name) replaced.emplace_back(row.name);
  }
  return replaced;
}

void SceneUpdate::add(const Edit& edit, std::span<const Parameter> table) {
  Node& node = *edit.place.node;
  if (edit.place.is_object()) {
    around_.push_back(&edit);
    return;
  }
  if (!edit.place.row) {
    mesh_edits_[&node][edit.place.name] = edit.value;
    mesh_places_.emplace(&node, edit.where);
    return;
  }
  texts_before_.emplace(&node, Text{node.given, node.taken, node.put, node.steps});
  const std::vector<std::string> replaced = replaced_sources(edit, table);
  const auto is_meant = [&](const std::string& name) {
    return name == edit.place.name ||
           std::find(replaced.begin(), replaced.end(), name) != replaced.end();
  };
  std::erase_if(node.given, [&](const auto& other) { return is_meant(other.name); });
  std::erase_if(node.taken, is_meant);
  std::erase_if(node.put, [&](const auto& put) { return is_meant(put->value("name")); });
  std::erase_if(node.steps, [&](const auto& steps) { return is_meant(steps->value("name")); });
  if (std::holds_alternative<AsWritten>(edit.value)) {
    std::copy_if(node.described.begin(), node.described.end(), std::back_inserter(node.given),
                 [&](const auto& value) { return is_meant(value.name); });
  } else if (std::holds_alternative<Unset>(edit.value)) {
    node.taken.push_back(edit.place.name);
  } else if (std::holds_alternative<ObjectDescription>(edit.value)) {
    node.taken.push_back(edit.place.name);
    node.put.push_back(edit.put);
  } else {
    node.taken.insert(node.taken.end(), replaced.begin(), replaced.end());
    node.given.push_back({edit.place.name, *as_property(edit.value), edit.where});
    if (edit.put) node.steps.push_back(edit.put);
  }
  to_make_.insert(&node);
  // What it is then is what its own parameters say.
  mesh_edits_.erase(&node);
  meshes_after_.erase(&node);
}

/// The node stays what all others know, and becomes the BSDF around what it was.
void SceneUpdate::put_around(const Edit& edit) {
  Node& node = *edit.place.node;
  to_make_.insert(&node);
  if (node.inner) take_off(node);
  if (!edit.put) return;
  const auto inner = std::make_shared<Node>(std::move(node));
  node = *edit.put;
  const auto before = inner->attributes;
  for (const char* const name : {"id", "name"}) {
    if (const Attribute* const moved = inner->find(name)) node.attributes.push_back(*moved);
  }
  std::erase_if(inner->attributes,
                [](const Attribute& a) { return a.name == "id" || a.name == "name"; });
  node.inner = inner;
  undo_around_.push_back([&node, inner, before] {
    node = std::move(*inner);
    node.attributes = before;
  });
}

void SceneUpdate::take_off(Node& node) {
  const auto outer = std::make_shared<Node>(std::move(node));
  Node& inner = *outer->inner;
  const auto before = inner.attributes;
  node = std::move(inner);
  for (const char* const name : {"id", "name"}) {
    if (const Attribute* const moved = outer->find(name)) node.attributes.push_back(*moved);
  }
  undo_around_.push_back([&node, outer, before] {
    *outer->inner = std::move(node);
    outer->inner->attributes = before;
    node = std::move(*outer);
  });
}

Scene::Contents SceneUpdate::make(const std::function<Scene::Contents()>& contents) {
  for (const Edit* const edit : around_) put_around(*edit);
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
