#include "clustered/product/local_choice.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "clustered/product/spread.h"

namespace kinome {
namespace {

/// Share of the choice that goes by guided flux alone.
constexpr float kDefensive = 0.25f;
/// What is believed to be hidden keeps this share of its importance.
constexpr float kLeastVisibility = 0.05f;
/// Lamps: of what their flux says, at least this is believed, and so much is added to cosines,
/// since a patch has more than one place.
constexpr float kLeastOfFlux = 0.01f, kLampMargin = 0.05f;
constexpr int kRateRounds = 4;
/// Of the reflected light, what a glossy lobe adds in all directions.
constexpr float kLobeFloor = 0.05f;

/// As of a GGX distribution of half vectors, whose width the cell's extent adds to.
float lobe_value(const Patch& patch, const Vec3& d, float spread2) {
  const Vec3 sum = patch.viewer + d;
  const float length2 = glm::dot(sum, sum);
  if (!(length2 > 1e-8f)) return 0;
  const float cosine = glm::dot(sum, patch.normal) / std::sqrt(length2);
  const float alpha2 = std::min(1.f, patch.alpha2() + 0.25f * spread2);
  const float t = std::max(0.f, 1 + (alpha2 - 1) * cosine * cosine);
  return cosine > 0 ? alpha2 / (4 * kPi * std::max(t * t, 1e-12f)) : 0.f;
}

/// About the share of light from d that the patch reflects; `arriving`: the cosine, or more of it.
float reflected(const Patch& patch, const Vec3& d, float arriving, float spread2) {
  float value = mean_of(patch.diffuse) * kInvPi * std::clamp(arriving, 0.f, 1.f);
  if (patch.glossy_reflectance > 0 && arriving > 0) {
    value += patch.glossy_reflectance * (lobe_value(patch, d, spread2) + kLobeFloor);
  }
  return value;
}

}  // namespace

void LocalChoice::find_importance(const LocalLight& light, const Patch& patch,
                                  const Visibility& visibility, uint32_t first_cell) {
  const LocalCellColumns& cells = light.columns();
  double total = 0;
  of_patch_.resize(light.size());
  for (uint32_t c = 0; c < light.size(); ++c) {
    const Vec3 to =
        Vec3(cells.position[0][c], cells.position[1][c], cells.position[2][c]) - patch.position;
    const float squared = glm::dot(to, to) + 1e-30f;
    const float inverse = 1 / std::sqrt(squared);
    const float softened = squared + cells.spread2[c];
    const float spread2 = cells.spread2[c] / softened, spread = std::sqrt(spread2);
    const Vec3 d = to * inverse;
    const Vec3 normal(cells.normal[0][c], cells.normal[1][c], cells.normal[2][c]);
    const float leaving = -glm::dot(normal, d) + 1 - glm::length(normal) + spread;
    const float arriving = glm::dot(patch.normal, d) + spread + 0.05f;
    of_patch_[c] = reflected(patch, d, arriving, spread2) * cells.flux[c] *
                   std::clamp(leaving, 0.f, 1.f) / softened;
  }
  if (light.lamps().size() > kLampBlockSize) look_at_lamps(light, patch);
  for (uint32_t c = 0; c < light.size(); ++c) {
    of_patch_[c] *= std::max(
        {visibility.v[first_cell + c], visibility.sigma[first_cell + c], kLeastVisibility});
    total += of_patch_[c];
  }
  if (!(total > 0)) return;
  const auto scale = static_cast<float>(1 / total);
  for (uint32_t c = 0; c < light.size(); ++c) importance_[c] += of_patch_[c] * scale;
}

/// Lamps that are cells of their own tell themselves what reaches the patch.
void LocalChoice::look_at_lamps(const LocalLight& light, const Patch& patch) {
  const auto& first = light.lamp_first();
  for (uint32_t c = 0; c < light.lamp_cells(); ++c) {
    if (first[c + 1] - first[c] != 1) continue;
    const float by_flux = of_patch_[c] * kLeastOfFlux;
    const auto lit = light.lamps()[first[c]]->sample_direct(patch.position, Vec2(0.5f));
    float value = 0;
    if (lit && lit->pdf > 0) {
      const float arriving = glm::dot(patch.normal, lit->d) + kLampMargin;
      value = reflected(patch, lit->d, arriving, 0) * mean_of(glm::abs(lit->radiance)) / lit->pdf;
    }
    of_patch_[c] = std::max(value, by_flux);
  }
}

/// Of the cells from `begin` to `end`, of which a primary is to look at `size` points.
void LocalChoice::find_rates(const LocalLight& light, uint32_t begin, uint32_t end, uint32_t size) {
  const auto& flux = light.columns().guided_flux;
  const auto& expected = light.columns().expected;
  double importance = 0, all = 0;
  for (uint32_t c = begin; c < end; ++c) {
    importance += importance_[c];
    all += flux[c];
  }
  const auto share_of = [&](uint32_t c) {
    double share = all > 0 ? flux[c] / all : 1. / (end - begin);
    if (importance > 0) {
      share = kDefensive * share + (1 - kDefensive) * importance_[c] / importance;
    }
    // A share so small that it would vanish leaves light out.
    return std::max(share, 1e-9);
  };
  // Nobody looks at a point twice: what cells can't use is left to the others.
  double scale = size;
  for (int round = 0; round < kRateRounds; ++round) {
    double used = 0, left = 0;
    for (uint32_t c = begin; c < end; ++c) {
      const double share = share_of(c);
      if (scale * share < expected[c]) {
        left += share;
      } else {
        used += expected[c];
      }
    }
    if (!(left > 0) || !(used < size)) break;
    scale = (size - used) / left;
  }
  for (uint32_t c = begin; c < end; ++c) {
    const double rate = expected[c] > 0 ? scale * share_of(c) / expected[c] : 1.;
    rates_[c] = static_cast<float>(std::min(rate, 1.));
  }
}

void LocalChoice::find_rates(const LocalLight& light) {
  rates_.assign(light.size(), 1.f);
  if (light.lamps().size() > kLampBlockSize) {
    find_rates(light, 0, light.lamp_cells(), kLampBlockSize);
  }
  find_rates(light, light.lamp_cells(), light.size(), kBlockSize);
}

void LocalChoice::choose(const LocalLight& light, const LocalPoints& points,
                         std::span<const Patch> patches, std::span<const Visibility> visibility,
                         uint32_t first_cell, size_t primaries, uint64_t seed) {
  blocks_ = static_cast<uint32_t>(
      std::bit_floor(std::clamp<size_t>(primaries / 2, kLeastBlocks, kMostBlocks)));
  lamp_blocks_ = light.lamps().size() > kLampBlockSize ? blocks_ : 1;
  importance_.assign(light.size(), 0.f);
  for (size_t p = 0; p < patches.size(); ++p) {
    find_importance(light, patches[p], visibility[p], first_cell);
  }
  find_rates(light);
  pick_lamps(light, random_float(seed, 1));
  pick_points(light, points, random_float(seed, 2));
}

namespace {

/// Calls pick(c, k) for elements k of cells [begin, end), each with probability `rate(c)`, by one
/// comb over all of them.
template <class Count, class Rate, class Pick>
void comb_cells(uint32_t begin, uint32_t end, double offset, const Count& count, const Rate& rate,
                const Pick& pick) {
  double left = 1 - offset;  // until the next tooth, in rates
  for (uint32_t c = begin; c < end; ++c) {
    const double step = rate(c);
    const auto size = static_cast<double>(count(c));
    if (!(step > 0)) continue;
    const double teeth = 1 / step;
    double k = std::ceil(left * teeth) - 1;
    for (; k < size; k = std::ceil(left * teeth) - 1) {
      pick(c, static_cast<uint32_t>(std::max(k, 0.)));
      left += 1;
    }
    left -= size * step;
  }
}

}  // namespace

void LocalChoice::pick_lamps(const LocalLight& light, double offset) {
  lamps_.clear();
  lamp_first_.clear();
  picked_lamps_.clear();
  const auto& first = light.lamp_first();
  comb_cells(
      0, light.lamp_cells(), offset, [&](uint32_t c) { return first[c + 1] - first[c]; },
      [&](uint32_t c) { return static_cast<double>(rates_[c]) * lamp_blocks_; },
      [&](uint32_t c, uint32_t k) {
        picked_lamps_.push_back({light.lamps()[first[c] + k], c, 1 / rates_[c]});
      });
  for (uint32_t b = 0; b < lamp_blocks_; ++b) {
    lamp_first_.push_back(static_cast<uint32_t>(lamps_.size()));
    for (size_t i = b; i < picked_lamps_.size(); i += lamp_blocks_)
      lamps_.push_back(picked_lamps_[i]);
  }
  lamp_first_.push_back(static_cast<uint32_t>(lamps_.size()));
}

void LocalChoice::pick_points(const LocalLight& light, const LocalPoints& points, double offset) {
  picks_.clear();
  const auto& first = points.first;
  comb_cells(
      light.lamp_cells(), light.size(), offset, [&](uint32_t c) { return first[c + 1] - first[c]; },
      [&](uint32_t c) { return static_cast<double>(rates_[c]) * blocks_; },
      [&](uint32_t c, uint32_t k) { picks_.push_back({first[c] + k, c, 1 / rates_[c]}); });
  const size_t most = padded((picks_.size() + blocks_ - 1) / blocks_) * blocks_;
  for (auto& column : columns_) {
    if (column.size() < most) column.resize(most);
  }
  if (cells_.size() < most) {
    cells_.resize(most);
    points_.resize(most);
    weights_.resize(most);
  }
  block_first_.clear();
  uint32_t at = 0;
  const auto put = [&](const Pick& pick, float weight) {
    points_[at] = pick.point;
    cells_[at] = pick.cell;
    weights_[at++] = weight;
  };
  for (uint32_t b = 0; b < blocks_; ++b) {
    block_first_.push_back(at);
    for (size_t i = b; i < picks_.size(); i += blocks_) put(picks_[i], picks_[i].weight);
    while (at % simd::kLobeLanes != 0) put(picks_.front(), 0);
  }
  block_first_.push_back(at);
  float* columns[simd::kLightPointNumbers];
  for (size_t k = 0; k < simd::kLightPointNumbers; ++k) columns[k] = columns_[k].data();
  simd::gather_points(points.rows.data(), points_.data(), weights_.data(), at, columns);
}

namespace {

/// Blocks beside one another hold points beside one another: any few numbers in a row get blocks
/// that are far apart. `count` is a power of two, and an odd factor takes all turns.
uint32_t spread(uint32_t index, uint32_t count) {
  return (index * (scaled(kGolden, count) | 1)) & (count - 1);
}

}  // namespace

LocalChoice::Block LocalChoice::block(uint32_t index) const {
  const uint32_t b = spread(index, blocks_), at = block_first_[b];
  // Blocks may be empty, and the columns with them.
  const auto column = [&](int k) { return columns_[k].data() + at; };
  Block block;
  for (int axis = 0; axis < 3; ++axis) {
    block.columns.position[axis] = column(axis);
    block.columns.normal[axis] = column(3 + axis);
    block.columns.geometric[axis] = column(6 + axis);
    block.columns.power[axis] = column(9 + axis);
  }
  block.columns.eye_ratio = column(12);
  block.cell = cells_.data() + at;
  block.point = points_.data() + at;
  block.size = block_first_[b + 1] - at;
  return block;
}

std::span<const LocalChoice::Lamp> LocalChoice::lamps(uint32_t index) const {
  const uint32_t b = spread(index, lamp_blocks_);
  return {lamps_.data() + lamp_first_[b], lamps_.data() + lamp_first_[b + 1]};
}

}  // namespace kinome
