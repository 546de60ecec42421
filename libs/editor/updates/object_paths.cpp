#include "editor/updates/object_paths.h"

#include <algorithm>

namespace kinome::loader {
namespace {

/// An object inside of another one.
struct PartOfNode {
  std::string name;        ///< name in listed paths
  std::string scene_name;  ///< name in the scene, or ""
  const Node* node;
};

std::string numbered(const std::string& name, int i) {
  return i == 0 ? name : name + "_" + std::to_string(i);
}

/// Returns the objects inside of a node, with unique names. Objects of the scene itself are named
/// by their id, textures, volumes and media of shapes by their parameter, and other objects by
/// their category.
std::vector<PartOfNode> parts_of(const Node& node, const Builder& builder) {
  const bool is_scene = node.tag == "scene";
  std::vector<PartOfNode> parts;
  std::set<std::string> used;
  for_each_part(node, [&](const Node& child) {
    if (!is_object(child) || child.is_broken) return;
    const std::string scene_name = child.value("name");
    const bool is_inserted =
        std::any_of(node.inserted.begin(), node.inserted.end(),
                    [&](const auto& inserted) { return inserted.get() == &child; });
    if (!scene_name.empty() && !is_inserted && node.is_overridden(scene_name)) return;
    const Node* const target = builder.resolved(child);
    if (!target) return;
    const std::string id = target->value("id");
    const bool is_by_parameter = target->tag == "texture" || target->tag == "volume" ||
                                 (target->tag == "medium" && node.tag == "shape");
    std::string name = is_by_parameter ? scene_name : "";
    if (is_scene) name = id.empty() ? scene_name : id;
    // An object with several references keeps its name.
    const bool is_free = used.insert(name).second || (is_scene && name == id);
    parts.push_back({is_free ? std::move(name) : "", scene_name, target});
  });
  std::map<std::string, int> counts;
  for (PartOfNode& part : parts) {
    while (part.name.empty()) {
      std::string name = numbered(part.node->tag, counts[part.node->tag]++);
      const Node* const other = is_scene ? builder.with_id(name) : nullptr;
      if ((!other || other == part.node) && used.insert(name).second) part.name = std::move(name);
    }
  }
  return parts;
}

}  // namespace

ObjectPaths::ObjectPaths(const Node& root, const Builder& builder)
    : root_(root), builder_(builder) {
  add_names(root);
  for (const PartOfNode& part : parts_of(root, builder)) visit(*part.node, part.name);
}

void ObjectPaths::visit(const Node& node, const std::string& path) {
  if (!builder_.made_of(node) || !known_.insert(&node).second) return;
  all_.push_back({unused_path(path, node), &node});
  listed_.emplace(all_.back().path, &node);
  const std::string own = all_.back().path;
  add_names(node);
  for (const PartOfNode& part : parts_of(node, builder_)) {
    const std::string id = part.node->value("id");
    visit(*part.node, id.empty() ? own + "." + part.name : id);
  }
}

/// Adds a number to `path` if it is ambiguous: names and ids may have dots, so that "a.b" may be an
/// id, or the object b in a.
std::string ObjectPaths::unused_path(const std::string& path, const Node& node) const {
  for (int i = 0;; ++i) {
    std::string wanted = numbered(path, i);
    const Node* const named = builder_.with_id(wanted);
    if (!listed_.count(wanted) && (!named || named == &node)) return wanted;
  }
}

void ObjectPaths::add_names(const Node& node) {
  Names& names = names_[&node];
  const std::vector<PartOfNode> parts = parts_of(node, builder_);
  for (const PartOfNode& part : parts) names.emplace(part.name, part.node);
  int bsdfs = 0;
  for (const PartOfNode& part : parts) {
    if (!part.scene_name.empty()) names.emplace(part.scene_name, part.node);
    // Mitsuba's names.
    if (part.node->tag == "medium" && node.tag == "shape") {
      names.emplace(part.name + "_medium", part.node);
    }
    if (part.node->tag == "phase" && node.tag == "medium") {
      names.emplace("phase_function", part.node);
    }
    // Mitsuba has these names in mask, bumpmap and normalmap.
    if (node.tag == "bsdf") names.emplace("nested_" + part.node->tag, part.node);
    if (part.node->tag != "bsdf" || node.tag != "bsdf") continue;
    for (const char* const name : {"bsdf_", "brdf_"}) {
      names.emplace(name + std::to_string(bsdfs), part.node);
    }
    ++bsdfs;
  }
}

const Node* ObjectPaths::find(const Node& from, std::string_view path) const {
  if (path.empty()) return &from;
  const auto names = names_.find(&from);
  for (size_t end = path.size(); end != std::string_view::npos && end > 0;
       end = path.rfind('.', end - 1)) {
    const std::string_view name = path.substr(0, end);
    const std::string_view rest = end == path.size() ? "" : path.substr(end + 1);
    const Node* named = nullptr;
    if (names != names_.end()) {
      const auto found = names->second.find(name);
      if (found != names->second.end()) named = found->second;
    }
    if (!named && &from == &root_) named = builder_.with_id(std::string(name));
    const Node* const found = named ? find(*named, rest) : nullptr;
    if (found) return found;
  }
  return nullptr;
}

const Node* ObjectPaths::listed(const std::string& path) const {
  const auto found = listed_.find(path);
  return found == listed_.end() ? nullptr : found->second;
}

const Node* ObjectPaths::object(const std::string& path) const {
  const Node* const node = listed(path);
  return node ? node : find(root_, path);
}

std::vector<std::pair<const Node*, std::string>> ObjectPaths::candidates(
    const std::string& path) const {
  std::vector<std::pair<const Node*, std::string>> found;
  for (size_t end = path.rfind('.'); end != std::string::npos && end > 0;
       end = path.rfind('.', end - 1)) {
    const Node* const node = object(path.substr(0, end));
    if (node) found.emplace_back(node, path.substr(end + 1));
  }
  return found;
}

}  // namespace kinome::loader
