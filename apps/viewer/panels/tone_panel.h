#pragma once

#include <memory>
#include <vector>

#include "panels/panel.h"
#include "picture/display.h"
#include "picture/histogram.h"

namespace kinome::viewer {

/// Tone mapping: exposure, curve and channel, with a histogram and the values of the pixel under
/// the mouse. When zoomed in, draws its values into each pixel.
class TonePanel final : public Panel {
 public:
  explicit TonePanel(std::shared_ptr<Display> display) : display_(std::move(display)) {}
  const char* title() const override { return "Tone"; }
  void draw(Frame& frame) override;
  void draw_over_picture(Frame& frame) override;

 private:
  bool draw_curve(const Image& image);
  bool draw_channels(const Image& image);
  bool draw_range(const Image& image);
  void draw_histogram(const Picture& picture);
  void draw_bad_pixels(Frame& frame);
  void draw_values(const Frame& frame);

  std::shared_ptr<Display> display_;
  bool has_tone_ = false;  ///< the view uses display_
  /// Image and tone of the histograms.
  uint64_t generation_ = 0;
  Tone histogram_tone_;
  std::vector<ChannelHistogram> histograms_;
  std::vector<BadPixel> bad_pixels_;
};

}  // namespace kinome::viewer
