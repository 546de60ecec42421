// The part of BlockRenderer that adds a block to the film.
#include <algorithm>
#include <array>

#include "clustered/product/pass/block_renderer.h"
#include "transport/film_samples.h"

namespace kinome {
namespace {

/// Maximum number of a pixel's samples that are added in one call.
constexpr uint32_t kMaxSamples = 1024;

}  // namespace

void BlockRenderer::Samples::clear() {
  for (auto* const column : {&x, &y, &alpha}) column->clear();
}

void BlockRenderer::Samples::add(const Vec2& position, float alpha_of_sample) {
  x.push_back(position.x);
  y.push_back(position.y);
  alpha.push_back(alpha_of_sample);
}

void BlockRenderer::add_to(FilmTile& colours, float weight) const {
  if (is_split()) {
    add_samples(colours, weight);
    return;
  }
  const size_t values = view_.primaries.sensor.film().has_alpha() ? 4 : 3;
  for (size_t i = 0; i < pixels_.size(); ++i) {
    const Rgb c = colour(i);
    const std::array<float, 4> pixel{c.x, c.y, c.z, pixels_[i].alpha};
    colours.add_pixel(pixels_[i].x, pixels_[i].y, {pixel.data(), values}, weight);
  }
}

void BlockRenderer::add_samples(FilmTile& colours, float weight) const {
  const Film& film = view_.primaries.sensor.film();
  const size_t values = film.has_alpha() ? 4 : 3;
  transport::FilmSamples film_samples(film.filter(), static_cast<int>(values), kMaxSamples);
  std::array<Column<float>, 6> columns;
  for (auto& column : columns) column.resize(padded(kMaxSamples) + kBlockLanes);
  auto& [r, g, b, alpha, x, y] = columns;
  std::vector<float*> of_sample{r.data(), g.data(), b.data(), alpha.data()};
  of_sample.resize(values);
  for (const Pixel& pixel : pixels_) {
    for (uint32_t begin = 0; begin < pixel.samples; begin += kMaxSamples) {
      const uint32_t count = std::min(kMaxSamples, pixel.samples - begin);
      const size_t first = pixel.first + begin;
      for (uint32_t k = 0; k < count; ++k) {
        const Rgb& c = sums_[first + k];
        r[k] = c.x, g[k] = c.y, b[k] = c.z;
      }
      std::copy_n(&samples_.alpha[first], count, alpha.begin());
      std::copy_n(&samples_.x[first], count, x.begin());
      std::copy_n(&samples_.y[first], count, y.begin());
      const auto px = static_cast<uint32_t>(pixel.x), py = static_cast<uint32_t>(pixel.y);
      film_samples.add({&px, &py, 1, 0, count, 0}, {x.data(), y.data()}, of_sample, colours,
                       weight / static_cast<float>(pixel.samples));
    }
  }
}

}  // namespace kinome
