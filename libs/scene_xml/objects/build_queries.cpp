// Queries about a scene's nodes and objects after it was built.

#include <functional>

#include "base/file_search.h"
#include "scene_xml/objects/build.h"
#include "scene_xml/values/convert.h"

namespace kinome::loader {

const Node* Builder::resolved(const Node& node) const {
  return node.tag == "ref" ? with_id(node.value("id")) : &node;
}

const Node* Builder::with_id(const std::string& id) const {
  const auto found = ids_.find(unaliased(expansion_.aliases, id));
  return found == ids_.end() ? nullptr : found->second;
}

std::optional<Properties::Value> Builder::written(const Node& node, const Parameter& row) {
  for (const Node& child : node.children) {
    if (!is_object(child) && child.value("name") == row.name) {
      return convert(child, &row, *folders(child));
    }
  }
  return std::nullopt;
}

std::string Builder::file_of(const Node& node, const std::string& name) {
  try {
    return find_file(name, *folders(node), node.where);
  } catch (const Error&) {
    return "";
  }
}

std::map<const Node*, std::vector<const Node*>> Builder::holders() const {
  std::map<const Node*, std::vector<const Node*>> all;
  const std::function<void(const Node&)> visit = [&](const Node& node) {
    for_each_part(node, [&](const Node& child) {
      if (!is_object(child)) return;
      if (const Node* const part = resolved(child)) all[part].push_back(&node);
      visit(child);
    });
  };
  visit(expansion_.root);
  return all;
}

void Builder::forget_gone() {
  std::set<const Node*> current;
  const std::function<void(const Node&)> visit = [&](const Node& node) {
    current.insert(&node);
    for_each_part(node, visit);
  };
  visit(expansion_.root);
  std::erase_if(objects_, [&](const auto& made) { return !current.count(made.first); });
}

std::shared_ptr<Object> Builder::made_of(const Node& node) const {
  const auto found = objects_.find(&node);
  return found == objects_.end() ? nullptr : found->second;
}

}  // namespace kinome::loader
