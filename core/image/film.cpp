// Accumulates the samples of tiles in the lanes of a film, and develops images from them.

#include "image/film_data.h"
#include "image/film_pixels.h"

#include <algorithm>
#include <limits>
#include <stdexcept>

#include <fmt/format.h>

#include "kinome/error.h"

namespace kinome {
namespace {

/// Throws Error if the number of pixels doesn't fit Rect::area(), an int. Film plugins should check
/// this as well, because they know the parameter to name.
void check_size(const Rect& crop) {
  constexpr int64_t kMaxPixels = std::numeric_limits<int>::max();
  if (int64_t{crop.width()} * crop.height() <= kMaxPixels) return;
  throw Error(fmt::format("the film renders {} x {} pixels, but at most {} pixels are supported",
                          crop.width(), crop.height(), kMaxPixels));
}

}  // namespace

std::vector<FilmChannel> channels_of(const std::vector<std::vector<std::string>>& layers) {
  std::vector<FilmChannel> channels;
  for (size_t l = 0; l < layers.size(); ++l) {
    for (size_t i = 0; i < layers[l].size(); ++i) {
      channels.push_back({layers[l][i], static_cast<int>(l), static_cast<int>(i)});
    }
  }
  return channels;
}

Film::Film() : data_(std::make_unique<Data>(*this)) {}
Film::~Film() = default;

uint32_t Film::lanes() const {
  return static_cast<uint32_t>(data_->lanes.size());
}

void Film::prepare(const std::vector<std::vector<std::string>>& layers, uint32_t lanes) {
  prepare(layers, channels_of(layers), lanes);
}

void Film::prepare(const std::vector<std::vector<std::string>>& layers,
                   std::vector<FilmChannel> channels, uint32_t lanes) {
  check_size(crop_);
  non_finite_ = 0;
  commits_ = 0;
  lane_ = 0;
  first_layer_ = 0;
  data_->channels = std::move(channels);
  data_->layers.clear();
  for (const auto& names : layers) data_->layers.push_back({names, data_->layers.empty(), {}});
  takes_alpha_ = false;
  for (const FilmChannel& channel : data_->channels) {
    if (channel.value < 0) data_->layers.at(channel.layer).has_color = true;
    takes_alpha_ = takes_alpha_ || channel.value == FilmChannel::kA;
  }
  for (const FilmChannel& channel : data_->channels) {
    if (channel.power == 1) continue;
    data_->layers.at(channel.layer).powers.push_back({data_->index_of(channel), channel.power});
  }
  data_->lanes.clear();
  data_->lanes.resize(lanes);
  for (Data::Lane& lane : data_->lanes) {
    for (size_t i = 0; i < data_->layers.size(); ++i) {
      lane.emplace_back().values =
          ZeroedArray<double>(static_cast<size_t>(crop_.area()) * data_->stride_of(i));
    }
  }
}

int Film::Data::index_of(const FilmChannel& channel) const {
  if (channel.value >= 0) {
    const bool has_color = layers.at(channel.layer).has_color;
    return channel.value + (has_color ? 3 + (film.has_alpha() ? 1 : 0) : 0);
  }
  return channel.value >= FilmChannel::kX ? channel.value : channel.value - FilmChannel::kR;
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
  for (const FilmChannel& channel : data_->channels) names.push_back(channel.name);
  return names;
}

int Film::Data::values_of(size_t layer) const {
  const Layer& of = layers.at(layer);
  return static_cast<int>(of.names.size()) + (of.has_color ? 3 + (film.has_alpha() ? 1 : 0) : 0);
}

int Film::value_count(int layer) const {
  return data_->values_of(static_cast<size_t>(first_layer_ + layer));
}

bool Film::has_powers(int layer) const {
  return !data_->layers.at(first_layer_ + layer).powers.empty();
}

FilmTile Film::make_tile(const Rect& pixels, int layer) const {
  return FilmTile(pixels, first_layer_ + layer, value_count(layer), *filter_, crop_,
                  data_->layers.at(first_layer_ + layer).powers);
}

void FilmTile::transfer(const std::function<void(void* bytes, size_t count)>& io) {
  io(data_.data(), data_.size() * sizeof(double));
  uint64_t splats = splats_.size();
  io(&splats, sizeof splats);
  splats_.resize(splats);
  io(splats_.data(), splats_.size() * sizeof(Splat));
  io(&light_paths_, sizeof light_paths_);
  io(&non_finite_, sizeof non_finite_);
}

void Film::commit(const FilmTile& tile) {
  ++commits_;
  non_finite_ += tile.non_finite_;
  Data::Sums& sums = data_->lanes.at(lane_).at(tile.layer_);
  sums.light_paths += tile.light_paths_;
  if (!tile.splats_.empty()) commit_splats(tile);
  const int stride = tile.stride();
  const Rect& covered = tile.covered_;
  if (covered.area() == 0) return;
  ZeroedArray<double>& data = sums.values;
  for (int y = covered.y0; y < covered.y1; ++y) {
    const double* from = &tile.data_[pixel_offset(covered, covered.x0, y, stride)];
    double* to = &data[pixel_offset(crop_, covered.x0, y, stride)];
    const int count = covered.width() * stride;
    for (int i = 0; i < count; ++i) to[i] += from[i];
  }
}

namespace {

/// Returns, for each pixel in [begin, end) of an axis, 1 / the filter's integral over [low, high)
/// when the filter is centred at the pixel.
std::vector<double> inverse_integrals(const ReconstructionFilter& filter, int begin, int end,
                                      int low, int high) {
  std::vector<double> inverse;
  const auto margin = static_cast<int>(std::ceil(filter.radius() + 0.5f));
  const double whole = 1 / filter.integral(-filter.radius(), filter.radius());
  for (int i = begin; i < end; ++i) {
    const bool is_inside = i - low >= margin && high - i > margin;
    inverse.push_back(is_inside ? whole : 1 / filter.integral(low - i - 0.5, high - i - 0.5));
  }
  return inverse;
}

}  // namespace

ZeroedArray<double>& Film::Data::splats_of(Sums& sums) {
  if (sums.splats.empty()) {
    sums.splats = ZeroedArray<double>(static_cast<size_t>(film.crop_.area()) * 3);
    // The weighted mean of samples divides by the filter weights; splats must be divided by the
    // filter's integral instead.
    const Rect from = film.sampled();
    splat_columns = inverse_integrals(*film.filter_, film.crop_.x0, film.crop_.x1, from.x0, from.x1);
    splat_rows = inverse_integrals(*film.filter_, film.crop_.y0, film.crop_.y1, from.y0, from.y1);
  }
  return sums.splats;
}

void Film::commit_splats(const FilmTile& tile) {
  ZeroedArray<double>& splats = data_->splats_of(data_->lanes.at(lane_).at(tile.layer_));
  const Rect from = sampled();
  for (const FilmTile::Splat& splat : tile.splats_) {
    const Vec2& p = splat.position;
    if (p.x < static_cast<float>(from.x0) || p.x >= static_cast<float>(from.x1) ||
        p.y < static_cast<float>(from.y0) || p.y >= static_cast<float>(from.y1)) {
      continue;
    }
    for_each_pixel(splat.position, *filter_, crop_, [&](int x, int y, float w) {
      double* const pixel = &splats[pixel_offset(crop_, x, y, 3)];
      const double weight = w * data_->splat_columns[x - crop_.x0] * data_->splat_rows[y - crop_.y0];
      for (int i = 0; i < 3; ++i) pixel[i] += weight * splat.value[i];
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
  if (!is_alike(data_->lanes.size())) return false;
  for (Data::Lane& lane : data_->lanes) {
    for (Data::Sums& sums : lane) {
      io(&sums.light_paths, sizeof sums.light_paths);
      if (!transfer_sums(sums.values)) return false;
      uint8_t has_splats = sums.splats.empty() ? 0 : 1;
      io(&has_splats, sizeof has_splats);
      if (has_splats != 0 && !transfer_sums(data_->splats_of(sums))) return false;
    }
  }
  return true;
}

std::vector<FilmSums> Film::layer_sums(const std::vector<bool>& with_splats) {
  const auto span_of = [](ZeroedArray<double>& sums) {
    return std::span<double>(sums.data(), sums.size());
  };
  std::vector<FilmSums> all;
  for (Data::Sums& sums : data_->lanes.at(lane_)) {
    if (all.size() < with_splats.size() && with_splats[all.size()]) data_->splats_of(sums);
    all.push_back({&sums.light_paths, span_of(sums.values), span_of(sums.splats)});
  }
  return all;
}

ConstFilmSums Film::lane_sums(uint32_t lane) const {
  const Data::Sums& sums = data_->lanes.at(lane).at(0);
  return {sums.light_paths,
          {sums.values.data(), sums.values.size()},
          {sums.splats.data(), sums.splats.size()}};
}

std::vector<bool> Film::gaps(int layer) const {
  const size_t stride = data_->stride_of(layer);
  std::vector<bool> gaps(static_cast<size_t>(crop_.area()), true);
  bool is_empty = true, has_paths = false;
  for (const Data::Lane& lane : data_->lanes) {
    has_paths = has_paths || lane.at(layer).light_paths > 0;
    const ZeroedArray<double>& data = lane.at(layer).values;
    for (size_t p = 0; p < gaps.size(); ++p) {
      if (data[(p + 1) * stride - 1] == 0) continue;
      gaps[p] = false;
      is_empty = false;
    }
  }
  if (is_empty && has_paths) gaps.assign(gaps.size(), false);
  return gaps;
}

double Film::Data::splat_scale(size_t layer, size_t first, size_t end) const {
  double paths = 0;
  for (size_t l = first; l < end; ++l) paths += lanes[l][layer].light_paths;
  return paths > 0 ? 1 / paths : 1;
}

Rgb Film::Data::color(size_t layer, size_t pixel, size_t first, size_t end) const {
  const size_t stride = stride_of(layer);
  glm::dvec3 sum(0.), splats(0.);
  double weight = 0;
  for (size_t l = first; l < end; ++l) {
    const Sums& of = lanes[l][layer];
    const double* const from = &of.values[pixel * stride];
    sum += glm::dvec3(from[0], from[1], from[2]);
    weight += from[stride - 1];
    if (of.splats.empty()) continue;
    for (int c = 0; c < 3; ++c) splats[c] += of.splats[3 * pixel + c];
  }
  // Divide by the weight rather than multiply by its inverse, so that the mean of a single sample
  // is exactly that sample.
  const glm::dvec3 radiance =
      sum / (weight == 0 ? double{kInfinity} : weight) + splats * splat_scale(layer, first, end);
  return Rgb(radiance * double{film.response_});
}

template <class Write>
void Film::Data::for_each_mean(const Run& run, size_t pixel, const Write& write) const {
  constexpr size_t kAtOnce = 16;
  for (size_t first = 0; first < run.count; first += kAtOnce) {
    const size_t count = std::min(kAtOnce, run.count - first);
    double sums[kAtOnce] = {}, weight = 0;
    for (const Lane& lane : lanes) {
      const double* const from = &lane[run.layer].values[pixel * run.stride];
      for (size_t i = 0; i < count; ++i) sums[i] += from[run.first_value + first + i];
      weight += from[run.stride - 1];
    }
    for (size_t i = 0; i < count; ++i) write(weight == 0 ? 0. : sums[i] / weight);
  }
}

double Film::Data::mean(size_t layer, size_t pixel, size_t value) const {
  double result = 0;
  for_each_mean({layer, stride_of(layer), value, 1}, pixel, [&](double mean) { result = mean; });
  return result;
}

float Film::Data::value_of(const FilmChannel& channel, size_t pixel) const {
  const auto layer = static_cast<size_t>(channel.layer);
  if (channel.power != 1) {
    const int place = index_of(channel);
    const std::vector<FilmPower>& powers = layers[layer].powers;
    size_t i = 0;
    while (powers[i].value != place || powers[i].power != channel.power) ++i;
    const bool is_color = channel.value < 0 && channel.value != FilmChannel::kA;
    const double response = is_color ? std::pow(double{film.response_}, channel.power) : 1.;
    return static_cast<float>(response *
                              mean(layer, pixel, static_cast<size_t>(values_of(layer)) + i));
  }
  const int value = channel.value;
  const Rgb mean_color = color(layer, pixel, 0, lanes.size());
  if (value >= FilmChannel::kX) {
    return static_cast<float>(xyz(glm::dvec3(mean_color))[value - FilmChannel::kX]);
  }
  return mean_color[value - FilmChannel::kR];
}

std::vector<Film::Data::Run> Film::Data::runs() const {
  std::vector<Run> runs;
  for (const FilmChannel& channel : channels) {
    const auto layer = static_cast<size_t>(channel.layer);
    if (channel.power != 1 || (channel.value < 0 && channel.value != FilmChannel::kA)) {
      runs.push_back({layer, 0, 0, 0});
      continue;
    }
    const auto value = static_cast<size_t>(index_of(channel));
    if (!runs.empty() && runs.back().count > 0 && runs.back().layer == layer &&
        runs.back().first_value + runs.back().count == value) {
      ++runs.back().count;
    } else {
      runs.push_back({layer, stride_of(layer), value, 1});
    }
  }
  return runs;
}

Image Film::develop(const Rect& pixels) const {
  Image image{pixels.width(), pixels.height(), channels(), {}};
  image.data.assign(static_cast<size_t>(pixels.area()) * image.channels.size(), 0.f);
  float* to = image.data.data();
  const std::vector<Data::Run> runs = data_->runs();
  for (int y = pixels.y0; y < pixels.y1; ++y) {
    for (int x = pixels.x0; x < pixels.x1; ++x) {
      const size_t p = pixel_offset(crop_, x, y, 1);
      const Rgb mean_color = data_->color(0, p, 0, data_->lanes.size());
      if (is_luminance_) {
        *to++ = luminance(mean_color);
      } else {
        for (int c = 0; c < 3; ++c) *to++ = mean_color[c];
      }
      if (has_alpha_) *to++ = static_cast<float>(data_->mean(0, p, 3));
      const FilmChannel* channel = data_->channels.data();
      for (const Data::Run& run : runs) {
        if (run.count == 0) {
          *to++ = data_->value_of(*channel++, p);
        } else {
          data_->for_each_mean(run, p, [&](double mean) { *to++ = static_cast<float>(mean); });
          channel += run.count;
        }
      }
    }
  }
  return image;
}

std::optional<Rgb> Film::lane_color(size_t pixel, uint32_t lane) const {
  const Data::Sums& from = data_->lanes.at(lane)[0];
  if (from.values[(pixel + 1) * data_->stride_of(0) - 1] == 0 && from.light_paths == 0) {
    return std::nullopt;
  }
  const Rgb mean_color = data_->color(0, pixel, lane, lane + 1);
  return is_luminance_ ? Rgb(luminance(mean_color)) : mean_color;
}

}  // namespace kinome
