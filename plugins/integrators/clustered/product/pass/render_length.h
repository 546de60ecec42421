#pragma once

#include "clustered/product/tiles/product_sampling.h"
#include "kinome/math.h"
#include "kinome/render_context.h"
#include "kinome/sensor.h"

namespace kinome {

/// Mean number of rays per pixel of a render, and its time limit in seconds (infinity if there is
/// none).
struct RenderLength {
  double rays_per_pixel = 0;
  double seconds = kInfinity;
};

/// Rays per second and thread of product sampling in most scenes.
inline constexpr double kCarefulSpeed = 1e6;

/// Returns the expected length of a render with these settings. `seconds` as for Integrator::begin.
RenderLength expected_length(const ProductSettings& settings, const Sensor& sensor,
                             const RenderContext& context, double seconds);

}  // namespace kinome
