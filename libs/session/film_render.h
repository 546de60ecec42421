#pragma once

#include <cstdint>
#include <functional>

#include "kinome/render_context.h"

namespace kinome {

/// Describes how a film is filled with samples.
struct FilmRender {
  uint32_t lanes = 1;                      ///< number of lanes of the film
  std::function<void()> render = nullptr;  ///< fills the film, and sets RenderStats::samples
  /// After an interrupt, adds a sample to pixels that have none, or marks them (see fill_gaps.h).
  bool fills_gaps = true;
};

/// Runs a render: prepares the film, calls how.render(), and develops the image. Also handles
/// checkpoints, repeated warnings and statistics.
Image run_film_render(const FilmRender& how, const Scene& scene, const Sensor& sensor,
                      RenderContext& context);

}  // namespace kinome
