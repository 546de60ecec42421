#pragma once

#include <limits>
#include <string>

#include "kinome/color.h"
#include "kinome/properties.h"
#include "kinome/wide/vectors.h"

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

inline constexpr uint32_t kNoMaxDepth = std::numeric_limits<uint32_t>::max() / 2;

/// `max_depth` as Mitsuba takes it: edges, where 0 leaves a black picture; -1 is kNoMaxDepth.
inline uint32_t read_max_depth(const Properties& props) {
  const int64_t depth = props.integer("max_depth");
  if (depth < -1) {
    throw props.error("max_depth",
                      "must not be negative, but for -1, no limit; got " + std::to_string(depth));
  }
  return depth < 0 ? kNoMaxDepth : static_cast<uint32_t>(std::min<int64_t>(depth, kNoMaxDepth));
}

/// How long paths get.
struct PathLength {
  uint32_t max_depth = kNoMaxDepth;  ///< edges
  uint32_t rr_depth = 5;             ///< surface points

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

/// What `path` is asked for.
struct PathSettings {
  PathLength length;
  bool hide_emitters = false;
};

/// With what probability Russian roulette lets a path go on; 0 only where it carries nothing. V is
/// Rgb, or a vector of such (wide::Rgb).
template <class V>
wide::NumberOf<V> survival_probability(const V& throughput) {
  using namespace wide::formulas;
  return min(max_component(throughput), wide::NumberOf<V>(0.95f));
}

}  // namespace kinome
