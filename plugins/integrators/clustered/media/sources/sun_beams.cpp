#include "clustered/media/sources/sun_beams.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "clustered/media/segment_distances.h"
#include "clustered/media/sources/sun_points.h"
#include "kinome/sampler.h"
#include "kinome/shape.h"
#include "transport/camera/camera.h"
#include "transport/media/tracking/medium_shadows.h"
#include "transport/shadows/rays.h"

namespace kinome {
namespace {

using transport::MediaTable;
using transport::MediumLeg;

/// Number of rays of light in a round of learning, and of camera rays.
constexpr size_t kLearningRays = 1024;
/// Number of points seen by the camera that each light point is connected to.
constexpr size_t kConnections = 3;
/// Share of the probability that all cells have in common, and the minimum importance of a cell
/// beside another one, relative to it.
constexpr float kEvenShareOfCells = 0.1f, kBesideCell = 0.25f;
/// Distance of SunBeams::near2(), relative to the extent of the light points that paths see.
/// The minimum of its square is relative to that of the scene.
constexpr float kNear = 0.25f, kMinNear = 1e-6f;
/// Use of random numbers (RandomSeeds).
constexpr uint32_t kBeamUse = 0x6265616d;

float hashed_unit(uint64_t seed, size_t i, uint32_t dimension) {
  return to_unit_float(static_cast<uint32_t>(hash_words(seed, i, kBeamUse + dimension)));
}

/// Makes camera rays through random pixels, which begin at tmin = 0.
void make_camera_rays(const transport::SceneTable& scene, const Sensor& sensor,
                      const PixelSamples& samples, RayHit16* rays) {
  transport::Camera camera(scene, sensor, samples.count(), false);
  camera.make_rays(samples);
  for (size_t i = 0; i < samples.count(); ++i) {
    const Ray ray = ray_of(&camera.rays()[i / kBlockLanes].ray, i % kBlockLanes);
    set_ray(rays[i / kBlockLanes].ray, i % kBlockLanes,
            Ray(ray.o + ray.tmin * ray.d, ray.d, 0, ray.tmax - ray.tmin));
  }
}

/// Returns points at which paths through random pixels may be scattered for the first time.
std::vector<SunBeams::SeenPoint> seen_points(const transport::SceneTable& scene,
                                             const MediaTable& media, const Sensor& sensor,
                                             uint64_t seed) {
  std::vector<uint32_t> x(kLearningRays), y(kLearningRays);
  const Rect crop = sensor.film().crop();
  for (size_t i = 0; i < kLearningRays; ++i) {
    const auto at = [&](uint32_t dimension, int begin, int size) {
      return static_cast<uint32_t>(
          begin + static_cast<int>(hashed_unit(seed, i, dimension) * static_cast<float>(size)));
    };
    x[i] = at(0, crop.x0, crop.width()), y[i] = at(1, crop.y0, crop.height());
  }
  const PixelSamples samples{x.data(), y.data(), kLearningRays, 0, 1, seed};
  transport::Arena arena(kLearningRays);
  RayHit16* const rays = arena.ray_hits();
  uint32_t *const owner = arena.indices(), *const medium = arena.indices();
  const Columns3 throughput = arena.three();
  float* const scatterings = arena.floats();
  make_camera_rays(scene, sensor, samples, rays);
  std::fill_n(medium, kLearningRays, media.start());
  for (float* const column : {throughput.x, throughput.y, throughput.z}) {
    std::fill_n(column, kLearningRays, 1.f);
  }
  std::vector<MediumLeg> legs;
  transport::Segments segments(scene, media, false, kLearningRays);
  RenderCounters counters;
  segments.trace(rays, kLearningRays,
                 {owner, medium, throughput, nullptr, nullptr, scatterings, &legs},
                 transport::RandomSeeds(samples, kBeamUse), RayKind::kCamera, counters);
  transport::Surfaces met(scene, kLearningRays);
  met.find(rays, kLearningRays, transport::Surfaces::Which::kAll);
  std::vector<SunBeams::SeenPoint> seen;
  for (size_t i = 0; i < met.reflecting(); ++i) {
    if (met.live()[i] > 0) seen.push_back({met.points().p.at(i), met.points().n.at(i)});
  }
  for (size_t l = 0; l < legs.size(); ++l) {
    const AttenuatedDistances distances(min_extinction(media.extinction().at(legs[l].medium)),
                                        legs[l].length);
    seen.push_back({legs[l].o + distances.at(hashed_unit(seed, l, 2)) * legs[l].d, Vec3(0.f)});
  }
  return seen;
}

/// Shadow rays between light points and points that the camera sees.
class Connections {
 public:
  Connections(const transport::SceneTable& scene, const MediaTable& media, size_t count)
      : count_(count),
        arena_(count),
        shadows_(scene, media, count, count),
        d_(arena_.three()),
        distance_(arena_.floats()),
        light_(arena_.floats()),
        medium_(arena_.indices()),
        owner_(arena_.indices()),
        rays_(arena_.untraced_rays()) {
    from_.p = arena_.three(), from_.n = arena_.three(), from_.p_error = arena_.floats();
  }

  /// Connects each light point to kConnections random points.
  void trace(const SunPoints& points, const std::vector<SunBeams::SeenPoint>& seen, uint64_t seed,
             RenderCounters& counters) {
    for (size_t i = 0; i < count_; ++i) {
      const auto size = static_cast<float>(seen.size());
      set(i, points, points.indices()[i / kConnections],
          seen[static_cast<size_t>(hashed_unit(seed, i, 3) * size)]);
    }
    using namespace wide;
    for_lanes(count_, [&](size_t i) {
      const Mask on = (Float::load(light_ + i) > 0.f) & first_lanes(count_ - i);
      transport::write_shadow_rays(from_, i, wide::Vec3::load(d_, i), Float::load(distance_ + i),
                                   on, true, rays_);
    });
    const uint32_t pixel = 0;
    const PixelSamples sample{&pixel, &pixel, 1, 0, 1, seed};
    shadows_.trace(rays_, count_, medium_, distance_, owner_,
                   transport::RandomSeeds(sample, kBeamUse), counters);
  }
  /// Light that arrives, with a factor that is the same for all connections.
  float light(size_t i) const {
    return light_[i] > 0 ? light_[i] * mean_of(shadows_.transmittance().at(i)) : 0;
  }

 private:
  void set(size_t i, const SunPoints& points, size_t k, const SunBeams::SeenPoint& to) {
    const FogSources::Light found = points.light(k, to.p);
    constexpr float kOfMedia = 0.25f;  // mean of the phase function times pi
    const bool is_medium = to.n == Vec3(0.f);
    light_[i] = mean_of(found.weight) * (is_medium ? kOfMedia : std::abs(glm::dot(to.n, found.d)));
    from_.p.set(i, points.point(k).p), from_.n.set(i, points.normal(k));
    from_.p_error[i] = points.error(k);
    medium_[i] = points.point(k).medium;
    d_.set(i, -found.d), distance_[i] = found.distance;
  }

  size_t count_;
  transport::Arena arena_;
  transport::MediumShadows shadows_;
  SurfaceBlock from_;
  Columns3 d_;
  float *distance_, *light_;
  uint32_t *medium_, *owner_;
  Ray16* rays_;
};

}  // namespace

/// Light of each cell, and moments of the positions of its points.
struct SunBeams::Learned {
  explicit Learned(size_t cells) : light(cells) {}
  void add(const SunPoints::Point& point, float arrives) {
    light[point.cell] += arrives;
    sum += arrives, first += arrives * point.p, second += arrives * point.p * point.p;
  }
  void add(const Learned& other) {
    for (size_t c = 0; c < light.size(); ++c) light[c] += other.light[c];
    sum += other.sum, first += other.first, second += other.second;
  }

  std::vector<float> light;
  Vec3 first{0.f}, second{0.f};
  float sum = 0;
};

bool SunBeams::are_possible(const Scene& scene, const MediaTable& media) {
  if (scene.bounds().empty() || scene.media().empty()) return false;
  for (uint32_t m = 1; m < media.size(); ++m) {
    if (media.emitter_weight(m) != 1) return false;
    bool is_inside = false, is_outside = false;
    for (const auto& shape : scene.shapes()) {
      is_inside = is_inside || shape->interior() == media.medium(m);
      is_outside = is_outside || shape->exterior() == media.medium(m);
    }
    if (!is_inside || is_outside) return false;
  }
  return std::none_of(scene.shapes().begin(), scene.shapes().end(), [](const auto& shape) {
    return shape->bsdf().has_null_lobe() && !shape->bsdf().is_invisible();
  });
}

SunBeams::SunBeams(const transport::SceneTable& scene, const MediaTable& media,
                   const Sensor& sensor, const Emitter& emitter, const Vec3& d, uint32_t rounds,
                   RenderContext& context)
    : emitter_(emitter), d_(d), frame_(Frame::from_normal(d)) {
  const Aabb& bounds = scene.scene().bounds();
  centre_ = bounds.centre();
  radius_ = std::max(0.5f * glm::length(bounds.extent()), 1e-20f) * 1.001f;
  set_probabilities(std::vector<float>(size_t{kResolution} * kResolution, 1.f));
  near2_ = 0.01f * radius_ * radius_;
  const auto seen = seen_points(scene, media, sensor, hash_words(kBeamUse, rounds));
  if (seen.empty()) return;
  // The second half of the rounds has the rays where the first half found light.
  Learned learned(probability_.size());
  const uint32_t half = (rounds + 1) / 2;
  for (uint32_t first = 0; first < rounds; first += half) {
    learn(scene, media, seen, {first, std::min(first + half, rounds)}, learned, context);
  }
}

/// Sets cells to the light that points behind them send to points that the camera sees. Adds the
/// results of some rounds to `all`.
void SunBeams::learn(const transport::SceneTable& scene, const MediaTable& media,
                     const std::vector<SeenPoint>& seen, std::pair<uint32_t, uint32_t> rounds,
                     Learned& all, RenderContext& context) {
  std::vector<Learned> results(rounds.second - rounds.first, Learned(probability_.size()));
  context.scheduler.parallel_for(results.size(), [&](size_t i) {
    const uint64_t seed = hash_words(kBeamUse, rounds.first + i);
    RenderCounters counters;
    SunPoints points(scene, media, *this, kLearningRays);
    points.draw(kLearningRays, seed, counters);
    const size_t count = points.indices().size() * kConnections;
    if (count == 0) return;
    Connections connections(scene, media, count);
    connections.trace(points, seen, seed, counters);
    for (size_t k = 0; k < count; ++k) {
      const float light = connections.light(k);
      if (light > 0) results[i].add(points.point(points.indices()[k / kConnections]), light);
    }
  });
  for (const Learned& result : results) all.add(result);
  if (!(all.sum > 0)) return;
  set_probabilities(all.light);
  const Vec3 mean = all.first / all.sum;
  const Vec3 variance = all.second / all.sum - mean * mean;
  near2_ = std::max(kNear * kNear * (variance.x + variance.y + variance.z),
                    kMinNear * radius_ * radius_);
}

void SunBeams::set_probabilities(const std::vector<float>& light) {
  probability_.clear();
  const auto at = [&](uint32_t x, uint32_t y) {
    return x < kResolution && y < kResolution ? light[size_t{y} * kResolution + x] : 0.f;
  };
  float all = 0;
  for (uint32_t y = 0; y < kResolution; ++y) {
    for (uint32_t x = 0; x < kResolution; ++x) {
      const float beside = std::max({at(x - 1, y), at(x + 1, y), at(x, y - 1), at(x, y + 1)});
      probability_.push_back(std::max(at(x, y), kBesideCell * beside));
      all += probability_.back();
    }
  }
  const float even = 1 / static_cast<float>(probability_.size());
  for (float& own : probability_) {
    own = kEvenShareOfCells * even + (1 - kEvenShareOfCells) * (all > 0 ? own / all : even);
  }
  cells_ = GridDistribution(kResolution, kResolution, probability_);
}

Vec3 SunBeams::sample(const Vec2& u, float& pdf, uint32_t& cell) const {
  const GridDistribution::Cell chosen = cells_.sample(u);
  cell = chosen.row * kResolution + chosen.column;
  const float side = 2 * radius_ / kResolution;
  const float x = (static_cast<float>(chosen.column) + chosen.u.x) * side - radius_;
  const float y = (static_cast<float>(chosen.row) + chosen.u.y) * side - radius_;
  pdf = probability_[cell] / (static_cast<float>(cells_.total()) * side * side);
  return centre_ + x * frame_.s + y * frame_.t + radius_ * frame_.n;
}

}  // namespace kinome
