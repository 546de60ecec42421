#pragma once

#include <cstdint>
#include <vector>

namespace kinome {

/// Light points chosen for one shading point: points[k] of the set has the weight weights[k].
struct PointSelection {
  std::vector<uint32_t> points;
  std::vector<float> weights;
  void clear() {
    points.clear();
    weights.clear();
  }
};

}  // namespace kinome
