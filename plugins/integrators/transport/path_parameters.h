#pragma once

#include <limits>
#include <string>

#include "kinome/color.h"
#include "kinome/properties.h"
#include "kinome/wide/vectors.h"

/// Parameters and formulas that path tracing and light tracing share.
namespace kinome {

/// Rows of a plugin's parameter table.
#define KINOME_PATH_PARAMETERS                                                                  \
  {"max_depth", ParameterType::kInteger, "-1",                                                  \
   "Maximum edges of a path: 1 is emission alone, 2 direct light, 3 one bounce; -1: no limit."}, \
  {                                                                                             \
    "rr_depth", ParameterType::kInteger, "5",                                                   \
        "Russian roulette ends paths from this many surface points on."                         \
  }

inline constexpr uint32_t kNoMaxDepth = std::numeric_limits<uint32_t>::max() / 2;

/// Reads `max_depth` with Mitsuba's meaning: a number of edges. 0 renders a black image; -1 returns
/// kNoMaxDepth.
inline uint32_t read_max_depth(const Properties& props) {
  const int64_t depth = props.integer("max_depth");
  if (depth < -1) {
    throw props.error("max_depth",
                      "must be -1 (no limit) or at least 0, got " + std::to_string(depth));
  }
  return depth < 0 ? kNoMaxDepth : static_cast<uint32_t>(std::min<int64_t>(depth, kNoMaxDepth));
}

/// Limits on the length of paths.
struct PathLength {
  uint32_t max_depth = kNoMaxDepth;  ///< number of edges
  uint32_t rr_depth = 5;             ///< first surface point with Russian roulette, counted from 1

  PathLength() = default;
  PathLength(uint32_t edges, uint32_t roulette_from)
      : max_depth(edges), rr_depth(roulette_from) {}
  explicit PathLength(const Properties& props) : max_depth(read_max_depth(props)) {
    const int64_t roulette = props.integer("rr_depth");
    if (roulette < 1) {
      throw props.error("rr_depth", "must be positive, got " + std::to_string(roulette));
    }
    rr_depth = static_cast<uint32_t>(std::min<int64_t>(roulette, kNoMaxDepth));
  }
};

/// Settings of `path`.
struct PathSettings {
  PathLength length;
  bool hide_emitters = false;
};

/// Returns the probability that a path survives Russian roulette; 0 only if its throughput is 0.
/// V is Rgb or wide::Rgb.
template <class V>
wide::NumberOf<V> survival_probability(const V& throughput) {
  using namespace wide::formulas;
  return min(max_component(throughput), wide::NumberOf<V>(0.95f));
}

}  // namespace kinome
