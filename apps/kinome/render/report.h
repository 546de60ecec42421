#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "kinome/stage_threads.h"
#include "kinome/stats.h"

namespace kinome::app {

/// Fields of a report that RenderStats doesn't have.
struct RenderSummary {
  std::string scene;
  std::string output;
  std::string integrator;
  int width = 0;
  int height = 0;
  int x = 0, y = 0;                     ///< position of the image in the film
  int full_width = 0, full_height = 0;  ///< of the film
  unsigned samples = 0;                 ///< per pixel, rounded
  uint64_t seed = 0;
  std::vector<StageThreads> stage_threads = {};  ///< empty if no timeline was recorded
};

/// Formats a report for reading.
std::string stats_text(const RenderStats& stats, const RenderSummary& summary);
/// Formats a report as one JSON object on one line.
std::string stats_json(const RenderStats& stats, const RenderSummary& summary);

}  // namespace kinome::app
