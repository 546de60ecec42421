#include "picture/display.h"

#include <algorithm>
#include <cmath>

#include "kinome/error.h"

namespace kinome::viewer {

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
