#include "spoil.h"

#include <string>

namespace kinome::test {

void spoil(SceneNode& root, Dice& dice) {
  const auto paths = paths_of(root);
  for (int attempt = 0; attempt < 20; ++attempt) {
    const NodePath& path = dice.of(paths);
    SceneNode& node = node_at(root, path);
    if (dice.chance(0.15)) {
      NodePath parent(path.begin(), path.end() - 1);
      auto& siblings = node_at(root, parent).children;
      const auto at = siblings.begin() + static_cast<std::ptrdiff_t>(path.back());
      if (dice.chance(0.5)) {
        siblings.erase(at);
      } else {
        siblings.push_back(SceneNode(*at));
      }
      return;
    }
    for (auto& [name, value] : node.attributes) {
      if (name == "name" || (name == "type" && !dice.chance(0.1))) continue;
      if (dice.chance(0.5)) continue;
      value = dice.of<std::string>({"nan", "inf", "-1", "0", "1e38", "1e-45", "-1e30", "1e30",
                                     "", "abc", "1e400", "0 0 0", "1 2", "99999999999", "true",
                                     "1e-20", "-0", "../x"});
      return;
    }
  }
}

}  // namespace kinome::test
