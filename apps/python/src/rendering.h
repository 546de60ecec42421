#pragma once

#include <nanobind/nanobind.h>

#include <functional>
#include <memory>
#include <string>

#include "kinome/image.h"
#include "kinome/render.h"

namespace kinome::python {

namespace nb = nanobind;

/// What kinome.render() asks for.
struct RenderRequest {
  std::shared_ptr<const Scene> scene;
  const Sensor* sensor = nullptr;
  uint32_t samples = 0;  ///< 0: the scene's
  uint64_t seed = 0;
  unsigned threads = 0;
  double seconds = 0;   ///< 0: no limit
  double rel_mse = 0;   ///< 0: not asked for
  uint32_t lanes = 0;   ///< 0: no variance
  nb::object progress;  ///< called with the share that is done; or None
  nb::object on_pass;   ///< called with array, channels' names and stats; or None
};

/// Renders on other threads, while this one waits without the interpreter's lock, and looks for
/// Ctrl-C. What that leaves is the picture, with stats.complete false. Where a callback throws, or
/// a signal's handler, the render ends, and that is thrown. To be called with the lock.
Image render_for_python(const RenderRequest& request, RenderStats& stats);

}  // namespace kinome::python
