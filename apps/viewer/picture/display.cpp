#include "picture/display.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "kinome/error.h"
#include "kinome/image_files.h"
#include "kinome/read_files.h"

namespace kinome::viewer {
namespace {

const std::string kColor = "colour", kLuminance = "luminance";

/// Returns the colour group, or a group without channels if there is none.
ChannelGroup colors_of(const Image& image) {
  const ChannelGroup group = group_named(image, kColor);
  return group.name == kColor || group.name == kLuminance ? group
                                                          : ChannelGroup{"", {-1, -1, -1}, 0};
}

ChannelGroup variance_of(const Image& image, const ChannelGroup& colors) {
  const std::string name = colors.count == 1 ? "variance.Y" : "variance";
  const ChannelGroup group = group_named(image, name);
  return group.name == name ? group : ChannelGroup{"", {-1, -1, -1}, 0};
}

Rgb color_at(const Image& image, const ChannelGroup& group, int x, int y) {
  Rgb color;
  for (int c = 0; c < 3; ++c) color[c] = image.at(x, y, group.index[std::min(c, group.count - 1)]);
  return color;
}

/// Returns 0.01 times the square of the mean of the counted values; 1, for absolute errors, if the
/// mean is 0.
double floor_of(const Image& image, const ChannelGroup& colors, const std::vector<bool>& counts) {
  double sum = 0;
  size_t count = 0;
  for (size_t i = 0; i < counts.size(); ++i) {
    if (!counts[i]) continue;
    for (int c = 0; c < colors.count; ++c) {
      sum += image.data[i * image.channels.size() + colors.index[c]];
      ++count;
    }
  }
  const double mean = count > 0 ? sum / static_cast<double>(count) : 0;
  return mean != 0 ? 0.01 * mean * mean : 1;
}

/// Returns the values of fn for the colours of an image's pixels, or for black if it has none.
template <class Fn>
LinearPicture picture_of(const Image& image, const Fn& fn) {
  const ChannelGroup colors = colors_of(image);
  LinearPicture picture{image.width, image.height, {}};
  picture.pixels.reserve(static_cast<size_t>(image.width) * image.height);
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      picture.pixels.push_back(fn(colors.count > 0 ? color_at(image, colors, x, y) : Rgb(0.f)));
    }
  }
  return picture;
}

/// Replaces non-finite and negative values by 0.
LinearPicture radiance_of(const Image& image) {
  return picture_of(
      image, [](const Rgb& color) { return is_finite(color) ? glm::max(color, 0.f) : Rgb(0.f); });
}

}  // namespace

const char* to_string(Difference difference) {
  constexpr const char* kNames[] = {"signed", "relative", "FLIP", "HDR-FLIP"};
  return kNames[static_cast<int>(difference)];
}

Reference::Reference(const std::string& path) : Reference(read_exr(path), path) {
  record_read_file(path);
}

Reference::Reference(Image image, std::string name)
    : name_(std::move(name)), image_(std::move(image)) {
  colors_ = colors_of(image_);
  if (colors_.count == 0) {
    throw Error(fmt::format("'{}' must have the channels R, G and B, or Y", name_));
  }
  variance_ = variance_of(image_, colors_);
}

void Reference::check(const Image& picture) const {
  if (picture.width != image_.width || picture.height != image_.height) {
    throw Error(fmt::format("the picture has {}x{} pixels, but '{}' has {}x{}", picture.width,
                            picture.height, name_, image_.width, image_.height));
  }
  if (colors_of(picture).count != colors_.count) {
    throw Error(fmt::format("the picture doesn't have the same colour channels as '{}'", name_));
  }
}

std::vector<bool> Reference::counted(const Image& picture) const {
  const ChannelGroup colors = colors_of(picture);
  std::vector<bool> counts;
  counts.reserve(static_cast<size_t>(picture.width) * picture.height);
  for (int y = 0; y < picture.height; ++y) {
    for (int x = 0; x < picture.width; ++x) {
      counts.push_back(is_finite(color_at(picture, colors, x, y)) &&
                       is_finite(color_at(image_, colors_, x, y)) &&
                       (variance_.count == 0 || is_finite(color_at(image_, variance_, x, y))));
    }
  }
  return counts;
}

PictureErrors Reference::errors_of(const Image& picture) const {
  check(picture);
  const ChannelGroup colors = colors_of(picture);
  const std::vector<bool> counts = counted(picture);
  const double floor = floor_of(image_, colors_, counts);
  PictureErrors errors;
  double sum = 0;
  size_t count = 0;
  for (size_t i = 0; i < counts.size(); ++i) {
    if (!counts[i]) {
      ++errors.left_out;
      continue;
    }
    const float* shown = picture.data.data() + i * picture.channels.size();
    const float* right = image_.data.data() + i * image_.channels.size();
    for (int c = 0; c < colors.count; ++c) {
      const double r = right[colors_.index[c]], d = shown[colors.index[c]] - r;
      const double variance = variance_.count > 0 ? right[variance_.index[c]] : 0;
      const double error = (d * d - variance) / (r * r + floor);
      sum += error;
      errors.largest = count == 0 ? error : std::max(errors.largest, error);
      ++count;
    }
  }
  errors.rel_mse = count > 0 ? sum / static_cast<double>(count) : 0;
  return errors;
}

Image Reference::difference_of(const Image& picture, Difference kind, const Tone& tone) const {
  check(picture);
  if (kind == Difference::kFlip) {
    const Curve curve = tone.curve == Curve::kFilmic ? Curve::kFilmic : Curve::kSrgb;
    const Flip flip(displayed_picture(image_, tone.exposure, curve));
    return {picture.width,
            picture.height,
            {"Y"},
            flip.differences(displayed_picture(picture, tone.exposure, curve))};
  }
  if (kind == Difference::kHdrFlip) {
    return {
        picture.width, picture.height, {"Y"}, hdr_flip(radiance_of(image_), radiance_of(picture))};
  }
  const ChannelGroup colors = colors_of(picture);
  const double floor =
      kind == Difference::kRelative ? floor_of(image_, colors_, counted(picture)) : 0;
  Image result{picture.width, picture.height, {"Y"}, {}};
  if (colors.count == 3) result.channels = {"R", "G", "B"};
  const size_t pixels = static_cast<size_t>(picture.width) * picture.height;
  result.data.reserve(pixels * colors.count);
  for (size_t i = 0; i < pixels; ++i) {
    const float* shown = picture.data.data() + i * picture.channels.size();
    const float* right = image_.data.data() + i * image_.channels.size();
    for (int c = 0; c < colors.count; ++c) {
      const double r = right[colors_.index[c]];
      double d = shown[colors.index[c]] - r;
      if (kind == Difference::kRelative) d /= std::sqrt(r * r + floor);
      result.data.push_back(static_cast<float>(d));
    }
  }
  return result;
}

Tone tone_of(Difference kind, float range) {
  Tone tone;
  const bool is_flip = kind == Difference::kFlip || kind == Difference::kHdrFlip;
  tone.curve = is_flip ? Curve::kFalseColor : Curve::kSigned;
  tone.range = {0, is_flip ? 1 : range, false};
  return tone;
}

LinearPicture displayed_picture(const Image& image, float exposure, Curve curve) {
  return picture_of(image, [&](const Rgb& color) { return displayed(color, exposure, curve); });
}

std::vector<uint8_t> split_view(const ToneMapper& mapper, const Image& left, const Image& right,
                                int split) {
  const int width = left.width, height = left.height;
  std::vector<uint8_t> out(static_cast<size_t>(width) * height * 4);
  if (out.empty()) return out;
  const int column = std::clamp(split, 0, width);
  const size_t stride = 4 * static_cast<size_t>(width);
  mapper.map(left, {0, 0, column, height}, out.data(), stride);
  mapper.map(right, {column, 0, width, height}, out.data() + 4 * static_cast<size_t>(column),
             stride);
  return out;
}

void Display::map(const Image& picture, std::vector<uint8_t>& rgba) const {
  const ToneMapper mapper(tone);
  const auto has_size_of = [&](const Image& other) {
    return other.width == picture.width && other.height == picture.height;
  };
  if (!reference || shown == Shown::kPicture) {
    rgba = mapper.map(picture);
  } else if (shown == Shown::kDifference) {
    const bool is_there = difference && has_size_of(*difference);
    rgba = is_there ? ToneMapper(difference_tone).map(*difference) : mapper.map(picture);
  } else {
    const Image& right = reference->image();
    const Image other =
        has_size_of(right) ? Image{} : resampled(right, picture.width, picture.height);
    const int column =
        shown == Shown::kReference
            ? 0
            : static_cast<int>(std::lround(split * static_cast<float>(picture.width)));
    rgba = split_view(mapper, picture, has_size_of(right) ? right : other, column);
  }
}

Image resampled(const Image& image, int width, int height) {
  Image made{width, height, image.channels, {}};
  made.data.reserve(static_cast<size_t>(width) * height * image.channels.size());
  for (int y = 0; y < height; ++y) {
    const size_t from_y = (2 * static_cast<size_t>(y) + 1) * image.height / (2 * height);
    for (int x = 0; x < width; ++x) {
      const size_t from_x = (2 * static_cast<size_t>(x) + 1) * image.width / (2 * width);
      const auto pixel =
          image.data.begin() +
          static_cast<ptrdiff_t>((from_y * image.width + from_x) * image.channels.size());
      made.data.insert(made.data.end(), pixel, pixel + image.channel_count());
    }
  }
  return made;
}

Comparison compare(const Image& picture, const Reference& reference, Difference kind,
                   const Tone& tone) {
  Comparison found;
  try {
    found.errors = reference.errors_of(picture);
    auto flip =
        std::make_shared<const Image>(reference.difference_of(picture, Difference::kFlip, tone));
    found.flip = mean_of(flip->data);
    found.difference =
        kind == Difference::kFlip
            ? std::move(flip)
            : std::make_shared<const Image>(reference.difference_of(picture, kind, tone));
  } catch (const std::exception& fault) {
    found.fault = fault.what();
  }
  return found;
}

}  // namespace kinome::viewer
