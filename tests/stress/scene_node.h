#pragma once

#include <string>
#include <utility>
#include <vector>

/// A scene as a tree, so that parts of it can be taken out again.
namespace kinome::test {

struct SceneNode {
  std::string tag;
  std::vector<std::pair<std::string, std::string>> attributes;
  std::vector<SceneNode> children;

  SceneNode() = default;
  SceneNode(std::string t, std::vector<std::pair<std::string, std::string>> a,
            std::vector<SceneNode> c = {})
      : tag(std::move(t)), attributes(std::move(a)), children(std::move(c)) {}
  /// XML, indented by `depth` levels.
  std::string text(int depth = 0) const;
};

/// Every node below `root` but itself, parents first, as indices from child to child.
using NodePath = std::vector<size_t>;
std::vector<NodePath> paths_of(const SceneNode& root);
SceneNode& node_at(SceneNode& root, const NodePath& path);

}  // namespace kinome::test
