#include "clustered/media/sources/fog_sources.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "kinome/clustered_light.h"
#include "kinome/sampler.h"
#include "kinome/shape.h"

namespace kinome {
namespace {

/// Approximate number of directions in all cells together that a block draws.
constexpr uint32_t kDirections = 1 << 11;
/// Positions that are tried to find the position of a lamp.
constexpr uint32_t kProbes = 256;
/// Directions from which the intensity of a near emitter is estimated, and the distance, as a
/// multiple of its radius.
constexpr uint32_t kIntensityProbes = 64;
constexpr float kIntensityDistance = 8;

/// Shadow rays of grids, relative to the samples of the render; their bounds, and the maximum
/// number of grids.
constexpr double kSunShare = 0.05, kMaxSunResolution = 32;
constexpr uint32_t kMinSunResolution = 6, kMaxSuns = 4;
/// Samples of the render for each round of learning of SunBeams, and the maximum number of rounds.
constexpr double kSamplesPerRound = 5e4, kMaxRounds = 16;

Vec3 random_direction(uint32_t i) {
  const uint64_t bits = hash_words(i, 0x70726f6265);
  const float z = 2 * to_unit_float(static_cast<uint32_t>(bits)) - 1;
  const float phi = 2 * kPi * to_unit_float(static_cast<uint32_t>(bits >> 32));
  const float r = std::sqrt(std::max(0.f, 1 - z * z));
  return {r * std::cos(phi), r * std::sin(phi), z};
}

float mean_intensity(const Emitter& emitter, const Vec3& p, float radius) {
  const float distance = radius > 0 ? kIntensityDistance * radius : 1;
  float sum = 0;
  for (uint32_t i = 0; i < kIntensityProbes; ++i) {
    const Vec3 from = p + distance * random_direction(i);
    const auto sample = emitter.sample_direct(from, Vec2(0.5f));
    if (sample && sample->pdf > 0) sum += mean_of(sample->radiance) / sample->pdf;
  }
  return sum * distance * distance / static_cast<float>(kIntensityProbes);
}

/// Returns a position on the sphere around the scene, or nearer to its centre.
Vec3 probe_position(const Scene& scene, uint32_t i) {
  const Aabb& bounds = scene.bounds();
  const Vec3 centre = bounds.empty() ? Vec3(0.f) : bounds.centre();
  const float radius = bounds.empty() ? 1.f : glm::length(bounds.extent());
  const float scale = static_cast<float>(i % 4) / 3;
  return centre + radius * scale * random_direction(i);
}

std::optional<DirectSample> probe(const Scene& scene, const Emitter& emitter) {
  for (uint32_t i = 0; i < kProbes; ++i) {
    const Vec3 p = probe_position(scene, i);
    const auto sample = emitter.sample_direct(p, Vec2(0.5f));
    if (!sample || is_black(sample->radiance)) continue;
    if (sample->distance == kInfinity) return sample;
    DirectSample found = *sample;
    found.d = p + sample->distance * sample->d;  // position of the emitter
    return found;
  }
  return std::nullopt;
}

}  // namespace

FogSources::FogSources(const Scene& scene, const Scheduler& scheduler) {
  for (const Emitter* const emitter : scene.emitters()) {
    if (emitter == scene.environment()) continue;
    have_surfaces_ = have_surfaces_ || emitter->shape();
    if (add_near(scene, *emitter)) continue;
    const auto sample = probe(scene, *emitter);
    Distant sun{emitter, 1, Vec3(0, 0, 1), 1, groups_++};
    if (sample && sample->pdf > 0) {
      sun.d = sample->d;
      sun.flux = mean_of(sample->radiance) / sample->pdf;
    }
    distant_.push_back(sun);
  }
  // Grids and beams are those of the first sources, which must not depend on the emitters' order.
  std::stable_sort(distant_.begin(), distant_.end(), [](const Distant& a, const Distant& b) {
    const bool a_is_delta = a.emitter->is_delta(), b_is_delta = b.emitter->is_delta();
    return a_is_delta != b_is_delta ? a_is_delta : a.flux > b.flux;
  });
  first_cell_ = static_cast<uint32_t>(distant_.size());
  if (scene.environment()) add_environment(*scene.environment(), scheduler);
}

void FogSources::find_suns(const transport::SceneTable& scene, const transport::MediaTable& media,
                           double samples, RenderContext& context) {
  uint32_t count = 0;
  while (count < std::min(first_cell_, kMaxSuns) && distant_[count].emitter->is_delta()) ++count;
  if (count == 0) return;
  const double cells = samples * kSunShare / (SunGrid::kRays * count);
  const auto resolution = static_cast<uint32_t>(std::min(std::cbrt(cells), kMaxSunResolution));
  if (resolution < kMinSunResolution) return;
  for (uint32_t i = 0; i < count; ++i) {
    suns_.push_back(
        std::make_unique<const SunGrid>(scene, media, distant_[i].d, resolution, context));
  }
}

void FogSources::find_beams(const transport::SceneTable& scene, const transport::MediaTable& media,
                            const Sensor& sensor, double samples, RenderContext& context) {
  if (suns_.empty()) return;
  const auto rounds = static_cast<uint32_t>(std::min(samples / kSamplesPerRound, kMaxRounds));
  if (rounds == 0 || !SunBeams::are_possible(scene.scene(), media)) return;
  const Distant& strongest = distant_.front();
  beams_ = std::make_unique<const SunBeams>(scene, media, sensor, *strongest.emitter, strongest.d,
                                            rounds, context);
}

/// Returns false if the emitter's light comes from infinity.
bool FogSources::add_near(const Scene& scene, const Emitter& emitter) {
  if (emitter.shape()) {
    const Aabb box = emitter.shape()->bounds();
    const float radius = 0.5f * glm::length(box.extent());
    near_.push_back(
        {&emitter, box.centre(), radius, mean_intensity(emitter, box.centre(), radius)});
    return true;
  }
  const auto found = probe(scene, emitter);
  if (found && found->distance == kInfinity) return false;
  const Vec3 centre = scene.bounds().empty() ? Vec3(0.f) : scene.bounds().centre();
  const Vec3 p = found ? found->d : centre;
  near_.push_back({&emitter, p, 0, mean_intensity(emitter, p, 0)});
  return true;
}

void FogSources::add_environment(const Emitter& environment, const Scheduler& scheduler) {
  cells_ = std::make_unique<const DistantCells>(environment, *cell_grid_of(environment), kCells,
                                                scheduler);
  const DistantCells& cells = *cells_;
  if (cells.size() == 0) return;
  for (uint32_t c = 0; c < cells.size(); ++c) {
    const Vec3 axis(cells.axis()[0][c], cells.axis()[1][c], cells.axis()[2][c]);
    const float mean_cosine = 0.5f * (1 + std::cos(cells.radius()[c]));
    distant_.push_back(
        {&environment, cells.flux()[c], axis, mean_cosine, groups_ + c / kCellsPerGroup});
  }
  groups_ += (cells.size() + kCellsPerGroup - 1) / kCellsPerGroup;
}

FogSources::Light FogSources::sample(uint32_t source, const Vec3& p, const Vec2& u,
                                     const SkyDirections& directions) const {
  const auto distant = static_cast<uint32_t>(source - near_.size());
  if (source >= near_.size() && distant >= first_cell_) {
    const SkyDirections::Direction& chosen = directions.choose(distant - first_cell_, u.x);
    return {chosen.d, kInfinity, chosen.weight, chosen.emitter_pdf};
  }
  const Emitter& emitter =
      source < near_.size() ? *near_[source].emitter : *distant_[distant].emitter;
  const auto sample = emitter.sample_direct(p, u);
  if (!sample || !(sample->pdf > 0)) return {};
  const bool is_alone = sample->is_delta || (!emitter.shape() && !emitter.is_environment());
  return {sample->d, sample->distance, sample->radiance / sample->pdf,
          is_alone ? kInfinity : sample->pdf};
}

void SkyDirections::draw(const FogSources& sources, uint64_t seed) {
  directions_.clear();
  if (!sources.cells_ || sources.cells_->size() == 0) return;
  const CellPoints drawn = sources.cells_->draw_points(kDirections, seed);
  first_ = drawn.first;
  const Emitter& environment = *sources.distant_.back().emitter;
  for (const CellPoint& point : drawn.points) {
    directions_.push_back({point.d, environment.pdf_environment(point.d), point.weight});
  }
}

}  // namespace kinome
