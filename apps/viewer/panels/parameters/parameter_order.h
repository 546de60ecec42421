#pragma once

#include <string>
#include <vector>

#include "session/render_session.h"

namespace kinome::viewer {

/// Parameters of an object in the order of the side bar.
struct OrderedParameters {
  std::vector<const SceneParameter*> usual;     ///< most frequently changed parameters first
  std::vector<const SceneParameter*> advanced;  ///< hidden at first
};

/// Returns the parameters of an object, as pointers into `info`, in the order of the side bar.
/// Leaves out unused parameters: `eta` and `k` of a conductor whose `material` is given.
OrderedParameters ordered_parameters(const SceneInfo& info, const std::string& object);

}  // namespace kinome::viewer
