#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "kinome/integrator.h"
#include "kinome/render_context.h"

namespace kinome::viewer {

/// Renders the scene's samples, as kinome::render() does without a budget, to the bit; but where it
/// is interrupted, nothing is done to fill what is missing, and there is no picture.
std::optional<Image> render_once(const Scene& scene, const Sensor& sensor, RenderContext& context);

/// A picture that gets better for as long as passes are asked for. It goes on in lanes of the film
/// (see FilmNoise), by which its error is estimated. All that it is given must outlive it.
class LiveRender {
 public:
  LiveRender(const Scene& scene, const Sensor& sensor, RenderContext& context);

  /// Adds a pass: small ones first, of a quarter of all samples later on, and none of more than a
  /// second but for those of a single sample. False: it was interrupted; whether the picture is as
  /// it was before, is_whole() tells.
  bool pass();
  /// Nothing is left in the picture of a pass that was interrupted: further ones may be added.
  bool is_whole() const { return is_whole_; }
  Image develop() const;
  double samples() const { return done_; }  ///< a pixel
  double seconds() const { return seconds_; }
  /// As estimated; negative: there is no telling yet.
  double rel_mse() const;

 private:
  void keep_film();
  bool put_film_back();

  RenderContext& context_;
  Film& film_;
  std::unique_ptr<Passes> passes_;
  std::vector<double> lane_samples_;
  double done_ = 0;
  double seconds_ = 0;
  double last_seconds_ = 0, last_samples_ = 0;
  uint64_t pass_ = 0;
  bool is_whole_ = true;
  std::vector<char> kept_;  ///< the film, as it was before a pass
};

}  // namespace kinome::viewer
