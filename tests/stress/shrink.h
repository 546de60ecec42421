#pragma once

#include <string>

#include "check.h"
#include "scene_node.h"

namespace kinome::test {

/// Searches for a smaller scene with the same finding, for some seconds. Returns the smallest one
/// found, or `scene` itself. The scenes' files are in `folder`. `is_valid`: see RandomScene.
SceneNode shrink(const SceneNode& scene, const Finding& finding, bool is_valid,
                 const std::string& folder);

}  // namespace kinome::test
