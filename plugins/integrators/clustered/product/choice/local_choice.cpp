#include "clustered/product/choice/local_choice.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "clustered/product/choice/lobe_values.h"
#include "clustered/product/tiles/spread.h"

namespace kinome {
namespace {

/// Share of the rates that depends on guided flux alone.
constexpr float kDefensive = 0.25f;
/// Minimum visibility that importance assumes, for light that seems hidden.
constexpr float kMinVisibility = 0.05f;
/// Minimum importance of a lamp, relative to that from its flux.
constexpr float kMinFluxShare = 0.01f;
/// Added to the cosine of a lamp, because a patch has more than one position.
constexpr float kLampMargin = 0.05f;
/// Number of lamps that a primary uses. If light bounces several times, reflected light causes most
/// of the noise, and half of the lamps do nearly as well.
constexpr uint32_t kLampBlockSize = 64, kLampBlockSizeOfDeepLight = 32;
constexpr int kRateRounds = 4;
/// Roughness below which every primary with a glossy lobe sends an eye ray.
constexpr float kSharpAlpha = 0.1f;
/// Number of points that are tried, relative to the number that is taken.
constexpr double kTriedPerTaken = 1;

simd::ReflectingPatch reflecting(const Patch& patch, const LocalLight& light) {
  simd::ReflectingPatch out;
  for (int axis = 0; axis < 3; ++axis) {
    out.position[axis] = patch.position[axis];
    out.normal[axis] = patch.normal[axis];
    out.viewer[axis] = patch.viewer[axis];
  }
  out.diffuse = mean_of(patch.diffuse);
  out.glossy = patch.glossy_reflectance;
  out.alpha2 = patch.alpha2();
  out.eye_rays = expected_eye_rays(patch, light);
  out.diffuse_share = diffuse_share(patch);
  return out;
}

uint32_t lamp_block_size(const LocalLight& light) {
  const bool is_deep = light.max_depth() > LocalLight::kBounceDepth;
  return is_deep ? kLampBlockSizeOfDeepLight : kLampBlockSize;
}

/// Squared extent of the tile at the patch; 0 if the patch has no plane.
float squared_size(const Patch& patch) {
  return std::isfinite(patch.tolerance) ? sqr(patch.tolerance) : 0;
}

}  // namespace

/// The pilot's estimate is not used alone for sharp lobes, because they reflect too few light
/// points.
float expected_eye_rays(const Patch& patch, const LocalLight& light) {
  if (light.needs_eye_rays()) return 1;
  const float sharpness = std::min(1.f, kSharpAlpha / std::sqrt(patch.alpha2()));
  return std::max(patch.eye_rays, sharpness * (1 - diffuse_share(patch)));
}

/// Adds the importance of all cells for a patch, given the visibility in assumed_visibility_.
void LocalChoice::find_importance(const LocalLight& light, const simd::ReflectingPatch& patch) {
  const LocalCellColumns& cells = light.columns();
  const auto three = [](const std::vector<float>(&columns)[3], int k) { return columns[k].data(); };
  const size_t count = light.padded_size();
  simd::cell_importance(
      patch,
      {{three(cells.position, 0), three(cells.position, 1), three(cells.position, 2)},
       {three(cells.normal, 0), three(cells.normal, 1), three(cells.normal, 2)},
       cells.spread2.data(),
       cells.flux.data()},
      assumed_visibility_.data(), count, of_patch_.data());
  if (light.lamps().size() > lamp_block_size(light)) find_lamp_importance(light, patch);
  simd::add_normalized(of_patch_.data(), count, importance_.data());
}

/// Sets the importance of each cell with a single lamp to the light that the patch gets from it.
void LocalChoice::find_lamp_importance(const LocalLight& light,
                                       const simd::ReflectingPatch& patch) {
  const auto& first = light.lamp_first();
  const Vec3 position(patch.position[0], patch.position[1], patch.position[2]);
  const Vec3 normal(patch.normal[0], patch.normal[1], patch.normal[2]);
  for (uint32_t c = 0; c < light.lamp_cells(); ++c) {
    if (first[c + 1] - first[c] != 1) continue;
    const float by_flux = of_patch_[c] * kMinFluxShare;
    const auto lit = light.lamps()[first[c]]->sample_direct(position, Vec2(0.5f));
    float value = 0;
    if (lit && lit->pdf > 0) {
      const float arriving = glm::dot(normal, lit->d) + kLampMargin;
      value = simd::reflected_fraction(patch, &lit->d.x, arriving, 0) *
              mean_of(glm::abs(lit->radiance)) / lit->pdf * assumed_visibility_[c];
    }
    of_patch_[c] = std::max(value, by_flux);
  }
}

/// Computes the rates of cells [begin, end), from which a primary uses `size` points on average.
void LocalChoice::find_rates(const LocalLight& light, uint32_t begin, uint32_t end, uint32_t size) {
  const auto& flux = light.columns().guided_flux;
  const auto& expected = light.columns().expected;
  double importance = 0, all = 0;
  for (uint32_t c = begin; c < end; ++c) {
    importance += importance_[c];
    all += flux[c];
  }
  shares_.resize(end);
  for (uint32_t c = begin; c < end; ++c) {
    double share = all > 0 ? flux[c] / all : 1. / (end - begin);
    if (importance > 0) {
      share = kDefensive * share + (1 - kDefensive) * importance_[c] / importance;
    }
    // A share that underflows to 0 would leave light out.
    shares_[c] = std::max(share, 1e-9);
  }
  // Rates are at most 1. Cells without enough points leave the rest to other cells.
  double scale = size;
  for (int round = 0; round < kRateRounds; ++round) {
    double used = 0, left = 0;
    for (uint32_t c = begin; c < end; ++c) {
      const double share = shares_[c];
      if (scale * share < expected[c]) {
        left += share;
      } else {
        used += expected[c];
      }
    }
    if (!(left > 0) || !(used < size)) break;
    const double next = (size - used) / left;
    if (next == scale) break;
    scale = next;
  }
  for (uint32_t c = begin; c < end; ++c) {
    const double rate = expected[c] > 0 ? scale * shares_[c] / expected[c] : 1.;
    rates_[c] = static_cast<float>(std::min(rate, 1.));
  }
}

void LocalChoice::find_rates(const LocalLight& light) {
  rates_.assign(light.size(), 1.f);
  if (light.lamps().size() > lamp_block_size(light)) {
    find_rates(light, 0, light.lamp_cells(), lamp_block_size(light));
  }
  find_rates(light, light.lamp_cells(), light.size(), kBlockSize);
}

void LocalChoice::choose(const LocalLight& light, const LocalPoints& points,
                         std::span<const Patch> patches, std::span<const Visibility> visibility,
                         uint32_t first_cell, size_t primaries, uint64_t seed) {
  blocks_ = static_cast<uint32_t>(
      std::bit_floor(std::clamp<size_t>(primaries / 2, kMinBlocks, kMaxBlocks)));
  lamp_blocks_ = light.lamps().size() > lamp_block_size(light) ? blocks_ : 1;
  const size_t count = light.padded_size();
  importance_.assign(count, 0.f);
  of_patch_.resize(count);
  assumed_visibility_.resize(count);
  // Calls fn for each patch after computing assumed_visibility_ for its cells.
  const auto for_each_patch = [&](const auto& fn) {
    for (size_t p = 0; p < patches.size(); ++p) {
      simd::assumed_visibility(visibility[p].v.data() + first_cell,
                               visibility[p].sigma.data() + first_cell, kMinVisibility, count,
                               assumed_visibility_.data());
      fn(patches[p], reflecting(patches[p], light));
    }
  };
  for_each_patch([&](const Patch&, const simd::ReflectingPatch& patch) {
    find_importance(light, patch);
  });
  find_rates(light);
  pick_lamps(light, random_float(seed, 1));
  try_points(light, points, random_float(seed, 2));
  if (!tried_.empty()) {
    for_each_patch([&](const Patch& patch, const simd::ReflectingPatch& reflects) {
      tried_.add_patch(reflects, squared_size(patch), assumed_visibility_.data());
    });
  }
  picks_.clear();
  tried_.take(blocks_, random_float(seed, 3), picks_);
  pick_points(points);
}

namespace {

/// Selects elements k of cells [begin, end), each with probability rate(c), by one comb over all
/// cells. Calls pick(c, k) for each.
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
        const uint32_t lamp = first[c] + k;
        picked_lamps_.push_back(
            {light.lamps()[lamp], c, 1 / rates_[c], light.lamp_groups()[lamp]});
      });
  for (uint32_t b = 0; b < lamp_blocks_; ++b) {
    lamp_first_.push_back(static_cast<uint32_t>(lamps_.size()));
    for (size_t i = b; i < picked_lamps_.size(); i += lamp_blocks_)
      lamps_.push_back(picked_lamps_[i]);
  }
  lamp_first_.push_back(static_cast<uint32_t>(lamps_.size()));
}

/// Preselects points to try, each at most once.
void LocalChoice::try_points(const LocalLight& light, const LocalPoints& points, double offset) {
  tried_.begin(points);
  const auto& first = points.first;
  const double scale = blocks_ / static_cast<double>(points.share);
  const auto rate = [&](uint32_t c) { return static_cast<double>(rates_[c]) * scale; };
  const auto probability = [&](uint32_t c) { return std::min(1., kTriedPerTaken * rate(c)); };
  comb_cells(
      light.lamp_cells(), light.size(), offset, [&](uint32_t c) { return first[c + 1] - first[c]; },
      probability,
      [&](uint32_t c, uint32_t k) { tried_.add(first[c] + k, c, probability(c), rate(c), 1 / rates_[c]); });
  tried_.gather();
}

/// Deals the picks into blocks.
void LocalChoice::pick_points(const LocalPoints& points) {
  const size_t most = padded((picks_.size() + blocks_ - 1) / blocks_) * blocks_;
  for (auto& column : columns_) {
    if (column.size() < most) column.resize(most);
  }
  if (cells_.size() < most) {
    cells_.resize(most);
    points_.resize(most);
    reflections_.resize(most);
    groups_.resize(most);
    weights_.resize(most);
    eye_weights_.resize(most);
  }
  block_first_.clear();
  uint32_t at = 0;
  const auto put = [&](const TriedPoints::Take& pick, float weight, float eye_weight) {
    points_[at] = pick.point;
    reflections_[at] = points.reflection[pick.point];
    groups_[at] = points.group[pick.point];
    cells_[at] = pick.cell;
    weights_[at] = weight;
    eye_weights_[at++] = eye_weight;
  };
  const float scale = static_cast<float>(blocks_) / points.share;
  for (uint32_t b = 0; b < blocks_; ++b) {
    block_first_.push_back(at);
    for (size_t i = b; i < picks_.size(); i += blocks_) {
      put(picks_[i], picks_[i].weight * scale, 1 / rates_[picks_[i].cell]);
    }
    while (at % simd::kLobeLanes != 0) put(picks_.front(), 0, 0);
  }
  block_first_.push_back(at);
  float* columns[simd::kLightPointNumbers];
  for (size_t k = 0; k < simd::kLightPointNumbers; ++k) columns[k] = columns_[k].data();
  simd::gather_points(points.rows.data(), {points_.data(), weights_.data(), eye_weights_.data()},
                      at, columns);
}

namespace {

/// Permutes block indices so that consecutive indices get blocks that are far apart, because
/// neighbouring blocks have neighbouring points. `count` is a power of two, so that multiplication
/// by an odd number is a permutation.
uint32_t spread(uint32_t index, uint32_t count) {
  return (index * (scaled(kGolden, count) | 1)) & (count - 1);
}

}  // namespace

LocalChoice::Block LocalChoice::block(uint32_t index) const {
  const uint32_t b = spread(index, blocks_), at = block_first_[b];
  // Pointer arithmetic instead of indexing, because blocks and columns may be empty.
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
  block.reflection = reflections_.data() + at;
  block.group = groups_.data() + at;
  block.weight = weights_.data() + at;
  block.size = block_first_[b + 1] - at;
  return block;
}

std::span<const LocalChoice::Lamp> LocalChoice::lamps(uint32_t index) const {
  const uint32_t b = spread(index, lamp_blocks_);
  return {lamps_.data() + lamp_first_[b], lamps_.data() + lamp_first_[b + 1]};
}

}  // namespace kinome
