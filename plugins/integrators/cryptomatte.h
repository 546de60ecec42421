#pragma once

#include <functional>
#include <string>
#include <vector>

#include "kinome/cryptomatte.h"
#include "kinome/render_context.h"
#include "kinome/scene.h"
#include "kinome/sensor.h"

namespace kinome {

/// Renders Cryptomatte layers. A pixel's coverage by an id is the sum of the filter's weights of
/// samples that hit it, divided by the sum of all weights. Samples that hit nothing belong to no
/// id.
///
/// An average of ids is meaningless. The values of a pixel are therefore computed once, in the
/// first pass, from a set of samples that doesn't depend on the seed, so that the parts of an image
/// have the same values.
class Cryptomatte {
 public:
  /// Renders these kinds, with `levels` ids per pixel, from `samples` camera rays per pixel, or
  /// fewer in half of the remaining time. 0: as many as the image has samples, between 4 and 16, or
  /// at most 16 in a tenth of the remaining time.
  Cryptomatte(std::vector<CryptomatteKind> kinds, int levels, uint32_t samples);

  bool is_empty() const { return kinds_.empty(); }
  /// Names of the channels of all kinds.
  std::vector<std::string> channels() const;
  /// Sets the values of a film layer, unless all pixels have them already.
  void render(const Scene& scene, const Sensor& sensor, RenderContext& context, int layer) const;

 private:
  /// Returns the number of camera rays per pixel. `seconds_of_sample` measures the time of one.
  uint32_t sample_count(const Sensor& sensor, RenderContext& context,
                        const std::function<double()>& seconds_of_sample) const;

  /// Maximum share of the remaining time of a render with a time limit.
  double share_of_time() const;

  std::vector<CryptomatteKind> kinds_;
  int levels_;
  uint32_t samples_;
};

}  // namespace kinome
