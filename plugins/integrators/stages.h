#pragma once

#include "kinome/primary_rays.h"

/// Stages that several integrators have.
namespace kinome {

inline constexpr Stage kBounceStage{"bounce", "traces rays on from surfaces"};
inline constexpr Stage kShadeStage{"shade", "draws directions and computes light"};
inline constexpr Stage kShadowStage{"shadow", "finds out what hides the light"};

/// `stage` as a part of another.
constexpr Stage part_of(const char* whole, Stage stage) {
  stage.within = whole;
  return stage;
}

}  // namespace kinome
