#pragma once

#include <cstdint>
#include <functional>

#include "kinome/render_context.h"

namespace kinome {

/// How a film comes to its samples.
struct RenderWay {
  uint32_t lanes = 1;                      ///< that the film is prepared with
  std::function<void()> render = nullptr;  ///< fills it; tells RenderStats::samples
  /// Of a picture that is interrupted: pixels without samples get one, or are marked.
  bool fills_gaps = true;
};

/// What all renders have in common: the film is made ready and developed, with checkpoints,
/// warnings and statistics.
Image render_by(const RenderWay& way, const Scene& scene, const Sensor& sensor,
                RenderContext& context);

}  // namespace kinome
