#pragma once

#include "kinome/parameter.h"

/// Parameter rows of integrators that show surfaces, not light.
namespace kinome {

inline constexpr Parameter kIgnoredHideEmitters = ignored_row(
    "hide_emitters", ParameterType::kBoolean,
    "this integrator treats emitters like other surfaces; set it in the one that renders light");

}  // namespace kinome
