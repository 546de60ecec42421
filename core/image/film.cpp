// Films: what tiles' samples become, by lanes, and the pictures that are developed from them.

#include "image/film_pixels.h"

#include <limits>
#include <stdexcept>

#include <fmt/format.h>

#include "kinome/error.h"

namespace kinome {
namespace {

/// Rect::area() is an int. The plugin of a film may know which parameter is at fault; this is for
/// those that don't ask.
void check_size(const Rect& crop) {
  constexpr int64_t kMost = std::numeric_limits<int>::max();
  if (int64_t{crop.width()} * crop.height() <= kMost) return;
  throw Error(
      fmt::format("the film renders {} x {} pixels: no more than {} can be rendered at once",
                  crop.width(), crop.height(), kMost));
}

}  // namespace

void Film::prepare(const std::vector<std::vector<std::string>>& layers, uint32_t lanes) {
  check_size(crop_);
  non_finite_ = 0;
  commits_ = 0;
  layers_ = layers;
  lane_ = 0;
  lanes_.clear();
  lanes_.resize(lanes);
  for (Lane& lane : lanes_) {
    for (size_t i = 0; i < layers_.size(); ++i) {
      const size_t stride = static_cast<size_t>(value_count(static_cast<int>(i))) + 1;
      lane.layers.emplace_back(static_cast<size_t>(crop_.area()) * stride);
    }
  }
}

Rect Film::reach() const {
  const int border = static_cast<int>(std::ceil(filter_->radius() - 0.5f));
  return {crop_.x0 - border, crop_.y0 - border, crop_.x1 + border, crop_.y1 + border};
}

std::vector<std::string> Film::channels() const {
  std::vector<std::string> names;
  if (is_luminance_) {
    names = {"Y"};
  } else {
    names = {"R", "G", "B"};
  }
  if (has_alpha_) names.push_back("A");
  for (const auto& layer : layers_) names.insert(names.end(), layer.begin(), layer.end());
  return names;
}

int Film::value_count(int layer) const {
  const int extra = static_cast<int>(layers_.at(layer).size());
  return layer == 0 ? 3 + (has_alpha_ ? 1 : 0) + extra : extra;
}

FilmTile Film::make_tile(const Rect& pixels, int layer) const {
  return FilmTile(pixels, layer, value_count(layer), *filter_, crop_);
}

void Film::commit(const FilmTile& tile) {
  ++commits_;
  non_finite_ += tile.non_finite_;
  lanes_.at(lane_).light_paths += tile.light_paths_;
  if (!tile.splats_.empty()) commit_splats(tile);
  const int stride = tile.values_ + 1;
  const Rect& covered = tile.covered_;
  if (covered.area() == 0) return;
  ZeroedArray<double>& data = lanes_.at(lane_).layers.at(tile.layer_);
  for (int y = covered.y0; y < covered.y1; ++y) {
    const double* from = &tile.data_[pixel_offset(covered, covered.x0, y, stride)];
    double* to = &data[pixel_offset(crop_, covered.x0, y, stride)];
    const int count = covered.width() * stride;
    for (int i = 0; i < count; ++i) to[i] += from[i];
  }
}

ZeroedArray<double>& Film::splats_of(Lane& lane) {
  if (lane.splats.empty()) {
    lane.splats = ZeroedArray<double>(static_cast<size_t>(crop_.area()) * 3);
    // A pixel's weighted mean divides by the filter's integral over its samples; a splat has to.
    splat_norm_ = 1 / (filter_->integral() * filter_->integral());
  }
  return lane.splats;
}

void Film::commit_splats(const FilmTile& tile) {
  ZeroedArray<double>& splats = splats_of(lanes_.at(lane_));
  for (const FilmTile::Splat& splat : tile.splats_) {
    for_each_pixel(splat.position, *filter_, crop_, [&](int x, int y, float w) {
      double* const pixel = &splats[pixel_offset(crop_, x, y, 3)];
      for (int i = 0; i < 3; ++i) pixel[i] += w * splat_norm_ * splat.value[i];
    });
  }
}

bool Film::transfer(const std::function<void(void* bytes, size_t count)>& io) {
  const auto is_alike = [&](uint64_t count) {
    uint64_t found = count;
    io(&found, sizeof found);
    return found == count;
  };
  const auto transfer_sums = [&](ZeroedArray<double>& sums) {
    if (!is_alike(sums.size())) return false;
    io(sums.data(), sums.size() * sizeof(double));
    return true;
  };
  io(&non_finite_, sizeof non_finite_);
  if (!is_alike(lanes_.size())) return false;
  for (Lane& lane : lanes_) {
    io(&lane.light_paths, sizeof lane.light_paths);
    for (auto& layer : lane.layers) {
      if (!transfer_sums(layer)) return false;
    }
    uint8_t has_splats = lane.splats.empty() ? 0 : 1;
    io(&has_splats, sizeof has_splats);
    if (has_splats != 0 && !transfer_sums(splats_of(lane))) return false;
  }
  return true;
}

std::vector<bool> Film::gaps(int layer) const {
  const size_t stride = static_cast<size_t>(value_count(layer)) + 1;
  std::vector<bool> gaps(static_cast<size_t>(crop_.area()), true);
  bool is_empty = true, has_paths = false;
  for (const Lane& lane : lanes_) {
    has_paths = has_paths || (layer == 0 && lane.light_paths > 0);
    const ZeroedArray<double>& data = lane.layers.at(layer);
    for (size_t p = 0; p < gaps.size(); ++p) {
      if (data[(p + 1) * stride - 1] == 0) continue;
      gaps[p] = false;
      is_empty = false;
    }
  }
  if (is_empty && has_paths) gaps.assign(gaps.size(), false);
  return gaps;
}

double Film::splat_scale(size_t first, size_t end) const {
  double paths = 0;
  for (size_t l = first; l < end; ++l) paths += lanes_[l].light_paths;
  return paths > 0 ? 1 / paths : 1;
}

Rgb Film::color(size_t pixel, size_t first, size_t end) const {
  const int values = value_count(0);
  glm::dvec3 sum(0.), splats(0.);
  double weight = 0;
  for (size_t l = first; l < end; ++l) {
    const double* const from = &lanes_[l].layers[0][pixel * (values + 1)];
    sum += glm::dvec3(from[0], from[1], from[2]);
    weight += from[values];
    if (lanes_[l].splats.empty()) continue;
    for (int c = 0; c < 3; ++c) splats[c] += lanes_[l].splats[3 * pixel + c];
  }
  // Not by its inverse: a single sample of a pixel is to come out as it is.
  const glm::dvec3 radiance =
      sum / (weight == 0 ? double{kInfinity} : weight) + splats * splat_scale(first, end);
  return Rgb(radiance * double{response_});
}

Image Film::develop() const {
  Image image{crop_.width(), crop_.height(), channels(), {}};
  const size_t pixels = static_cast<size_t>(crop_.area());
  const size_t stride_out = image.channels.size();
  image.data.assign(pixels * stride_out, 0.f);
  size_t first_out = 0;
  for (size_t l = 0; l < layers_.size(); ++l) {
    const int values = value_count(static_cast<int>(l));
    const bool to_luminance = l == 0 && is_luminance_;
    for (size_t p = 0; p < pixels; ++p) {
      float* to = &image.data[p * stride_out + first_out];
      int i = 0;
      if (l == 0) {
        const Rgb mean = color(p, 0, lanes_.size());
        if (to_luminance) {
          *to++ = luminance(mean);
        } else {
          for (int c = 0; c < 3; ++c) *to++ = mean[c];
        }
        i = 3;
      }
      for (; i < values; ++i) {
        double sum = 0, weight = 0;
        for (const Lane& lane : lanes_) {
          sum += lane.layers[l][p * (values + 1) + i];
          weight += lane.layers[l][p * (values + 1) + values];
        }
        *to++ = weight == 0 ? 0.f : static_cast<float>(sum / weight);
      }
    }
    first_out += to_luminance ? values - 2 : values;
  }
  return image;
}

std::optional<Rgb> Film::lane_color(size_t pixel, uint32_t lane) const {
  const size_t stride = static_cast<size_t>(value_count(0)) + 1;
  const Lane& from = lanes_.at(lane);
  if (from.layers[0][(pixel + 1) * stride - 1] == 0 && from.light_paths == 0) return std::nullopt;
  const Rgb mean = color(pixel, lane, lane + 1);
  return is_luminance_ ? Rgb(luminance(mean)) : mean;
}

}  // namespace kinome
