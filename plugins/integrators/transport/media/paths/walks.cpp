#include "transport/media/paths/walks.h"

#include <algorithm>
#include <bit>

#include "kinome/wide/functions.h"
#include "kinome/wide/random.h"
#include "transport/media/tracking/channels.h"
#include "transport/media/tracking/roulette.h"
#include "transport/shadows/rays.h"

namespace kinome::transport {

using namespace wide;

namespace {

/// Walks of more collisions than this become rarer, whatever rr_depth is (weight_of_length()).
constexpr uint32_t kLongWalkCollisions = 1 << 12;

/// States of a walk after a collision; kSamples: it must sample delta emitters, and then ends.
constexpr float kEnds = 0, kGoesOn = 1, kSamples = 2;

struct FourNumbers {
  Float x, y, z, w;  ///< in [0, 1)
};

/// Four random numbers (PCG4D of Jarzynski and Olano 2020).
KINOME_WIDE FourNumbers random_numbers(Uint x, Uint y, uint32_t step, uint32_t use) {
  Uint z(step), w(use);
  const auto next = [](Uint& a) { a = a * 1664525u + 1013904223u; };
  const auto mix = [&] {
    x += y * w;
    y += z * x;
    z += x * y;
    w += y * z;
  };
  next(x), next(y), next(z), next(w);
  mix();
  x = x ^ shift_right<16>(x), y = y ^ shift_right<16>(y);
  z = z ^ shift_right<16>(z), w = w ^ shift_right<16>(w);
  mix();
  return {wide::to_unit_float(x), wide::to_unit_float(y), wide::to_unit_float(z),
          wide::to_unit_float(w)};
}

}  // namespace

Walks::Walks(const SceneTable& scene, const MediaTable& media, const PathLength& length,
             size_t rays)
    : scene_(scene),
      media_(media),
      length_(length),
      arena_(media.has_walks() ? rays : kBlockLanes),
      path_(arena_.indices()),
      p_(arena_.three()),
      d_(arena_.three()),
      throughput_(arena_.three()),
      scatterings_(arena_.floats()),
      scale_(arena_.floats()),
      low_(arena_.indices()),
      high_(arena_.indices()),
      float_columns_{p_.x,          p_.y,          p_.z,          d_.x,         d_.y,  d_.z,
                     throughput_.x, throughput_.y, throughput_.z, scatterings_, scale_},
      index_columns_{path_, low_, high_},
      s_(arena_.three()),
      t_(arena_.three()),
      n_(arena_.three()),
      wo_(arena_.three()),
      u1_(arena_.floats()),
      pdf_(arena_.floats()),
      u_distance_(arena_.floats()),
      goes_on_(arena_.floats()),
      u2_(arena_.two()),
      channel_(arena_.indices()),
      rays_(arena_.ray_hits()) {}

void Walks::walk(RayHit16* rays, size_t count, const PathState& state, const PathColumns& paths,
                 const RandomSeeds& seeds, RenderCounters& counters) {
  for (uint32_t medium = 1; medium < media_.size(); ++medium) {
    if (!media_.is_walked(medium)) continue;
    begin(medium, rays, count, state, paths, seeds);
    for (uint32_t step = 0; count_ > 0; ++step) {
      collide(medium, step, rays, state, paths);
      scatter(medium, step);
      trace(medium, rays, state, paths, counters);
    }
  }
}

/// Takes over the paths that collide in a medium. They count as ended until they leave().
void Walks::begin(uint32_t medium, RayHit16* rays, size_t count, const PathState& state,
                  const PathColumns& paths, const RandomSeeds& seeds) {
  const uint32_t collision = media_.collision_shape(medium);
  count_ = 0;
  for (size_t i = 0; i < count; ++i) {
    uint32_t& shape = rays[i / kBlockLanes].shape[i % kBlockLanes];
    if (shape != collision) continue;
    shape = kNoHit;
    const size_t k = count_++;
    const Ray ray = ray_of(&rays[i / kBlockLanes].ray, i % kBlockLanes);
    path_[k] = static_cast<uint32_t>(i);
    p_.set(k, ray.at(ray.tmax));
    d_.set(k, ray.d);
    throughput_.set(k, state.throughput.at(i));
    state.throughput.set(i, kinome::Rgb(0.f));
    scatterings_[k] = state.scatterings[i];
    scale_[k] = paths.scale[i];
    // A sample may have several paths, which differ in their positions.
    const uint64_t position = std::bit_cast<uint32_t>(p_.x[k]);
    const uint64_t seed =
        hash_words(seeds.of(state.owner[i]), position << 32 | std::bit_cast<uint32_t>(p_.y[k]));
    low_[k] = static_cast<uint32_t>(seed), high_[k] = static_cast<uint32_t>(seed >> 32);
    const bool is_scattered = scatterings_[k] + 1 < static_cast<float>(length_.max_depth);
    if (paths.alpha && is_scattered) paths.alpha[state.owner[i]] = 1;
  }
}

/// Ends walks at collisions: by length, by roulette, or because they must sample emitters.
void Walks::collide(uint32_t medium, uint32_t step, RayHit16* rays, const PathState& state,
                    const PathColumns& paths) {
  const Float max_depth = static_cast<float>(length_.max_depth);
  // Roulette always applies to long walks, because nothing else may end them.
  const Float rr_depth = step < kLongWalkCollisions ? static_cast<float>(length_.rr_depth) : -1.f;
  const float share = media_.delta_share(medium);
  const Float weight =
      weight_of_length(static_cast<float>(step), static_cast<float>(kLongWalkCollisions));
  for_lanes(count_, [&](size_t i) {
    const FourNumbers u = random_numbers(Uint::load(low_ + i), Uint::load(high_ + i), step, 0);
    u.x.store(u1_ + i);
    Float goes_on = kGoesOn;
    if (share > 0) {
      const Mask samples = u.y < share;
      goes_on = select(samples, Float(kSamples), goes_on);
    }
    const Float scatterings =
        Float::load(scatterings_ + i) + select(goes_on == kGoesOn, Float(1.f));
    const wide::Rgb throughput = wide::Rgb::load(throughput_, i);
    const Float survival =
        min(max_component(throughput) * Float::load(scale_ + i) / weight, Float(1.f));
    const Mask plays = (scatterings > rr_depth) & (goes_on == kGoesOn);
    // Weights of black paths would be 0 / 0.
    const Mask ends = is_black(throughput) | (plays & !(u.z < survival)) |
                      ((goes_on == kGoesOn) & !(scatterings < max_depth));
    select(plays, throughput / survival, throughput).store(throughput_, i);
    scatterings.store(scatterings_ + i);
    select(ends, Float(kEnds), goes_on).store(goes_on_ + i);
  });
  if (share > 0) {
    const uint32_t collision = media_.collision_shape(medium);
    for (size_t i = 0; i < count_; ++i) {
      if (goes_on_[i] != kSamples) continue;
      goes_on_[i] = kEnds;
      const size_t block = path_[i] / kBlockLanes, lane = path_[i] % kBlockLanes;
      Ray ray{p_.at(i), d_.at(i)};
      ray.tmin = ray.tmax = 0;
      set_ray(rays[block].ray, lane, ray);
      rays[block].shape[lane] = collision;
      leave(i, state, paths);
    }
  }
  compact();
}

/// Samples directions.
void Walks::scatter(uint32_t medium, uint32_t step) {
  for_lanes(count_, [&](size_t i) {
    const auto frame = FrameOf<wide::Vec3>::from_normal(-wide::Vec3::load(d_, i));
    frame.s.store(s_, i), frame.t.store(t_, i), frame.n.store(n_, i);
    const FourNumbers u = random_numbers(Uint::load(low_ + i), Uint::load(high_ + i), step, 1);
    u.x.store(u2_.x + i), u.y.store(u2_.y + i);
    u.z.store(u_distance_ + i);
    draw_channel(wide::Rgb::load(throughput_, i), u.w).store(channel_ + i);
  });
  media_.medium(medium)->phase().sample_block({count_, p_, s_, t_, n_}, u1_, u2_, wo_, pdf_);
  for_lanes(count_, [&](size_t i) {
    const FrameOf<wide::Vec3> frame{wide::Vec3::load(s_, i), wide::Vec3::load(t_, i),
                                    wide::Vec3::load(n_, i)};
    frame.to_world(wide::Vec3::load(wo_, i)).store(d_, i);
  });
}

/// Traces the walks to the next collision or surface. Those that reach a surface leave().
void Walks::trace(uint32_t medium, RayHit16* rays, const PathState& state, const PathColumns& paths,
                  RenderCounters& counters) {
  const wide::Rgb extinction(media_.extinction().at(medium));
  const wide::Rgb albedo(media_.albedo().at(medium));
  const bool is_coloured = media_.medium(medium)->is_coloured();
  for_lanes(count_, [&](size_t i) {
    Ray16& ray = rays_[i / kBlockLanes].ray;
    const size_t lane = i % kBlockLanes;
    wide::Vec3::load(p_, i).store({ray.ox, ray.oy, ray.oz}, lane);
    wide::Vec3::load(d_, i).store({ray.dx, ray.dy, ray.dz}, lane);
    const Float rate = is_coloured ? component(extinction, Int::load(channel_ + i)) : extinction.x;
    // A channel without extinction never collides.
    const Float distance = -log(1.f - Float::load(u_distance_ + i)) / rate;
    select(rate > 0.f, distance, Float(kInfinity)).store(ray.tmax + lane);
  });
  disable_padding(rays_, count_);
  clear_hits(rays_, count_);
  for_lanes(count_, [&](size_t i) {
    Float::load(rays_[i / kBlockLanes].ray.tmax + i % kBlockLanes).store(u_distance_ + i);
  });
  scene_.scene().intersect(rays_, padded(count_) / kBlockLanes, Coherence::kIncoherent, counters);
  counters[RayKind::kBsdf] += count_;
  for_lanes(count_, [&](size_t i) {
    const RayHit16& block = rays_[i / kBlockLanes];
    const size_t lane = i % kBlockLanes;
    const Mask hits = Uint::load(block.shape + lane) != kNoHit;
    const Float distance = Float::load(u_distance_ + i);
    const Float end = select(hits, Float::load(block.ray.tmax + lane),
                             media_.end_of_space(block.ray, lane, hits));
    const Mask collides = (distance < end) & !hits;
    const wide::Rgb throughput = wide::Rgb::load(throughput_, i);
    const wide::Rgb weight =
        is_coloured ? segment_weight(throughput, extinction, albedo, Int::load(channel_ + i),
                                     select(collides, distance, end), collides)
                    : select(collides, albedo, wide::Rgb(1.f));
    (throughput * weight).store(throughput_, i);
    (wide::Vec3::load(p_, i) + wide::Vec3::load(d_, i) * select(collides, distance, Float(0.f)))
        .store(p_, i);
    select(collides, Float(kGoesOn), Float(kEnds)).store(goes_on_ + i);
  });
  for (size_t i = 0; i < count_; ++i) {
    if (goes_on_[i] > 0) continue;
    copy_ray_hit(rays_, i, rays, path_[i]);
    leave(i, state, paths);
  }
  compact();
}

/// Gives the path of walk i back.
void Walks::leave(size_t i, const PathState& state, const PathColumns& paths) const {
  const uint32_t k = path_[i];
  state.throughput.set(k, throughput_.at(i));
  state.scatterings[k] = scatterings_[i];
  paths.from.set(k, p_.at(i));
  paths.pdf[k] = kInfinity;
}

/// Compacts the walks that continue.
void Walks::compact() {
  size_t n = 0;
  for_lanes(count_, [&](size_t i) {
    const Mask on = (Float::load(goes_on_ + i) > 0.f) & first_lanes(count_ - i);
    size_t kept = 0;
    // The values of all columns are read before they are written behind.
    for (float* const column : float_columns_) {
      store_selected(on, Float::load(column + i), column + n);
    }
    for (uint32_t* const column : index_columns_) {
      kept = store_selected(on, Uint::load(column + i), column + n);
    }
    n += kept;
  });
  count_ = n;
}

}  // namespace kinome::transport
