// The first part of ProductRenderer: what a pilot finds out, and what is learned of it.
#include <algorithm>
#include <cmath>

#include "clustered/product/product_workspace.h"
#include "clustered/product/spread.h"

namespace kinome {
namespace {

/// Tiles this far around a tile tell of its visibility, with weights of a Gaussian in pixels.
constexpr int kReach = 2;
constexpr float kReachDeviation = 4;
/// Patches learn from those of nearly the same normal and plane.
constexpr float kLearnCosine = 0.9f;
constexpr float kLearnPlanes = 1.6f;
/// A sharp lobe's patch keeps its visibility only if, on the pilot's own rays, it predicts this
/// well: sum (V - v)² < kTrust x sum V².
constexpr float kTrust = 0.1f;
/// Pixels of which the pilot's points are kept until they are planned, and those of the next ones:
/// enough work for many threads.
constexpr int kPixelsOfBand = 1 << 16;
/// Keeps the pilot's random numbers apart from those of the passes.
constexpr uint64_t kPilotSeed = 0x70696c6f74;
/// Variances of candidates are small beside what shadows add.
constexpr float kGlossyFactor = 2;
/// Rays that an eye ray takes in all, the light of what it finds included.
constexpr float kEyeRayCost = 2.5f;

}  // namespace

int ProductRenderer::rows_of_band() const {
  const int pixels = std::min(settings_.remembered_pixels, kPixelsOfBand);
  return std::clamp(pixels / (crop_.width() * kBlock), 1, std::max(1, blocks_y()));
}

ProductRenderer::Rows ProductRenderer::band(int index) const {
  const int rows = rows_of_band();
  return {index * rows, std::min((index + 1) * rows, blocks_y())};
}

ProductRenderer::PilotPoint* ProductRenderer::points_of(int x, int y) {
  const int height = rows_of_band() * kBlock, row = y - crop_.y0;
  const size_t pixel = static_cast<size_t>(row % height) * crop_.width() + (x - crop_.x0);
  return &points_[row / height % 2][pixel * pilot_primaries_];
}

/// A band is planned when the pilot has seen the next one, which tiles at its border learn from.
void ProductRenderer::learn_in_bands(const CellLight& light, uint32_t rays, double progress_end) {
  static_assert(kReach <= kTilesAcross);
  const int rows = rows_of_band(), bands = (blocks_y() + rows - 1) / rows;
  const size_t points = static_cast<size_t>(rows) * kBlock * crop_.width() * pilot_primaries_;
  forecast_.resize(static_cast<size_t>(crop_.area()));
  for (int i = 0; i <= bands && !context_.cancelled(); ++i) {
    context_.set_progress_range(progress_end * i / (bands + 1),
                                progress_end * (i + 1) / (bands + 1));
    if (i < bands) {
      points_[i % 2].assign(points, {});
      pilot(band(i), light, rays);
    }
    if (i > 0 && !context_.cancelled()) plan(band(i - 1), light);
  }
  for (auto& p : points_) p = {};
  if (!context_.cancelled()) {
    const StageTimer timer(context_.stats().counters.stage_seconds["allocate"]);
    allocation_.emplace(forecast_, crop_.width(), crop_.height(), settings_.adaptive);
  }
  forecast_ = {};
}

void ProductRenderer::pilot(Rows rows, const CellLight& light, uint32_t rays) {
  const uint64_t seed = hash_words(seed_, kPilotSeed);
  const auto count = static_cast<uint16_t>(pilot_primaries_);
  for_each_block(rows, light, "pilot", [&](int block, Workspace& work) {
    double untold = 0;  // the pilot is one stage
    trace_tiles(
        block, seed, untold, work, [&](int, int) { return count; },
        [&](const Tile& tile, TilePrimaries& primaries) {
          probe_tile(tile, primaries, rays, seed, work);
        });
    work.estimator.flush();
    keep_records(block, work);
  });
}

void ProductRenderer::probe_tile(const Tile& tile, TilePrimaries& primaries, uint32_t rays,
                                 uint64_t seed, Workspace& work) {
  TileMemory& memory = tiles_[tile.index];
  make_patches(primaries, memory.patches);
  const size_t patches = memory.patches.size();
  while (work.unknown.size() < patches) {
    work.unknown.emplace_back().resize(padded_cells());
    work.unknown.back().reset();
  }
  auto& records = work.records[tile.place];
  if (records.size() < patches) records.resize(patches);
  for (auto& r : records) r.clear();
  work.point_plans.assign(primaries.size(), {});
  // All pixels have as many.
  const auto point_of = [&](size_t i) -> PilotPoint& {
    const auto pixel = static_cast<int>(i / pilot_primaries_);
    const int x = tile.pixels.x0 + pixel % tile.pixels.width();
    const int y = tile.pixels.y0 + pixel / tile.pixels.width();
    return points_of(x, y)[i % pilot_primaries_];
  };
  for (size_t i = 0; i < primaries.size(); ++i) work.point_plans[i].lit = &point_of(i).lit;
  for (Patch& patch : memory.patches) patch.glossy = patch.eye_rays = 0;
  const auto index = static_cast<uint64_t>(tile.index);
  work.estimator.begin_tile(scene_, primaries, memory.patches, work.unknown,
                            hash_words(seed, index, 2), *work.counters);
  size_t lit = 0;
  for (size_t i = 0; i < primaries.size(); ++i) lit += primaries.patch(i) >= 0;
  Estimator::Unit unit;
  unit.end = static_cast<uint32_t>(primaries.size());
  unit.rays = static_cast<uint32_t>(lit * rays / pilot_primaries_);
  unit.seed = hash_words(seed, index, 1);
  work.estimator.probe(unit, work.point_plans, records);
  for (size_t i = 0; i < primaries.size(); ++i) {
    PilotPoint& point = point_of(i);
    point.patch = static_cast<int16_t>(primaries.patch(i));
    const PointPlan& plan = work.point_plans[i];
    point.known = mean_of(primaries.emitted(i)) + plan.glossy + plan.mirrored;
    point.lamps = plan.lamps;
    point.glossy_deviation = static_cast<float>(std::sqrt(plan.glossy_variance));
    if (point.patch >= 0) {
      point.reflected = primaries.normal(i) * mean_of(primaries.diffuse(i));
    }
  }
}

/// What the rays of a block's tiles found, tile by tile and patch by patch.
void ProductRenderer::keep_records(int block, const Workspace& work) {
  for_each_tile(block, [&](const Tile& tile) {
    TileMemory& memory = tiles_[tile.index];
    const auto& found = work.records[tile.place];
    size_t count = 0;
    for (size_t p = 0; p < memory.patches.size(); ++p) count += found[p].size();
    memory.records.clear();
    memory.records.reserve(count);
    for (size_t p = 0; p < memory.patches.size(); ++p) {
      memory.patches[p].first_record = static_cast<uint32_t>(memory.records.size());
      memory.records.insert(memory.records.end(), found[p].begin(), found[p].end());
      memory.patches[p].end_record = static_cast<uint32_t>(memory.records.size());
    }
  });
}

/// From the pilot's records of the tiles around, on surfaces that go on as the patch does.
void ProductRenderer::learn(int tile, const Patch& patch, Workspace& work) const {
  work.learner.begin();
  const int tx = tile % tiles_x(), ty = tile / tiles_x();
  for (int dy = -kReach; dy <= kReach; ++dy) {
    for (int dx = -kReach; dx <= kReach; ++dx) {
      const int x = tx + dx, y = ty + dy;
      if (x < 0 || y < 0 || x >= tiles_x() || y >= tiles_y()) continue;
      const auto squared = static_cast<float>((dx * dx + dy * dy) * kTile * kTile);
      const float weight = std::exp(-0.5f * squared / sqr(kReachDeviation));
      const auto units = static_cast<uint32_t>(std::lround(16 * weight));
      if (units == 0) continue;
      const TileMemory& memory = tiles_[static_cast<size_t>(y) * tiles_x() + x];
      for (const Patch& other : memory.patches) {
        if (other.bsdf != patch.bsdf || glm::dot(other.normal, patch.normal) < kLearnCosine ||
            std::abs(glm::dot(other.position - patch.position, patch.normal)) >
                kLearnPlanes * patch.tolerance) {
          continue;
        }
        work.learner.add(std::span(memory.records)
                             .subspan(other.first_record, other.end_record - other.first_record),
                         units);
      }
    }
  }
}

void ProductRenderer::learn_visibility(int tile, const Patch& patch, Workspace& work,
                                       Visibility& visibility, std::vector<uint8_t>& out) const {
  learn(tile, patch, work);
  work.learner.finish(visibility);
  const size_t first = out.size(), count = visibility.v.size();
  out.resize(first + 2 * count);
  uint8_t* const v = &out[first];
  uint8_t* const sigma = v + count;
  for (size_t c = 0; c < count; ++c) {
    v[c] = static_cast<uint8_t>(static_cast<int32_t>(visibility.v[c] * 255 + 0.5f));
    const float root = std::min(1.f, std::sqrt(visibility.sigma[c]));
    sigma[c] = static_cast<uint8_t>(static_cast<int32_t>(root * 255 + 0.5f));
  }
}

/// Of large pictures visibilities would be most of the memory.
bool ProductRenderer::remembers() const {
  return crop_.area() <= settings_.remembered_pixels;
}

void ProductRenderer::load_visibility(const uint8_t* learned, Visibility& out) const {
  const size_t padded = padded_cells();
  for (size_t c = 0; c < padded; ++c) {
    out.v[c] = static_cast<float>(learned[c]) * (1 / 255.f);
    out.sigma[c] = std::max(sqr(static_cast<float>(learned[padded + c]) * (1 / 255.f)), 1e-4f);
    out.sigma_mixed[c] = std::sqrt(0.9f * out.v[c] + 0.06f);
  }
}

void ProductRenderer::apply_ablations(Visibility& visibility) const {
  if (settings_.control_variate && settings_.learned_sigma) return;
  for (size_t c = 0; c < visibility.v.size(); ++c) {
    if (!settings_.control_variate) {
      visibility.sigma[c] = std::sqrt(0.05f + 0.9f * visibility.v[c] + 0.01f);
      visibility.v[c] = 0;
    }
    if (!settings_.learned_sigma) visibility.sigma[c] = visibility.sigma_mixed[c] = 1;
  }
}

/// A lamp's reflection that a ridge hides, while v says that it is seen, would be the worst of
/// errors.
void ProductRenderer::find_trust(const TileMemory& memory, Patch& patch,
                                 const Visibility& visibility) const {
  struct {
    float count = 0, visible = 0, v = 0;
  } lamps, others;
  const uint32_t first_lamp = cells_.padded_size();
  const uint32_t end_lamps = first_lamp + (local_ ? local_->lamp_cells() : 0);
  float error = 0, sigma = 0;
  for (uint32_t i = patch.first_record; i < patch.end_record; ++i) {
    const VisibilityRecord record = memory.records[i];
    const uint32_t cell = record.cell();
    const float v = visibility.v[cell], seen = record.visible() ? 1.f : 0.f;
    auto& of = cell >= first_lamp && cell < end_lamps ? lamps : others;
    of.count += 1;
    of.visible += seen;
    of.v += v;
    error += sqr(seen - v);
    sigma += visibility.sigma[cell];
  }
  const float count = lamps.count + others.count;
  if (count == 0) return;
  const float mean = (lamps.v + others.v) / count;
  patch.lamp_visibility = lamps.count > 0 ? lamps.v / lamps.count : mean;
  patch.mean_visibility = others.count > 0 ? others.v / others.count : mean;
  patch.mean_sigma = sigma / count;
  if (!is_sharp(patch)) return;
  patch.trust = error < kTrust * (lamps.visible + others.visible);
  patch.mean_visibility = (others.visible + 2 * patch.mean_visibility) / (others.count + 2);
}

void ProductRenderer::plan_tile(const Tile& tile, Workspace& work) {
  TileMemory& memory = tiles_[tile.index];
  work.controls.assign(memory.patches.size() * 9, 0.f);
  work.reserve_visibility(1, padded_cells());
  Visibility& visibility = work.visibility.front();
  memory.learned.clear();
  for (size_t p = 0; p < memory.patches.size(); ++p) {
    Patch& patch = memory.patches[p];
    work.learned.clear();
    learn_visibility(tile.index, patch, work, visibility, remembers() ? memory.learned : work.learned);
    if (local_ || any(patch.bsdf->lobes() & Lobe::kGlossy)) find_trust(memory, patch, visibility);
    const DiffuseStrata::PatchPlan plan = work.planner.plan(patch, visibility);
    std::copy(plan.control, plan.control + 9, &work.controls[p * 9]);
    patch.uncertainty = plan.uncertainty + patch.glossy * patch.mean_sigma;
  }
  for (int y = tile.pixels.y0; y < tile.pixels.y1; ++y) {
    for (int x = tile.pixels.x0; x < tile.pixels.x1; ++x) {
      forecast_pixel(memory, work.controls.data(), x, y);
    }
  }
}

void ProductRenderer::forecast_pixel(const TileMemory& memory, const float* controls, int x,
                                     int y) {
  PixelForecast& forecast = forecast_[pixel_index(x, y)];
  forecast = {};
  double sum = 0, squares = 0, glossy_variance = 0;
  const PilotPoint* const points = points_of(x, y);
  for (uint32_t k = 0; k < pilot_primaries_; ++k) {
    const PilotPoint& point = points[k];
    float value = point.known;
    if (point.patch >= 0) {
      const Patch& patch = memory.patches[point.patch];
      const float* const control = controls + point.patch * 9;
      Vec3 light(0.f);
      for (int i = 0; i < 9; ++i) light[i % 3] += control[i] * (1 / 3.f);
      value = std::max(
          0.f, kInvPi * glm::dot(light, point.reflected) + point.known * patch.mean_visibility);
      value += point.lit + std::max(0.f, point.lamps) * patch.lamp_visibility;
      forecast.uncertainty += patch.uncertainty;
      const double deviation = point.glossy_deviation * patch.mean_visibility;
      glossy_variance += deviation * deviation * kGlossyFactor;
      const bool mirrors = any(patch.bsdf->lobes() & Lobe::kDelta);
      forecast.mirrors += mirrors ? 1.f : 0.f;
      if (local_) forecast.mirrors += kEyeRayCost * expected_eye_rays(patch, *local_);
      forecast.sharp = forecast.sharp || mirrors || is_sharp(patch);
    }
    sum += value;
    squares += static_cast<double>(value) * value;
  }
  const double n = pilot_primaries_;
  forecast.mean = static_cast<float>(sum / n);
  forecast.uncertainty /= static_cast<float>(n);
  forecast.glossy_deviation = static_cast<float>(std::sqrt(glossy_variance / n));
  forecast.mirrors /= static_cast<float>(n);
  if (n > 1) {
    forecast.deviation =
        static_cast<float>(std::sqrt(std::max(0., (squares - sum * sum / n) / (n - 1))));
  }
}

void ProductRenderer::plan(Rows rows, const CellLight& light) {
  for_each_block(rows, light, "plan", [&](int block, Workspace& work) {
    for_each_tile(block, [&](const Tile& tile) { plan_tile(tile, work); });
  });
}

}  // namespace kinome
