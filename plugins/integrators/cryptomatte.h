#pragma once

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
/// An average of ids is meaningless. The values of a pixel are therefore computed from a fixed set
/// of samples, which neither the seed nor the pass changes, so that every pass has the same values.
class Cryptomatte {
 public:
  /// Renders these kinds, with `levels` ids per pixel, from `samples` camera rays per pixel.
  Cryptomatte(std::vector<CryptomatteKind> kinds, int levels, uint32_t samples);

  bool is_empty() const { return kinds_.empty(); }
  /// Names of the channels of all kinds.
  std::vector<std::string> channels() const;
  /// Sets the values of a film layer, unless all pixels have them already.
  void render(const Scene& scene, const Sensor& sensor, RenderContext& context, int layer) const;

 private:
  std::vector<CryptomatteKind> kinds_;
  int levels_;
  uint32_t samples_;
};

}  // namespace kinome
