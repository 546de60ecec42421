#include "clustered/product/paths/eye_paths.h"

#include <algorithm>

#include "clustered/product/tiles/path_numbers.h"
#include "kinome/block_points.h"
#include "kinome/sampler.h"
#include "transport/paths/coverage.h"
#include "transport/shadows/rays.h"
#include "transport/surfaces/light_columns.h"

namespace kinome {
namespace {

/// Number of paths that are traced together.
constexpr size_t kPaths = 1024;

}  // namespace

struct EyePaths::Block {
  PathNumbers numbers;
  transport::SceneTable table;
  transport::Paths paths;
  transport::Surfaces met;
  transport::Arena per_path{kPaths}, per_point;
  RayHit16* rays;
  transport::LightColumns radiance;
  float *shown_share, *shown_share_later, *straight;
  uint32_t* owner;
  Columns3 throughput;
  uint32_t x[kPaths], y[kPaths];  ///< halves of the seeds

  Block(const Scene& scene, const PathSettings& settings, const LightGroups* groups)
      : table(scene, {}, groups ? *groups : LightGroups()),
        paths(table, numbers, settings, kPaths),
        met(table, kPaths),
        per_point(transport::Surfaces::max_points(table, kPaths)),
        rays(per_path.ray_hits()),
        radiance(table, 1),
        shown_share(per_path.floats()),
        shown_share_later(per_path.floats()),
        straight(per_path.floats()),
        owner(per_point.indices()),
        throughput(per_point.three()) {}
};

EyePaths::EyePaths(const Scene& scene, const PathSettings& settings, uint32_t edges_before,
                   const LocalLight* light, const LightGroups* groups)
    : scene_(scene),
      settings_(settings),
      edges_before_(edges_before),
      light_(light),
      groups_(groups) {}
EyePaths::~EyePaths() = default;

void EyePaths::trace(RenderCounters& counters) {
  // pass() adds rays to the next list.
  for (size_t passes = 0; passes < waiting_.size(); ++passes) {
    const std::vector<Begin> paths = std::move(waiting_[passes]);
    for (size_t begin = 0; begin < paths.size(); begin += kPaths) {
      trace({&paths[begin], std::min(kPaths, paths.size() - begin)}, counters);
    }
  }
  waiting_.clear();
}

/// Continues a ray straight through the surface at z, `distance` from the start.
void EyePaths::pass(const Begin& path, const SurfaceInteraction& z, float distance) {
  // The path will have two more edges: to the surface behind z, and to the light.
  if (passes_left(settings_.length.max_depth, edges_before_ + 2 + path.passes) == 0) return;
  Begin next = path;
  next.throughput *= z.shape->bsdf().null_transmission(z).transmittance;
  if (is_black(next.throughput)) return;
  ++next.passes;
  next.before = distance;
  next.seed = hash_words(path.seed, next.passes);
  next.ray = z.spawn_ray(path.ray.d);
  push(next);
}

/// See Shares.
EyePaths::Shares EyePaths::shares_of_path(const Begin& path, const SurfaceInteraction& z,
                                          float distance) const {
  if (!light_ || !std::isfinite(path.density) || !is_plain(z)) return {};
  const LocalLight::Place place = light_->third_place(z);
  const float geometry = std::abs(glm::dot(z.n, path.ray.d)) / sqr(distance);
  const float odds = path.density * geometry * place.eye_ratio / path.rates[place.cell];
  const float shown_odds = odds * LocalLight::kShownEyeShare;
  if (!(odds < kInfinity)) return {};
  // `shown` is the ratio of the share for shown light to `all`.
  return {odds / (1 + odds), (1 + odds) * LocalLight::kShownEyeShare / (1 + shown_odds)};
}

void EyePaths::trace(std::span<const Begin> paths, RenderCounters& counters) {
  if (!block_) block_ = std::make_unique<Block>(scene_, settings_, groups_);
  Block& block = *block_;
  for (size_t i = 0; i < paths.size(); ++i) {
    set_ray(block.rays[i / kBlockLanes].ray, i % kBlockLanes, paths[i].ray);
    block.x[i] = static_cast<uint32_t>(paths[i].seed);
    block.y[i] = static_cast<uint32_t>(paths[i].seed >> 32);
  }
  const Columns3 radiance = block.radiance.radiance();
  transport::clear_radiance(block.table, radiance, paths.size());
  disable_padding(block.rays, paths.size());
  transport::clear_hits(block.rays, paths.size());
  scene_.intersect(block.rays, padded(paths.size()) / kBlockLanes, Coherence::kIncoherent,
                   counters);
  counters[RayKind::kBsdf] += paths.size();
  block.met.find(block.rays, paths.size(), transport::Surfaces::Which::kAll);
  const uint32_t* const ray = block.met.points().ray;
  const bool passes = light_ && light_->passing();
  for (size_t i = 0; i < block.met.reflecting(); ++i) {
    const uint32_t k = ray[i];
    const float distance =
        paths[k].before + block.rays[k / kBlockLanes].ray.tmax[k % kBlockLanes];
    const SurfaceInteraction z = interaction_of(block.met.points(), i);
    if (passes && block.met.live()[i] > 0 && z.shape->bsdf().has_null_lobe()) {
      pass(paths[k], z, distance);
    }
    block.owner[i] = k;
    const Shares shares = shares_of_path(paths[k], z, distance);
    block.throughput.set(i, paths[k].throughput * shares.all);
    block.shown_share[k] = paths[k].shown_share * shares.shown;
    block.shown_share_later[k] = paths[k].shown_share_later * shares.shown;
  }
  transport::Vertices vertices{&block.met, block.owner, block.throughput, block.shown_share,
                               block.shown_share_later};
  vertices.drops_straight = passes;
  if (edges_before_ == 0 && transport::hides_environment(settings_, scene_)) {
    std::fill_n(block.straight, paths.size(), 1.f);
    vertices.straight = block.straight;
  }
  const uint32_t depth = edges_before_ + 1 + paths[0].passes;
  block.paths.go_on({block.x, block.y, paths.size(), 0, 1, 0}, vertices, depth,
                    {radiance, radiance}, counters);
  size_t group = 0;
  transport::for_each_group(block.table.light_groups(), radiance, [&](const Columns3& of_group) {
    for (size_t i = 0; i < paths.size(); ++i) paths[i].sum[group] += of_group.at(i);
    ++group;
  });
}

}  // namespace kinome
