#pragma once

#include <nanobind/nanobind.h>

#include <memory>

#include "kinome/image.h"
#include "kinome/render.h"

namespace kinome::python {

namespace nb = nanobind;

/// Arguments of kinome.render().
struct RenderRequest {
  std::shared_ptr<const Scene> scene;
  const Sensor* sensor = nullptr;
  uint32_t samples = 0;  ///< per pixel; 0 for the scene's
  uint64_t seed = 0;
  unsigned threads = 0;
  double seconds = 0;   ///< maximum time; 0 for no limit
  double rel_mse = 0;   ///< error to reach; 0 for no limit
  uint32_t lanes = 0;   ///< independent renders for the variance; 0 for no variance
  nb::object progress;  ///< called with the finished fraction; or None
  nb::object on_pass;   ///< called with the array, the channels' names and stats; or None
};

/// Renders in other threads. This thread waits without the interpreter's lock, and checks for
/// Ctrl-C. Ctrl-C ends the render; the result is the unfinished image, with stats.complete false.
/// If a callback or a signal handler throws, the render ends and the exception is rethrown. The
/// caller must hold the interpreter's lock.
Image render_for_python(const RenderRequest& request, RenderStats& stats);

}  // namespace kinome::python
