// From what a program says of a scene to the nodes that its text would have.

#include "loader/node.h"

namespace kinome::loader {
namespace {

class Describing {
 public:
  explicit Describing(Faults& faults) : faults_(faults) {}

  Node node_of(const ObjectDescription& said, const Node* parent) {
    Node node;
    node.tag = said.tag;
    node.where = said.where;
    const bool is_value = said.tag == "spectrum";
    const auto add = [&](const char* name, const std::string& value) {
      if (!value.empty()) node.attributes.push_back({name, value, said.where});
    };
    add(is_value ? "value" : "type", said.type);
    add("id", said.id);
    if (!parent || parent->tag != "scene") add("name", said.name);
    node.is_broken = !check_node(node, parent, faults_);
    if (said.tag != "ref" && !said.id.empty() && !ids_.insert(said.id).second) {
      faults_.add(said.where, "the id '" + said.id + "' is given twice");
    }
    node.given = node.described = said.values;
    for (const ObjectDescription& part : said.parts) node.children.push_back(node_of(part, &node));
    return node;
  }

 private:
  Faults& faults_;
  std::set<std::string> ids_;
};

}  // namespace

Node node_of(const ObjectDescription& said, Faults& faults, const Node* parent) {
  return Describing(faults).node_of(said, parent);
}

}  // namespace kinome::loader
