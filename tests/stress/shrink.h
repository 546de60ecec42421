#pragma once

#include <string>

#include "check.h"
#include "scene_node.h"

namespace kinome::test {

/// A smaller scene that shows the same finding, its files being in `folder`; the same where there
/// is none to be found in some seconds. `is_valid`: whether `scene` is.
SceneNode shrink(const SceneNode& scene, const Finding& finding, bool is_valid,
                 const std::string& folder);

}  // namespace kinome::test
