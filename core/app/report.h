#pragma once

#include <cstdint>
#include <string>

#include "kinome/stats.h"

namespace kinome::app {

/// What a report says beside the stats.
struct RenderSummary {
  std::string scene;
  std::string output;
  std::string integrator;
  int width = 0;
  int height = 0;
  unsigned samples = 0;  ///< a pixel, about
  uint64_t seed = 0;
};

/// For people.
std::string stats_text(const RenderStats& stats, const RenderSummary& summary);
/// One JSON object on one line.
std::string stats_json(const RenderStats& stats, const RenderSummary& summary);

}  // namespace kinome::app
