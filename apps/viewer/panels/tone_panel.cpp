#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "panels/panel.h"
#include "panels/picture_overlay.h"
#include "panels/widgets.h"
#include "picture/display.h"
#include "picture/histogram.h"

namespace kinome::viewer {
namespace {

constexpr size_t kMaxBadPixels = 4;
constexpr float kHistogramHeight = 84;
constexpr ImU32 kChannelColors[] = {IM_COL32(255, 70, 60, 150), IM_COL32(60, 220, 70, 150),
                                    IM_COL32(80, 130, 255, 150)};

std::string range_text(const ChannelHistogram& h) {
  char text[96];
  std::snprintf(text, sizeof text, "%.3g to %.3g, mean %.3g", static_cast<double>(h.lowest),
                static_cast<double>(h.highest), h.mean);
  return text;
}

/// Returns the range of bins that aren't empty, with one more on each side.
std::pair<int, int> used_bins(const std::vector<ChannelHistogram>& all) {
  int first = ChannelHistogram::kBins, last = -1;
  for (const ChannelHistogram& h : all) {
    for (int i = 0; i < ChannelHistogram::kBins; ++i) {
      if (h.counts[i] == 0) continue;
      first = std::min(first, i);
      last = std::max(last, i);
    }
  }
  if (last < 0) return {0, ChannelHistogram::kBins};
  return {std::max(0, first - 1), std::min(ChannelHistogram::kBins, last + 2)};
}

/// Tone mapping: exposure, curve and channel, with a histogram and the values of the pixel under
/// the mouse. When zoomed in, draws its values into each pixel.
class TonePanel final : public Panel {
 public:
  explicit TonePanel(std::shared_ptr<Display> display) : display_(std::move(display)) {}
  const char* title() const override { return "Tone"; }

  void draw(Frame& frame) override {
    if (!frame.picture) return ImGui::TextDisabled("no picture yet");
    const Image& image = frame.picture->image;
    bool has_changed = draw_curve(image);
    has_changed |= draw_channels(image);
    has_changed |= draw_range(image);
    has_changed |= ImGui::Checkbox("mark NaN, infinite", &display_->tone.marks);
    ImGui::SameLine();
    has_changed |= ImGui::Checkbox("negative", &display_->tone.marks_negative);
    if (ImGui::IsItemHovered()) {
      ImGui::SetTooltip("Some are correct: those of control variates and of filters");
    }
    if (has_changed) frame.view.refresh();
    draw_histogram(*frame.picture);
    draw_bad_pixels(frame);
    draw_values(frame);
  }

  void draw_over_picture(Frame& frame) override {
    if (!has_tone_) {
      has_tone_ = true;
      frame.view.set_tone([display = display_](const Picture& picture, std::vector<uint8_t>& rgba) {
        display->map(picture.image, rgba);
      });
    }
    if (!frame.picture) return;
    draw_pixel_values(*frame.picture, frame.view.area(), display_->tone);
    if (display_->shown != Shown::kDifference && display_->tone.curve == Curve::kFalseColor) {
      const std::string& group = display_->tone.group;
      draw_color_legend(frame.view.area(), display_->tone,
                        group == "colour" ? "luminance" : group.c_str());
    }
  }

 private:
  void fit_range(const Image& image, bool is_logarithmic) {
    Tone& tone = display_->tone;
    tone.range = range_of(image, group_named(image, tone.group), is_logarithmic);
  }

  bool draw_curve(const Image& image) {
    Tone& tone = display_->tone;
    const Curve before = tone.curve;
    for (const Curve curve : {Curve::kSrgb, Curve::kFilmic, Curve::kFalseColor}) {
      if (curve != Curve::kSrgb) ImGui::SameLine();
      if (ImGui::RadioButton(to_string(curve), tone.curve == curve)) tone.curve = curve;
    }
    bool has_changed = tone.curve != before;
    if (has_changed && tone.curve == Curve::kFalseColor) fit_range(image, true);
    if (tone.curve == Curve::kFalseColor) return has_changed;
    has_changed |= ImGui::SliderFloat("exposure", &tone.exposure, -10, 10, "%.2f stops");
    if (ImGui::IsItemHovered())
      ImGui::SetTooltip("Each stop doubles the light; Ctrl-click to type");
    ImGui::SameLine();
    if (ImGui::SmallButton("0")) {
      tone.exposure = 0;
      has_changed = true;
    }
    return has_changed;
  }

  bool draw_channels(const Image& image) {
    Tone& tone = display_->tone;
    std::vector<std::string> names;
    for (const ChannelGroup& group : channel_groups(image)) names.push_back(group.name);
    const auto chosen = choose("channel", group_named(image, tone.group).name, names);
    if (!chosen) return false;
    tone.group = names[*chosen];
    if (tone.curve == Curve::kFalseColor) fit_range(image, tone.range.is_logarithmic);
    return true;
  }

  bool draw_range(const Image& image) {
    Tone& tone = display_->tone;
    if (tone.curve != Curve::kFalseColor) return false;
    bool has_changed = false;
    for (const Map map : kMaps) {
      if (map != kMaps[0]) ImGui::SameLine();
      if (!ImGui::RadioButton(to_string(map), tone.map == map)) continue;
      tone.map = map;
      has_changed = true;
    }
    bool fits = ImGui::Checkbox("logarithmic", &tone.range.is_logarithmic);
    ImGui::SameLine();
    fits |= ImGui::SmallButton("fit");
    if (fits) fit_range(image, tone.range.is_logarithmic);
    has_changed |= fits;
    const float speed = 0.01f * std::max(1e-6f, std::abs(tone.range.high - tone.range.low));
    if (ImGui::DragFloatRange2("range", &tone.range.low, &tone.range.high, speed, 0, 0, "%.4g")) {
      if (tone.range.is_logarithmic) tone.range.low = std::max(tone.range.low, 1e-8f);
      tone.range.high = std::max(tone.range.high, std::nextafter(tone.range.low, INFINITY));
      has_changed = true;
    }
    return has_changed;
  }

  void draw_histogram(const Picture& picture) {
    if (picture.generation != generation_ || !(display_->tone == histogram_tone_)) {
      const ChannelGroup group = group_named(picture.image, display_->tone.group);
      histograms_ = histograms(picture.image, group, display_->tone.exposure);
      bad_pixels_ = bad_pixels(picture.image, group, kMaxBadPixels);
      generation_ = picture.generation;
      histogram_tone_ = display_->tone;
    }
    draw_bars();
    draw_shares(picture);
  }

  /// Draws the histograms of all channels, and a line at white.
  void draw_bars() {
    const ImVec2 corner = ImGui::GetCursorScreenPos();
    const float width = ImGui::GetContentRegionAvail().x;
    ImDrawList* const list = ImGui::GetWindowDrawList();
    list->AddRectFilled(corner, {corner.x + width, corner.y + kHistogramHeight},
                        IM_COL32(20, 20, 20, 255));
    const auto [first, end] = used_bins(histograms_);
    uint32_t max_count = 1;
    for (const ChannelHistogram& h : histograms_) {
      max_count = std::max(max_count, *std::max_element(h.counts.begin(), h.counts.end()));
    }
    const float step = width / static_cast<float>(end - first);
    for (size_t c = 0; c < histograms_.size(); ++c) {
      const ImU32 color =
          histograms_.size() == 1 ? IM_COL32(200, 200, 200, 220) : kChannelColors[c];
      for (int i = first; i < end; ++i) {
        const float share =
            std::sqrt(static_cast<float>(histograms_[c].counts[i]) / static_cast<float>(max_count));
        const float left = corner.x + step * static_cast<float>(i - first);
        list->AddRectFilled({left, corner.y + kHistogramHeight * (1 - share)},
                            {left + step, corner.y + kHistogramHeight}, color);
      }
    }
    // Position of white at this exposure.
    const float white =
        ChannelHistogram::kBinsPerStop * (-display_->tone.exposure - ChannelHistogram::kFirstStop);
    const float x = corner.x + step * (white - static_cast<float>(first));
    if (x >= corner.x && x <= corner.x + width) {
      list->AddLine({x, corner.y}, {x, corner.y + kHistogramHeight}, IM_COL32(255, 255, 255, 160));
    }
    ImGui::InvisibleButton("histogram", {width, kHistogramHeight});
    if (ImGui::IsItemHovered()) {
      const float bin = static_cast<float>(first) + (ImGui::GetMousePos().x - corner.x) / step;
      ImGui::SetTooltip("%.3g\nlogarithmic; heights by square roots; the line is white",
                        static_cast<double>(std::exp2(ChannelHistogram::kFirstStop +
                                                      bin / ChannelHistogram::kBinsPerStop)));
    }
  }

  /// Draws the range of each channel, and the shares of pixels outside of the displayed range.
  void draw_shares(const Picture& picture) {
    const double pixels =
        std::max<double>(1, static_cast<double>(picture.image.width) * picture.image.height);
    const ChannelGroup group = group_named(picture.image, display_->tone.group);
    for (size_t c = 0; c < histograms_.size(); ++c) {
      const ChannelHistogram& h = histograms_[c];
      const char* const name = picture.image.channels[group.index[c]].c_str();
      ImGui::TextUnformatted((std::string(name) + ": " + range_text(h)).c_str());
      if (ImGui::IsItemHovered()) {
        ImGui::SetTooltip(
            "over-exposed: %u\nunder-exposed: %u\nzero: %u\nnegative: %u\n"
            "infinite: %u\nNaN: %u",
            h.overexposed, h.underexposed, h.zeros, h.negative, h.infinite, h.nan);
      }
      ImGui::TextDisabled("  over-exposed %.2f %%, under-exposed %.2f %%",
                          100 * h.overexposed / pixels, 100 * h.underexposed / pixels);
    }
  }

  void draw_bad_pixels(Frame& frame) {
    uint32_t nan = 0, infinite = 0, negative = 0;
    for (const ChannelHistogram& h : histograms_) {
      nan += h.nan;
      infinite += h.infinite;
      negative += h.negative;
    }
    if (nan + infinite + negative == 0) return;
    const ImVec4 color =
        nan + infinite > 0 ? ImVec4(1, 0.45f, 0.4f, 1) : ImVec4(0.8f, 0.8f, 0.5f, 1);
    std::string text;
    for (const auto& [count, noun] : {std::pair(nan, "NaN value"),
                                      std::pair(infinite, "infinite value"),
                                      std::pair(negative, "negative value")}) {
      if (count > 0) text += (text.empty() ? "" : ", ") + counted(count, noun);
    }
    ImGui::TextColored(color, "%s", text.c_str());
    for (const BadPixel& pixel : bad_pixels_) {
      ImGui::Text("  %d, %d: %s %g", pixel.x + frame.picture->crop.x0,
                  pixel.y + frame.picture->crop.y0, pixel.channel.c_str(),
                  static_cast<double>(pixel.value));
    }
  }

  /// Draws the values of the pixel under the mouse. The height is constant, so that nothing below
  /// jumps as the mouse moves.
  void draw_values(const Frame& frame) {
    const ImVec2 mouse = ImGui::GetMousePos();
    const PictureArea& area = frame.view.area();
    const bool is_over = mouse.x >= area.low.x && mouse.x < area.high.x;
    const Vec2 film = area.to_film({mouse.x, mouse.y});
    const auto pixel = is_over ? pixel_at(*frame.picture, area, film) : std::nullopt;
    if (!pixel) {
      ImGui::TextDisabled("values of the pixel under the mouse");
      ImGui::NewLine();
      return;
    }
    const Image& image = frame.picture->image;
    const ChannelGroup group = group_named(image, display_->tone.group);
    std::string values;
    for (int c = 0; c < group.count; ++c) {
      char text[32];
      std::snprintf(text, sizeof text, "%s%.5g", c == 0 ? "" : "  ",
                    static_cast<double>(image.at(pixel->x, pixel->y, group.index[c])));
      values += text;
    }
    ImGui::Text("pixel %d, %d: %s", static_cast<int>(std::floor(film.x)),
                static_cast<int>(std::floor(film.y)), group.name.c_str());
    ImGui::TextUnformatted(values.c_str());
  }

  std::shared_ptr<Display> display_;
  bool has_tone_ = false;  ///< the view uses display_
  /// Image and tone of the histograms.
  uint64_t generation_ = 0;
  Tone histogram_tone_;
  std::vector<ChannelHistogram> histograms_;
  std::vector<BadPixel> bad_pixels_;
};

}  // namespace

std::unique_ptr<Panel> make_tone_panel(std::shared_ptr<Display> display) {
  return std::make_unique<TonePanel>(std::move(display));
}

}  // namespace kinome::viewer
