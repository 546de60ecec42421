#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

#include "kinome/color.h"
#include "kinome/denoise.h"
#include "kinome/error.h"
#include "kinome/scene_loader.h"

namespace kinome {
namespace {

bool is_variance(const std::string& channel) {
  return channel.starts_with("variance.") || channel.starts_with("tile_variance.");
}

/// Indices of three channels; all equal for a luminance.
using Triple = std::array<size_t, 3>;

/// Returns the channels PREFIX + suffix. Throws Error if one is missing.
Triple channels_of(const Image& image, const std::string& prefix,
                   const std::array<const char*, 3>& suffixes) {
  Triple triple{};
  for (size_t c = 0; c < 3; ++c) {
    const std::string name = prefix + suffixes[c];
    const int channel = image.find_channel(name);
    if (channel < 0) throw Error("can't denoise an image without the channel '" + name + "'");
    triple[c] = static_cast<size_t>(channel);
  }
  return triple;
}

/// Returns the channels of a colour that the film may store as luminance.
Triple color_channels(const Image& image, const std::string& prefix = "") {
  const bool is_luminance = image.find_channel("Y") >= 0;
  return is_luminance ? channels_of(image, prefix, {"Y", "Y", "Y"})
                      : channels_of(image, prefix, {"R", "G", "B"});
}

std::vector<float> values_of(const Image& image, const Triple& channels) {
  std::vector<float> values;
  const size_t stride = image.channels.size();
  values.reserve(image.data.size() / stride * 3);
  for (size_t at = 0; at < image.data.size(); at += stride) {
    for (const size_t channel : channels) values.push_back(image.data[at + channel]);
  }
  return values;
}

/// Images whose channels are joined.
class Channels {
 public:
  /// Adds a channel with the values first, first + stride, … of `from`.
  void add(const std::string& name, const std::vector<float>& from, size_t first, size_t stride) {
    names_.push_back(name);
    columns_.push_back({&from, first, stride});
  }
  /// Adds a colour of three values per pixel, or its luminance if `is_luminance`.
  void add_color(const std::string& prefix, const std::vector<float>& rgb, bool is_luminance) {
    if (is_luminance) {
      std::vector<float>& grey = greys_[num_greys_++];
      for (size_t i = 0; i < rgb.size(); i += 3) {
        grey.push_back(luminance(Rgb(rgb[i], rgb[i + 1], rgb[i + 2])));
      }
      return add(prefix + "Y", grey, 0, 1);
    }
    for (size_t c = 0; c < 3; ++c) add(prefix + std::string(1, "RGB"[c]), rgb, c, 3);
  }
  /// Adds the scene's channels of an image except those of its colour.
  void add_others(const Image& image, const Triple& color, bool keeps_variance) {
    for (size_t c = 0; c < image.channels.size(); ++c) {
      const std::string name = scene_channel(image.channels[c]);
      const bool is_color = c == color[0] || c == color[1] || c == color[2];
      if (name.empty() || is_color || (is_variance(name) && !keeps_variance)) continue;
      add(name, image.data, c, image.channels.size());
    }
  }
  Image join(int width, int height) const {
    const size_t pixels = static_cast<size_t>(width) * static_cast<size_t>(height);
    Image image{width, height, names_, {}};
    image.data.reserve(pixels * columns_.size());
    for (size_t p = 0; p < pixels; ++p) {
      for (const Column& column : columns_) {
        image.data.push_back((*column.values)[column.first + p * column.stride]);
      }
    }
    return image;
  }

 private:
  struct Column {
    const std::vector<float>* values;
    size_t first, stride;
  };
  std::vector<std::string> names_;
  std::vector<Column> columns_;
  std::array<std::vector<float>, 2> greys_;
  size_t num_greys_ = 0;
};

}  // namespace

std::string scene_channel(const std::string& channel) {
  const std::string nested = std::string(DenoisingSetup::kNested) + ".";
  for (const std::string prefix : {DenoisingSetup::kAlbedo, DenoisingSetup::kNormal}) {
    if (channel.starts_with(prefix + ".")) return "";
  }
  if (!channel.starts_with(nested)) return channel;
  const std::string name = channel.substr(nested.size());
  return name == "R" || name == "G" || name == "B" || name == "A" ? "" : name;
}

std::vector<float> filter_weights(const ReconstructionFilter& filter) {
  std::vector<float> weights;
  for (int i = 0; i == 0 || static_cast<float>(i) < filter.radius(); ++i) {
    weights.push_back(filter.eval(static_cast<float>(i)));
  }
  return weights;
}

void filter_pixels(Image& image, std::span<const float> weights) {
  if (weights.size() < 2 || image.data.empty()) return;
  const size_t stride = image.channels.size();
  std::vector<size_t> filtered;
  for (size_t c = 0; c < stride; ++c) {
    const std::string& name = image.channels[c];
    if (!is_variance(name) && !name.starts_with("Crypto")) filtered.push_back(c);
  }
  std::vector<double> line;
  const auto filter_lines = [&](int lines, int length, size_t line_stride, size_t pixel_stride) {
    const int reach = static_cast<int>(weights.size()) - 1;
    for (int l = 0; l < lines; ++l) {
      for (const size_t channel : filtered) {
        float* const first = &image.data[static_cast<size_t>(l) * line_stride + channel];
        line.clear();
        for (int i = 0; i < length; ++i) {
          double sum = 0, total = 0;
          for (int k = std::max(i - reach, 0); k <= std::min(i + reach, length - 1); ++k) {
            const double weight = weights[static_cast<size_t>(std::abs(k - i))];
            sum += weight * double{first[static_cast<size_t>(k) * pixel_stride]};
            total += weight;
          }
          line.push_back(total != 0 ? sum / total : 0);
        }
        for (size_t i = 0; i < line.size(); ++i) {
          first[i * pixel_stride] = static_cast<float>(line[i]);
        }
      }
    }
  };
  const size_t row = stride * static_cast<size_t>(image.width);
  filter_lines(image.height, image.width, row, stride);
  filter_lines(image.width, image.height, stride, row);
}

Image denoise_image(const Image& image, const Denoiser& denoise, const DenoiseOptions& options) {
  const Triple color = color_channels(image);
  const bool is_luminance = color[0] == color[1];
  DenoiserInput input;
  input.width = image.width;
  input.height = image.height;
  input.color = values_of(image, color);
  input.albedo = values_of(
      image, channels_of(image, std::string(DenoisingSetup::kAlbedo) + ".", {"R", "G", "B"}));
  input.normal = values_of(
      image, channels_of(image, std::string(DenoisingSetup::kNormal) + ".", {"X", "Y", "Z"}));
  std::vector<float> denoised = denoise(input);
  const bool has_variance = image.find_channel(is_luminance ? "variance.Y" : "variance.R") >= 0;
  if (has_variance) {
    denoised = combine_with_noisy(input.color, values_of(image, color_channels(image, "variance.")),
                                  denoised, image.width, image.height);
  }

  Channels channels;
  channels.add_color("", options.as_layer ? input.color : denoised, is_luminance);
  channels.add_others(image, color, options.keeps_variance);
  channels.add_color(options.as_layer ? "denoised." : "noisy.",
                     options.as_layer ? denoised : input.color, is_luminance);
  Image result = channels.join(image.width, image.height);
  filter_pixels(result, options.filter);
  return result;
}

Image image_without_guides(const Image& image, std::span<const float> filter) {
  const Triple color = color_channels(image);
  const std::vector<float> values = values_of(image, color);
  Channels channels;
  channels.add_color("", values, color[0] == color[1]);
  channels.add_others(image, color, true);
  Image result = channels.join(image.width, image.height);
  filter_pixels(result, filter);
  return result;
}

}  // namespace kinome
