#include "session/film_sums.h"

#include <algorithm>

namespace kinome {

std::vector<FilmSums> sums_of(Film& film, const std::vector<bool>& with_splats,
                              uint64_t** non_finite) {
  // The kinds of data that Film::transfer() passes, in its order.
  enum class Next {
    kNonFinite,
    kLanes,
    kLightPaths,
    kSize,
    kValues,
    kHasSplats,
    kSplatSize,
    kSplats
  };
  std::vector<FilmSums> sums;
  Next next = Next::kNonFinite;
  film.transfer([&](void* bytes, size_t count) {
    const std::span<double> numbers(static_cast<double*>(bytes), count / sizeof(double));
    switch (next) {
      case Next::kNonFinite:
        if (non_finite) *non_finite = static_cast<uint64_t*>(bytes);
        next = Next::kLanes;
        break;
      case Next::kLanes:
        next = Next::kLightPaths;
        break;
      case Next::kLightPaths:
        sums.push_back({numbers.data(), {}, {}});
        next = Next::kSize;
        break;
      case Next::kSize:
        next = Next::kValues;
        break;
      case Next::kValues:
        sums.back().values = numbers;
        next = Next::kHasSplats;
        break;
      case Next::kHasSplats: {
        auto& has_splats = *static_cast<uint8_t*>(bytes);
        const size_t layer = sums.size() - 1;
        if (layer < with_splats.size() && with_splats[layer]) has_splats = 1;
        next = has_splats != 0 ? Next::kSplatSize : Next::kLightPaths;
        break;
      }
      case Next::kSplatSize:
        next = Next::kSplats;
        break;
      case Next::kSplats:
        sums.back().splats = numbers;
        next = Next::kLightPaths;
        break;
    }
  });
  return sums;
}

float response_of(Film& film) {
  // Use a channel of its own, because the film's colour may be luminance.
  film.prepare({{}}, {{"response", 0, FilmChannel::kR, 1}}, 1);
  const std::vector<FilmSums> sums = sums_of(film);
  const size_t stride = sums[0].values.size() / static_cast<size_t>(film.crop().area());
  sums[0].values[0] = 1;
  sums[0].values[stride - 1] = 1;
  const Rect& crop = film.crop();
  const Image pixel = film.develop({crop.x0, crop.y0, crop.x0 + 1, crop.y0 + 1});
  film.prepare({{}}, {}, 1);
  return pixel.data.back();
}

}  // namespace kinome
