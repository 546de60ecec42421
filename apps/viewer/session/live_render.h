#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "kinome/integrator.h"
#include "kinome/render_context.h"
#include "kinome/scene.h"
#include "session/picture.h"

namespace kinome::viewer {

/// Renders the sensor's samples. The result is bit-identical to kinome::render() without a budget.
/// Returns nullopt if the render is interrupted.
std::optional<Image> render_once(const Scene& scene, const Sensor& sensor, RenderContext& context);

/// A progressive render, which improves with each pass. The passes go to different lanes of the
/// film (see FilmNoise), from which the error is estimated. The scene, sensor and context must
/// outlive it.
class LiveRender {
 public:
  using ImageCallback = std::function<void(Image image)>;

  /// The render has at most `max_samples` samples per pixel.
  LiveRender(const Scene& scene, const Sensor& sensor, RenderContext& context, double max_samples);

  /// Renders a pass: of one sample per pixel, then of eight, later of at most twice the samples so
  /// far. A pass takes some seconds at most, unless a single sample takes longer. Renders only the
  /// tiles that overlap `region` once the whole image has four samples. Returns false if it was
  /// interrupted; is_whole() then says whether the image is still valid. Calls `on_image` about
  /// once a second with the image so far, which includes finished tiles of the pass; not in the
  /// first pass. These calls come from any thread, one at a time, and must not use this object.
  bool pass(const std::optional<Rect>& region = std::nullopt,
            const ImageCallback& on_image = nullptr);
  /// Returns false if some pixels lack samples. Don't add passes then.
  bool is_whole() const { return is_whole_; }
  /// Returns true if is_whole() is true even if the pass after this image is interrupted.
  static bool survives_interruption(const Picture& picture);
  Image develop() const;
  /// Samples per pixel; in the region of the last pass, if it had one.
  double samples() const { return in_all_ + in_region_; }
  double seconds() const { return seconds_; }
  /// Estimated relMSE; -1 before the end of four passes, or if a region has more samples. Estimates
  /// it anew only if that takes a small fraction of the rendering time since the last estimate.
  /// Otherwise scales the last estimate by the number of samples.
  double rel_mse();

 private:
  double samples_of_next_pass() const;

  RenderContext& context_;
  Film& film_;
  const double max_samples_;
  std::unique_ptr<Passes> passes_;
  std::vector<double> lane_samples_;
  std::optional<Rect> region_;         ///< of the last pass
  double in_all_ = 0, in_region_ = 0;  ///< samples of all pixels, and additional ones of the region
  double seconds_ = 0;
  double last_seconds_ = 0, last_work_ = 0;  ///< time and samples of all pixels of the last pass
  uint64_t pass_ = 0;
  bool is_whole_ = true;
  bool is_even_ = true;  ///< no region has more samples
  double sample_error_ = -1;      ///< last estimate of the relMSE of one sample per pixel; -1 if none
  double estimate_seconds_ = 0;   ///< time of the last estimate
  double estimated_seconds_ = 0;  ///< seconds_ at the last estimate
};

}  // namespace kinome::viewer
