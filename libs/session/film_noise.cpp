// Estimates the noise of a film's image from the differences between its lanes.
//
// The value m of a pixel is a ratio of sums over lanes, m = Σ S_l / Σ W_l. To first order, lane l
// changes it by
//
//     e_l = (S_l - m W_l) / Σ W,        Σ e_l = 0,      var m ≈ n / (n - 1) Σ e_l²
//
// (the linearised variance of a ratio estimator: Cochran, Sampling Techniques, 6.3). For lanes of
// equal weight, this is the variance of the mean of n numbers. It doesn't use the colour of a
// single lane, S_l / W_l, whose weight may be near zero for filters with negative lobes.
//
// Since e_l is linear, it can be summed over pixels. The variance of the mean of a tile or of the
// image therefore includes the covariances between pixels, which share samples and light paths.

#include "kinome/film_noise.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "kinome/color.h"

namespace kinome {
namespace {

/// Sum of e_l over some pixels, for each lane l.
class LaneSums {
 public:
  explicit LaneSums(size_t lanes) : sums_(lanes, glm::dvec3(0.)) {}
  void add_pixel(const std::vector<glm::dvec3>& shares) {
    for (size_t l = 0; l < sums_.size(); ++l) sums_[l] += shares[l];
    ++pixels_;
  }
  void add(const LaneSums& other) {
    for (size_t l = 0; l < sums_.size(); ++l) sums_[l] += other.sums_[l];
    pixels_ += other.pixels_;
  }
  /// Returns the variance of the mean over the pixels; infinity if there are none.
  glm::dvec3 variance_of_mean() const {
    if (pixels_ == 0) return glm::dvec3(kInfinity);
    glm::dvec3 squares(0.);
    for (const glm::dvec3& sum : sums_) squares += sum * sum;
    return squares / (static_cast<double>(pixels_) * static_cast<double>(pixels_));
  }

 private:
  std::vector<glm::dvec3> sums_;
  size_t pixels_ = 0;
};

void set_channels(Image& image, int x, int y, int first, int count, const glm::dvec3& values) {
  for (int c = 0; c < count; ++c) image.at(x, y, first + c) = static_cast<float>(values[c]);
}

/// Sums of all lanes of a film.
class Lanes {
 public:
  explicit Lanes(const Film& film)
      : response_(film.response()), is_luminance_(film.channels().front() == "Y") {
    for (uint32_t l = 0; l < film.lanes(); ++l) lanes_.push_back(film.lane_sums(l));
    stride_ = lanes_.front().values.size() / std::max<size_t>(1, film.crop().area());
  }
  size_t count() const { return lanes_.size(); }
  bool is_luminance() const { return is_luminance_; }
  /// Computes how far each lane shifts a pixel's colour, such that the sum of squares is the
  /// colour's variance. Returns the number of lanes with samples; the variance is unknown if it is
  /// below two.
  uint32_t shares(size_t pixel, std::vector<glm::dvec3>& shares) const;

 private:
  std::vector<ConstFilmSums> lanes_;
  size_t stride_ = 0;
  double response_;
  bool is_luminance_;
};

uint32_t Lanes::shares(size_t pixel, std::vector<glm::dvec3>& shares) const {
  const auto sum_in = [&](const ConstFilmSums& lane) {
    const double* const from = &lane.values[pixel * stride_];
    return glm::dvec3(from[0], from[1], from[2]);
  };
  const auto weight_in = [&](const ConstFilmSums& lane) {
    return lane.values[(pixel + 1) * stride_ - 1];
  };
  const auto splats_in = [&](const ConstFilmSums& lane) {
    if (lane.splats.empty()) return glm::dvec3(0.);
    const double* const from = &lane.splats[3 * pixel];
    return glm::dvec3(from[0], from[1], from[2]);
  };
  glm::dvec3 sum(0.), splats(0.);
  double weight = 0, paths = 0;
  uint32_t count = 0;
  for (const ConstFilmSums& lane : lanes_) {
    sum += sum_in(lane);
    splats += splats_in(lane);
    weight += weight_in(lane);
    paths += lane.light_paths;
    if (weight_in(lane) != 0 || lane.light_paths != 0) ++count;
  }
  if (count < 2) return count;
  const double factor = std::sqrt(count / (count - 1.));
  const auto num_lanes = static_cast<double>(lanes_.size());
  for (size_t l = 0; l < lanes_.size(); ++l) {
    const ConstFilmSums& lane = lanes_[l];
    const double part = paths > 0 ? lane.light_paths / paths : 1 / num_lanes;
    glm::dvec3 share = (splats_in(lane) - part * splats) / (paths > 0 ? paths : 1.);
    if (weight != 0) share += (sum_in(lane) - weight_in(lane) / weight * sum) / weight;
    if (is_luminance_) share = glm::dvec3(luminance(Rgb(share)));
    shares[l] = factor * response_ * share;
  }
  return count;
}

}  // namespace

FilmNoise film_noise(const Film& film) {
  const Lanes lanes(film);
  const std::vector<std::string> names = lanes.is_luminance()
                                             ? std::vector<std::string>{"Y"}
                                             : std::vector<std::string>{"R", "G", "B"};
  const auto count = static_cast<int>(names.size());
  FilmNoise noise;
  Image& image = noise.image;
  image.width = film.crop().width();
  image.height = film.crop().height();
  for (const char* layer : {"variance.", "tile_variance."}) {
    for (const std::string& name : names) image.channels.push_back(layer + name);
  }
  image.data.assign(static_cast<size_t>(film.crop().area()) * image.channels.size(), kInfinity);
  std::vector<glm::dvec3> shares(lanes.count());
  const LaneSums none(lanes.count());
  LaneSums whole = none;
  LaneSums one = none;
  for (int y0 = 0; y0 < image.height; y0 += FilmNoise::kTile) {
    for (int x0 = 0; x0 < image.width; x0 += FilmNoise::kTile) {
      const int x1 = std::min(x0 + FilmNoise::kTile, image.width);
      const int y1 = std::min(y0 + FilmNoise::kTile, image.height);
      LaneSums tile = none;
      for (int y = y0; y < y1; ++y) {
        for (int x = x0; x < x1; ++x) {
          const uint32_t n = lanes.shares(static_cast<size_t>(y) * image.width + x, shares);
          if (n < 2) continue;
          noise.renders = noise.renders == 0 ? n : std::min(noise.renders, n);
          one = none;
          one.add_pixel(shares);
          tile.add(one);
          set_channels(image, x, y, 0, count, one.variance_of_mean());
        }
      }
      whole.add(tile);
      for (int y = y0; y < y1; ++y) {
        for (int x = x0; x < x1; ++x) {
          set_channels(image, x, y, count, count, tile.variance_of_mean());
        }
      }
    }
  }
  const glm::dvec3 variance = whole.variance_of_mean();
  noise.variance_of_mean.assign(&variance.x, &variance.x + count);
  return noise;
}

Image with_channels_of(const Image& image, const Image& other) {
  const size_t pixels = static_cast<size_t>(image.width) * image.height;
  const size_t a = image.channels.size(), b = other.channels.size();
  Image joined{image.width, image.height, image.channels, {}};
  joined.channels.insert(joined.channels.end(), other.channels.begin(), other.channels.end());
  joined.data.reserve(pixels * (a + b));
  for (size_t p = 0; p < pixels; ++p) {
    joined.data.insert(joined.data.end(), &image.data[p * a], &image.data[p * a] + a);
    joined.data.insert(joined.data.end(), &other.data[p * b], &other.data[p * b] + b);
  }
  return joined;
}

}  // namespace kinome
