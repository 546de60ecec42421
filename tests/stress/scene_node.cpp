#include "scene_node.h"

namespace kinome::test {
namespace {

std::string escaped(const std::string& value) {
  std::string text;
  for (const char c : value) {
    switch (c) {
      case '&':
        text += "&amp;";
        break;
      case '<':
        text += "&lt;";
        break;
      case '"':
        text += "&quot;";
        break;
      default:
        text += c;
    }
  }
  return text;
}

void add_paths(const SceneNode& node, NodePath& at, std::vector<NodePath>& paths) {
  for (size_t i = 0; i < node.children.size(); ++i) {
    at.push_back(i);
    paths.push_back(at);
    add_paths(node.children[i], at, paths);
    at.pop_back();
  }
}

}  // namespace

std::string SceneNode::text(int depth) const {
  const std::string indent(static_cast<size_t>(2 * depth), ' ');
  std::string text = indent + "<" + tag;
  for (const auto& [name, value] : attributes) text += " " + name + "=\"" + escaped(value) + "\"";
  if (children.empty()) return text + "/>\n";
  text += ">\n";
  for (const SceneNode& child : children) text += child.text(depth + 1);
  return text + indent + "</" + tag + ">\n";
}

std::vector<NodePath> paths_of(const SceneNode& root) {
  std::vector<NodePath> paths;
  NodePath at;
  add_paths(root, at, paths);
  return paths;
}

SceneNode& node_at(SceneNode& root, const NodePath& path) {
  SceneNode* node = &root;
  for (const size_t i : path) node = &node->children.at(i);
  return *node;
}

}  // namespace kinome::test
