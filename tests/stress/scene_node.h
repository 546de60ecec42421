#pragma once

#include <string>
#include <utility>
#include <vector>

/// A scene as a tree, from which parts can be removed.
namespace kinome::test {

struct SceneNode {
  std::string tag;
  std::vector<std::pair<std::string, std::string>> attributes;
  std::vector<SceneNode> children;

  SceneNode() = default;
  SceneNode(std::string t, std::vector<std::pair<std::string, std::string>> a,
            std::vector<SceneNode> c = {})
      : tag(std::move(t)), attributes(std::move(a)), children(std::move(c)) {}
  /// Returns XML, indented by `depth` levels.
  std::string text(int depth = 0) const;
};

/// Path to a node below `root`: the index of the child at each level. paths_of() returns all of
/// them, parents first.
using NodePath = std::vector<size_t>;
std::vector<NodePath> paths_of(const SceneNode& root);
SceneNode& node_at(SceneNode& root, const NodePath& path);

}  // namespace kinome::test
