#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "kinome/integrator.h"
#include "kinome/render_context.h"
#include "kinome/scene.h"

namespace kinome::viewer {

/// Renders the sensor's samples. The result is bit-identical to kinome::render() without a budget.
/// Returns nullopt if the render is interrupted.
std::optional<Image> render_once(const Scene& scene, const Sensor& sensor, RenderContext& context);

/// A progressive render, which improves with each pass. The passes go to different lanes of the
/// film (see FilmNoise), from which the error is estimated. The scene, sensor and context must
/// outlive it.
class LiveRender {
 public:
  LiveRender(const Scene& scene, const Sensor& sensor, RenderContext& context);

  /// Renders a pass: of one sample per pixel at first, later of a quarter of the samples so far. A
  /// pass takes about a second at most, unless a single sample takes longer. Returns false if it
  /// was interrupted; is_whole() then says whether the image is still valid.
  bool pass();
  /// Returns false if the film contains a part of an interrupted pass. Don't add passes then.
  bool is_whole() const { return is_whole_; }
  Image develop() const;
  double samples() const { return done_; }  ///< per pixel
  double seconds() const { return seconds_; }
  /// Estimated relMSE; -1 if it can't be estimated yet. Estimates it anew only if that takes a small
  /// fraction of the rendering time since the last estimate. Otherwise scales the last estimate by
  /// the number of samples.
  double rel_mse();

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
  double sample_error_ = -1;      ///< last estimate of the relMSE of one sample per pixel; -1 if none
  double estimate_seconds_ = 0;   ///< time of the last estimate
  double estimated_seconds_ = 0;  ///< seconds_ at the last estimate
  std::vector<char> kept_;  ///< contents of the film before the current pass
};

}  // namespace kinome::viewer
