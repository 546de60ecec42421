#pragma once

#include <string>

#include "check.h"
#include "scene_node.h"

namespace kinome::test {

/// Returns a smaller scene with the same finding, whose files are in `folder`, or the same scene if
/// none is found within some seconds. `is_valid`: see RandomScene.
SceneNode shrink(const SceneNode& scene, const Finding& finding, bool is_valid,
                 const std::string& folder);

}  // namespace kinome::test
