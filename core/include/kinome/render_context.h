#pragma once

#include "kinome/render_job.h"
#include "kinome/scene.h"
#include "kinome/scheduler.h"

namespace kinome {

/// Services that an integrator needs besides the scene. They are passed as one object because an
/// integrator hands them on to most of its parts, and because another service then changes no
/// plugin's functions. Code that needs only one of them takes only that one.
///
/// Create the context before loading the scene, not right before rendering: the system may take
/// milliseconds to distribute new threads over the cores.
class RenderContext {
 public:
  explicit RenderContext(RenderOptions options) : job(std::move(options)), scheduler(job) {}

  RenderJob job;
  Scheduler scheduler;
};

}  // namespace kinome
