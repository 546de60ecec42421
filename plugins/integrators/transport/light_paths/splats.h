#pragma once

#include "kinome/render_context.h"
#include "kinome/sensor.h"
#include "transport/blocks/numbers.h"
#include "transport/shadows/occlusion.h"

namespace kinome::transport {

/// Connections of a block's points to the camera: the value that each adds to the image if it is
/// visible, and the shadow ray to the lens. Not thread-safe: use one per thread.
class Splats {
 public:
  Splats(const Sensor& sensor, size_t points);

  /// Chooses a point of the lens for each of `count` points, which belong to the samples `owner`.
  /// Uses `dimension` of the sampler and the next one.
  void choose_lens(const PixelSamples& samples, const uint32_t* owner, size_t count,
                   uint32_t dimension, Numbers& numbers);
  /// Connects points first … first + count - 1 of the columns p to the camera. `first` must be a
  /// multiple of 16.
  void connect(const Columns3& p, size_t first, size_t count);
  const ConnectionBlock& seen() const { return connection_; }
  /// Value that each point adds to the image. Callers must set it for each active ray.
  const Columns3& value() const { return value_; }
  Ray16* rays() { return rays_; }
  /// Traces the first `count` rays, which must all be set. Adds the values of unoccluded rays to
  /// the image, in the order of the points.
  void trace(const Scene& scene, size_t count, Tile& tile);

 private:
  const Sensor& sensor_;
  Arena arena_;
  Columns2 aperture_;
  ConnectionBlock connection_;
  Columns3 value_;
  Ray16* rays_;
  Occlusion occlusion_;
};

}  // namespace kinome::transport
