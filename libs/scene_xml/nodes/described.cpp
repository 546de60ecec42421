// Converts a program's description of a scene to the nodes that its text would have.

#include "scene_xml/nodes/node.h"

namespace kinome::loader {
namespace {

class DescriptionConverter {
 public:
  explicit DescriptionConverter(Faults& faults) : faults_(faults) {}

  Node node_of(const ObjectDescription& description, const Node* parent) {
    Node node;
    node.tag = description.tag;
    node.where = description.where;
    const bool is_value = description.tag == "spectrum";
    const auto add = [&](const char* name, const std::string& value) {
      if (!value.empty()) node.attributes.push_back({name, value, description.where});
    };
    add(is_value ? "value" : "type", description.type);
    add("id", description.id);
    if (!parent || parent->tag != "scene") add("name", description.name);
    node.is_broken = !check_node(node, parent, faults_);
    if (description.tag != "ref" && !description.id.empty() &&
        !ids_.insert(description.id).second) {
      faults_.add(description.where, "the id '" + description.id + "' is given twice");
    }
    node.overrides = node.described = description.values;
    for (const ObjectDescription& part : description.parts)
      node.children.push_back(node_of(part, &node));
    return node;
  }

 private:
  Faults& faults_;
  std::set<std::string> ids_;
};

}  // namespace

Node node_of(const ObjectDescription& description, Faults& faults, const Node* parent) {
  return DescriptionConverter(faults).node_of(description, parent);
}

}  // namespace kinome::loader
