#pragma once

#include "kinome/render_context.h"
#include "kinome/sensor.h"
#include "numbers.h"
#include "occlusion.h"

namespace kinome::transport {

/// Points that are connected to the camera: what each of a block would add to the picture, and the
/// shadow ray to the lens that finds out whether it does. One per thread.
class Splats {
 public:
  Splats(const Sensor& sensor, size_t points);

  /// Points of the lens, for `count` points of the samples `owner`: by `dimension` of the sampler
  /// and the next one.
  void choose_lens(const PixelSamples& samples, const uint32_t* owner, size_t count,
                   uint32_t dimension, Numbers& numbers);
  /// How the camera sees points first … first + count - 1 of the columns p, `first` being a
  /// multiple of 16.
  void connect(const Columns3& p, size_t first, size_t count);
  const ConnectionBlock& seen() const { return connection_; }
  /// What each of them adds; to be set where its ray is on.
  const Columns3& value() const { return value_; }
  Ray16* rays() { return rays_; }
  /// Traces `count` rays, all of which are set, and adds to the picture what arrives: in the order
  /// of the points.
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
