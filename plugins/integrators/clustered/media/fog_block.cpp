#include "clustered/media/fog_block.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "clustered/media/segment_distances.h"
#include "kinome/stats.h"
#include "transport/blocks/blocks_of_tile.h"

namespace kinome {
namespace {

using transport::kBlockSamples;
using transport::kCameraDimensions;
using transport::MediumLeg;
using FirstEdges = transport::VolumePaths::FirstEdges;

/// Dimensions of the sampler: the choice of a collision and its position, then the candidates.
constexpr uint32_t kCollisionDimension = kCameraDimensions, kCollisionDimensions = 2;
constexpr uint32_t kFogDimension = kCollisionDimension + kCollisionDimensions;
/// Number of paths per ray that continue from a collision, divided by the part of the light that is
/// scattered; at most one per ray. With 1, as many as in `volpath`.
constexpr float kPathsPerCollision = 2;
/// Uses of random numbers for directions in the sky and for rays of sunlight (RandomSeeds).
constexpr uint32_t kSkyUse = 0x666f6764, kSunRaysUse = 0x73756e72;
/// Number of rays of sunlight of a block (SunPoints), relative to the samples of a pixel, and its
/// bounds. The error that all samples of a pixel share must fall with their number.
constexpr size_t kSunRaysPerSample = 32, kMinSunRays = 256, kMaxSunRays = kBlockSamples;
/// Number of distances from which that of a collision is chosen.
constexpr size_t kDistances = 4;
/// Number of candidates for each part of a ray in a medium.
constexpr uint32_t kCandidates = 1;

/// Scattered part of the light that a leg takes away, for each channel.
Rgb scattered_on(const MediumLeg& leg, const transport::MediaTable& media) {
  const Rgb depth = leg.length * media.extinction().at(leg.medium);
  Rgb taken(-std::expm1(-depth.x));
  if (media.is_coloured()) taken.y = -std::expm1(-depth.y), taken.z = -std::expm1(-depth.z);
  return leg.throughput * taken * media.albedo().at(leg.medium);
}

float sum_of(const Rgb& c) {
  return c.x + c.y + c.z;
}

/// True if emitter samples may find light in all media.
bool are_open(const transport::MediaTable& media) {
  for (uint32_t m = 1; m < media.size(); ++m) {
    if (media.emitter_weight(m) != 1) return false;
  }
  return true;
}

}  // namespace

FogBlock::FogBlock(const transport::SceneTable& scene, const transport::MediaTable& media,
                   const FogSources& sources, const Sensor& sensor, const PathSettings& settings,
                   float paths)
    : scene_(scene),
      media_(media),
      sampler_(sensor.sampler()),
      needs_collisions_(settings.length.max_depth > 2 || sources.have_surfaces() ||
                        !are_open(media)),
      sees_sky_(scene.scene().environment() && !settings.hide_emitters),
      share_(needs_collisions_ ? FogLight::kShare : kInfinity),
      relative_paths_(paths),
      finds_later_(needs_collisions_ && !sources.have_suns() && are_open(media)),
      max_depth_(static_cast<float>(settings.length.max_depth)),
      camera_(scene, sensor, kBlockSamples, false),
      segments_(scene, media, settings.hide_emitters, 2 * kBlockSamples),
      sources_(sources),
      sun_points_(sources.beams() && max_depth_ > 2
                      ? std::make_unique<SunPoints>(scene, media, *sources.beams(), kMaxSunRays)
                      : nullptr),
      light_choice_(sources, directions_, media, sun_points_.get(), max_depth_,
                    scene.scene().emitters().size()),
      paths_(scene, media, sensor.sampler(), settings, 2 * kBlockSamples, &light_choice_),
      fog_(scene, media, sources, directions_, sensor.sampler(), share_, kBlockSamples),
      film_(sensor.film().filter(), sensor.film().value_count(0), kBlockSamples,
            sensor.film().has_powers(0)),
      numbers_(2 * kBlockSamples),
      arena_(kBlockSamples + kBlockLanes),  // see FilmSamples::add
      per_path_(2 * kBlockSamples),
      radiance_(arena_.three()),
      alpha_(arena_.floats()),
      u_(per_path_.floats()),
      u_distance_(per_path_.floats()),
      before_(per_path_.floats()),
      total_(per_path_.floats()),
      left_(per_path_.floats()),
      reference_(per_path_.floats()),
      values_{radiance_.x, radiance_.y, radiance_.z} {
  paths_.set_survival_gain(paths * transport::VolumePaths::kSurvivalGain);
  if (sensor.film().has_alpha()) values_.push_back(alpha_);
}

void FogBlock::render(const PixelSamples& samples, Tile& tile) {
  trace(samples, tile.counters);
  const StageTimer timer(tile.counters.stage_seconds["film"]);
  film_.add(samples, camera_.film_position(), values_, tile.film);
}

void FogBlock::trace(const PixelSamples& samples, RenderCounters& counters) {
  const size_t count = samples.count();
  directions_.draw(sources_, transport::RandomSeeds(samples, kSkyUse).of(0));
  if (sun_points_) {
    const StageTimer timer(counters.stage_seconds["light points"]);
    const size_t rays = std::clamp(kSunRaysPerSample * samples.samples, kMinSunRays, kMaxSunRays);
    sun_points_->draw(rays, transport::RandomSeeds(samples, kSunRaysUse).of(0), counters);
  }
  FirstEdges first;
  {
    const StageTimer timer(counters.stage_seconds["primary"]);
    camera_.make_rays(samples);
    for (float* const column : {radiance_.x, radiance_.y, radiance_.z}) {
      std::fill_n(column, padded(count), 0.f);
    }
    first = paths_.begin(samples, camera_.rays());
    legs_.clear();
    const transport::PathState state{
        first.owner, first.medium, first.throughput, nullptr, nullptr, first.scatterings, &legs_};
    segments_.trace(first.rays, count, state, transport::RandomSeeds(samples, kCollisionDimension),
                    RayKind::kCamera, counters);
    set_alpha(first, count);
  }
  {
    const StageTimer timer(counters.stage_seconds["shadow"]);
    fog_.add(samples, legs_, kFogDimension, kCandidates, radiance_, counters);
  }
  std::fill_n(reference_, count, 0.f);
  const size_t collisions = needs_collisions_ ? add_collisions(samples, first) : 0;
  light_choice_.set_visibility(fog_.visibility());
  const auto emitters = static_cast<float>(scene_.scene().emitters().size());
  paths_.trace_from(samples, count + collisions, share_ * emitters,
                    kFogDimension + kCandidates * FogLight::kDimensions, reference_, radiance_,
                    counters, finds_later_ ? this : nullptr);
}

/// Traces later edges: like camera rays, but goes on from a collision or from the surface, each
/// with the probability of its part of the light. Absorption ends paths.
void FogBlock::trace(const PixelSamples& samples, const FirstEdges& edges, size_t count,
                     uint32_t dimension, const Columns3& radiance, RenderCounters& counters) {
  legs_.clear();
  for (size_t i = 0; i < count; ++i) before_[i] = sum_of(edges.throughput.at(i));
  const transport::PathState state{
      edges.owner, edges.medium, edges.throughput, nullptr, nullptr, edges.scatterings, &legs_};
  segments_.trace(edges.rays, count, state, transport::RandomSeeds(samples, dimension),
                  RayKind::kBsdf, counters);
  if (legs_.empty()) return;
  numbers_.fill_1d(sampler_, samples, dimension, edges.owner, count, u_);
  numbers_.fill_1d(sampler_, samples, dimension + 1, edges.owner, count, u_distance_);
  lit_legs_.clear();
  for (const MediumLeg& leg : legs_) {
    if (edges.scatterings[leg.path] < max_depth_ - 1) lit_legs_.push_back(leg);
  }
  fog_.add_later(samples, lit_legs_, edges.owner, dimension, radiance, counters);
  std::fill_n(total_, count, 0.f);
  sum_scattered();
  for (size_t i = 0; i < count; ++i) {
    const float surface = sum_of(edges.throughput.at(i)), scattered = total_[i];
    total_[i] = before_[i];
    left_[i] = total_[i] * u_[i];
    if (left_[i] < scattered) continue;
    const bool is_absorbed = left_[i] >= scattered + surface;
    edges.throughput.set(i,
                         is_absorbed ? Rgb(0.f) : edges.throughput.at(i) * (total_[i] / surface));
    if (is_absorbed) edges.rays[i / kBlockLanes].shape[i % kBlockLanes] = kNoHit;
  }
  for (size_t k = 0; k < legs_.size(); ++k) {
    const uint32_t path = legs_[k].path;
    float& left = left_[path];
    const float weight = sum_of(scattered_[k]);
    if (left >= 0 && left < weight) add_collision(edges, path, k, left, u_distance_[path]);
    left -= weight;
  }
}

/// Sets the light that each leg scatters, and adds its sum over channels to the path's total.
void FogBlock::sum_scattered() {
  scattered_.clear();
  for (const MediumLeg& leg : legs_) {
    scattered_.push_back(scattered_on(leg, media_));
    total_[leg.path] += sum_of(scattered_.back());
  }
}

/// Sets alpha to the probability that `volpath` sets it to 1.
void FogBlock::set_alpha(const FirstEdges& first, size_t count) {
  for (size_t i = 0; i < count; ++i) {
    const bool hits = first.rays[i / kBlockLanes].shape[i % kBlockLanes] != kNoHit;
    alpha_[i] = sees_sky_ || hits ? 1 : 1 - mean_of(first.throughput.at(i));
  }
}

/// Adds paths from collisions of the rays, at most one for each ray. Returns the number of these
/// paths.
size_t FogBlock::add_collisions(const PixelSamples& samples, const FirstEdges& first) {
  const size_t count = samples.count();
  numbers_.fill_1d(sampler_, samples, kCollisionDimension, first.owner, count, u_);
  numbers_.fill_1d(sampler_, samples, kCollisionDimension + 1, first.owner, count, u_distance_);
  std::fill_n(total_, count, 0.f);
  sum_scattered();
  // A leg's probability is proportional to its weight. The total weight is at most 3, since
  // throughputs begin with 1.
  for (size_t i = 0; i < count; ++i) {
    reference_[i] = total_[i] / 3;
    total_[i] = std::max(total_[i], 3 / (kPathsPerCollision * relative_paths_));
    left_[i] = total_[i] * u_[i];
  }
  size_t added = 0;
  for (size_t k = 0; k < legs_.size(); ++k) {
    const uint32_t sample = legs_[k].path;
    float& left = left_[sample];
    const float weight = sum_of(scattered_[k]);
    if (left >= 0 && left < weight) {
      first.owner[count + added] = sample;
      add_collision(first, count + added++, k, left, u_distance_[sample]);
    }
    left -= weight;
  }
  disable_padding(first.rays, count + added);
  return added;
}

/// Makes a collision on leg k. `at`: uniform between 0 and the leg's weight; it selects the channel
/// that the distance is sampled for.
void FogBlock::add_collision(const FirstEdges& first, size_t path, size_t k, float at, float u) {
  const MediumLeg& leg = legs_[k];
  const Rgb extinction = media_.extinction().at(leg.medium);
  const Rgb weight = scattered_[k];
  int channel = at < weight.x ? 0 : at < weight.x + weight.y ? 1 : 2;
  if (!(weight[channel] > 0)) channel = weight.y > 0 ? 1 : 0;
  const AttenuatedDistances distances(extinction[channel], leg.length);
  float before = 0;
  for (int c = 0; c < channel; ++c) before += weight[c];
  const auto [t, factor] = choose_distance(leg, distances, u, (at - before) / weight[channel]);
  Rgb throughput(0.f);
  if (media_.is_coloured()) {
    float density = 0;
    for (int c = 0; c < 3; ++c) {
      if (!(weight[c] > 0)) continue;
      density += weight[c] * AttenuatedDistances(extinction[c], leg.length).density(t);
      throughput[c] = std::exp(-extinction[c] * t) * extinction[c];
    }
    throughput *= leg.throughput * media_.albedo().at(leg.medium) * (total_[leg.path] / density);
  } else {
    throughput = weight * (total_[leg.path] / sum_of(weight));
  }
  RayHit16& rays = first.rays[path / kBlockLanes];
  const size_t lane = path % kBlockLanes;
  set_ray(rays.ray, lane, Ray(leg.o, leg.d, 0, t));
  rays.shape[lane] = media_.collision_shape(leg.medium);
  first.medium[path] = leg.medium;
  first.throughput.set(path, factor * throughput);
}

/// Chooses one of several distances in proportion to the light that lamps scatter there: resampling
/// (Talbot et al. 2005), which needs no density. Returns its weight, too. `u`: uniform, for the
/// distances; `v`: uniform, for the choice.
std::pair<float, float> FogBlock::choose_distance(const MediumLeg& leg,
                                                  const AttenuatedDistances& distances, float u,
                                                  float v) {
  LampGuide& guide = light_choice_.guide();
  if (guide.is_empty()) return {distances.at(u), 1.f};
  std::array<float, kDistances> t, light;
  float sum = 0;
  for (size_t k = 0; k < kDistances; ++k) {
    t[k] = distances.at((static_cast<float>(k) + u) / kDistances);
    light[k] = guide.light_at(leg.o + t[k] * leg.d);
    sum += light[k];
  }
  if (!(sum > 0) || !(sum < kInfinity)) return {distances.at(u), 1.f};
  float left = v * sum;
  size_t chosen = 0;
  for (; chosen + 1 < kDistances && left >= light[chosen]; ++chosen) left -= light[chosen];
  return {t[chosen], sum / (kDistances * light[chosen])};
}

}  // namespace kinome
