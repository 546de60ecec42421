#pragma once

#include <string>
#include <vector>

#include "session/render_session.h"

namespace kinome::viewer {

/// Parameters of an object in the order of the side bar.
struct OrderedParameters {
  std::vector<const SceneParameter*> usual;     ///< those that users change most come first
  std::vector<const SceneParameter*> advanced;  ///< hidden at first
};

/// Orders the parameters of an object, which stay in `info`. Leaves out parameters that are unused:
/// `eta` and `k` of a conductor whose `material` is given.
OrderedParameters ordered_parameters(const SceneInfo& info, const std::string& object);

}  // namespace kinome::viewer
