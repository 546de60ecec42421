#include "session/preview_denoiser.h"

#include "session/live_render.h"

namespace kinome::viewer {
namespace {

/// Copies three channels, beginning with the one of this name.
std::vector<float> three_channels(const Image& image, const char* first) {
  const auto channel = static_cast<size_t>(image.find_channel(first));
  const size_t stride = image.channels.size();
  std::vector<float> values;
  values.reserve(image.data.size() / stride * 3);
  for (size_t at = channel; at < image.data.size(); at += stride) {
    values.insert(values.end(), &image.data[at], &image.data[at] + 3);
  }
  return values;
}

}  // namespace

PreviewDenoiser::PreviewDenoiser(unsigned threads) : denoiser_(open_image_denoise(threads)) {}

std::shared_ptr<const Scene> PreviewDenoiser::guides_of(SceneEditor& editor) {
  ObjectDescription description;
  description.tag = "integrator";
  description.type = "aov";
  description.where = Location{"preview"};
  description.values.push_back(
      {"aovs", std::string("albedo:guide_albedo,normal:guide_normal"), description.where});
  return editor.scene_with(description);
}

bool PreviewDenoiser::denoise(Image& image, const Scene& guides, const Sensor& sensor,
                              RenderContext& context) const {
  const RenderStats stats = context.job.stats();  // those of the colour
  const std::optional<Image> guide = render_once(guides, sensor, context);
  context.job.stats() = stats;
  if (!guide) return false;
  const std::vector<float> denoised = denoiser_({.width = image.width,
                                                 .height = image.height,
                                                 .color = three_channels(image, "R"),
                                                 .albedo = three_channels(*guide, "albedo.R"),
                                                 .normal = three_channels(*guide, "normal.X")});
  const size_t stride = image.channels.size(), color = static_cast<size_t>(image.find_channel("R"));
  for (size_t p = 0; 3 * p < denoised.size(); ++p) {
    std::copy_n(&denoised[3 * p], 3, &image.data[p * stride + color]);
  }
  return true;
}

}  // namespace kinome::viewer
