#pragma once

#include <cstdint>
#include <vector>

namespace kinome {

/// Light points chosen for one shading point: point i of the set counts weights[k] times.
struct PointSelection {
  std::vector<uint32_t> points;
  std::vector<float> weights;
  void clear() {
    points.clear();
    weights.clear();
  }
};

}  // namespace kinome
