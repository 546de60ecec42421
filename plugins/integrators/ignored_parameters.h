#pragma once

#include "kinome/parameter.h"

/// Parameter rows of integrators that show surfaces, not light.
namespace kinome {

inline constexpr Parameter kIgnoredHideEmitters = ignored_row(
    "hide_emitters", ParameterType::kBoolean, "emitters are surfaces here; give it to the integrator "
                                              "that renders their light");

}  // namespace kinome
