#pragma once

#include <optional>

#include "kinome/export.h"
#include "kinome/math.h"

namespace kinome {

/// The place of a camera at `origin`, as <lookat> gives it: it looks along +z of the result, +x is
/// left, +y up. nullopt where `up`, of any length, is parallel to the viewing direction. `origin`
/// and `target` must not be the same point.
KINOME_EXPORT std::optional<glm::dmat4> look_at(const Vec3& origin, const Vec3& target,
                                                const Vec3& up);

}  // namespace kinome
