#pragma once

#include <algorithm>
#include <cmath>

#include "kinome/film.h"

/// Finds the pixels that a film sample contributes to.
namespace kinome {

/// Range [first, end) of pixels whose centres are in (low - radius, high + radius]. For low == high
/// == p and the box filter, it is exactly the pixel that contains p. Computed in double, so that
/// rounding near a pixel's edge doesn't add or lose a pixel.
struct Footprint {
  int first;
  int end;
};
inline Footprint footprint(double low, double high, double radius) {
  return {static_cast<int>(std::floor(low - radius + 0.5)),
          static_cast<int>(std::floor(high + radius + 0.5))};
}

inline Rect intersection(const Rect& a, const Rect& b) {
  Rect r{std::max(a.x0, b.x0), std::max(a.y0, b.y0), std::min(a.x1, b.x1), std::min(a.y1, b.y1)};
  r.x1 = std::max(r.x0, r.x1);
  r.y1 = std::max(r.y0, r.y1);
  return r;
}

inline size_t pixel_offset(const Rect& rect, int x, int y, int stride) {
  return (static_cast<size_t>(y - rect.y0) * rect.width() + (x - rect.x0)) * stride;
}

/// Calls fn(x, y, weight) for each pixel of `within` that a sample at `position` contributes to.
template <class Function>
void for_each_pixel(const Vec2& position, const ReconstructionFilter& filter, const Rect& within,
                    const Function& fn) {
  const double radius = filter.radius();
  const Footprint fx = footprint(position.x, position.x, radius);
  const Footprint fy = footprint(position.y, position.y, radius);
  const Rect reached = intersection({fx.first, fy.first, fx.end, fy.end}, within);
  for (int y = reached.y0; y < reached.y1 && reached.width() > 0; ++y) {
    const float wy = filter.eval(static_cast<float>(y + 0.5 - position.y));
    if (wy == 0) continue;
    for (int x = reached.x0; x < reached.x1; ++x) {
      fn(x, y, wy * filter.eval(static_cast<float>(x + 0.5 - position.x)));
    }
  }
}

/// Returns false for positions so large that their pixel might not fit an int.
inline bool is_on_any_film(const Vec2& position) {
  constexpr float kMaxPosition = 1e8f;
  return std::abs(position.x) < kMaxPosition && std::abs(position.y) < kMaxPosition;
}

}  // namespace kinome
