#pragma once

#include "kinome/render_job.h"
#include "kinome/scene.h"
#include "kinome/scheduler.h"

namespace kinome {

/// Services that an integrator needs besides the scene. They form one object because an integrator
/// passes them to most of its functions, and because a further service then changes no signatures.
/// Functions that need only one service take only that one.
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
