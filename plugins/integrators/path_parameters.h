#pragma once

#include <limits>
#include <string>

#include "kinome/properties.h"

/// What integrators over whole paths have in common.
namespace kinome {

/// Rows of a parameter table.
#define KINOME_PATH_PARAMETERS                                                                  \
  {"max_depth", ParameterType::kInteger, "-1",                                                  \
   "Longest path, in edges: 1 is emission alone, 2 direct light, 3 one bounce; -1: no limit."}, \
  {                                                                                             \
    "rr_depth", ParameterType::kInteger, "5",                                                   \
        "Russian roulette ends paths from this many surface points on."                         \
  }

/// How long paths get.
struct PathLength {
  uint32_t max_depth = 0;  ///< edges
  uint32_t rr_depth = 0;   ///< surface points

  explicit PathLength(const Properties& props) {
    const int64_t depth = props.integer("max_depth");
    if (depth < -1 || depth == 0) {
      throw props.error("max_depth",
                        "must be positive, or -1 for no limit, got " + std::to_string(depth));
    }
    const int64_t roulette = props.integer("rr_depth");
    if (roulette < 1) {
      throw props.error("rr_depth", "must be positive, got " + std::to_string(roulette));
    }
    constexpr int64_t kMost = std::numeric_limits<uint32_t>::max() / 2;
    max_depth = static_cast<uint32_t>(depth < 0 ? kMost : std::min(depth, kMost));
    rr_depth = static_cast<uint32_t>(std::min(roulette, kMost));
  }
};

/// With what probability Russian roulette lets a path go on; 0 only where it carries nothing.
inline float survival_probability(const Rgb& throughput) {
  return std::min(max_component(throughput), 0.95f);
}

}  // namespace kinome
