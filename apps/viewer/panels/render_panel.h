#pragma once

#include <chrono>
#include <deque>

#include "panels/panel.h"

namespace kinome::viewer {

/// Progress of the render, choice of the integrator, pause, restart, and a render with a given
/// number of samples.
class RenderPanel final : public Panel {
 public:
  const char* title() const override { return "Render"; }
  bool is_open_at_first() const override { return true; }
  void draw(Frame& frame) override;

 private:
  void draw_numbers(const Frame& frame);
  void draw_integrators(Frame& frame);
  double pictures_per_second(const Picture& picture);

  int samples_ = 64;
  std::deque<std::chrono::steady_clock::time_point> seen_;
  uint64_t seen_generation_ = 0;
};

}  // namespace kinome::viewer
