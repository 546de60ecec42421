#pragma once

#include "kinome/primary_rays.h"

/// Stages that several integrators share.
namespace kinome {

inline constexpr Stage kBounceStage{"bounce", "traces rays from surfaces"};
inline constexpr Stage kShadeStage{"shade", "samples directions and computes light"};
inline constexpr Stage kShadowStage{"shadow", "traces shadow rays"};

/// Returns `stage` as a part of the stage `whole`.
constexpr Stage part_of(const char* whole, Stage stage) {
  stage.within = whole;
  return stage;
}

}  // namespace kinome
