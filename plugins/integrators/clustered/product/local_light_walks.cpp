// The part of LocalLight that follows light from its sources and leaves points where it comes to.
#include <algorithm>
#include <cmath>

#include "clustered/product/light_point_draw.h"
#include "clustered/product/local_light.h"
#include "clustered/product/patches.h"
#include "clustered/product/spread.h"
#include "kinome/render_context.h"
#include "transport/adjoint.h"

namespace kinome {
namespace {

constexpr uint64_t kSeedOfWalks = 0x77616c6b;
/// A path that loses nothing ends by roulette all the same.
constexpr float kMostSurvival = 0.95f;

}  // namespace

void LocalLight::draw_part(bool bounce, uint32_t count, uint64_t seed, RenderContext& context,
                           std::vector<Drawn>& chunks) const {
  constexpr uint32_t kChunk = 1024;
  const uint32_t parts = (count + kChunk - 1) / kChunk;
  const size_t before = chunks.size();
  chunks.resize(before + parts);
  const LightGuide& guide = bounce ? bounce_guide_ : surface_guide_;
  const std::vector<double>& unguided = bounce ? bounce_ends_ : surface_ends_;
  const Turns turns(guide.empty() ? unguided : guide.ends(), count, seed);
  context.parallel_for(parts, [&](size_t c) {
    const auto begin = static_cast<uint32_t>(c) * kChunk;
    Drawn& out = chunks[before + c];
    for (uint32_t i = begin; i < std::min(begin + kChunk, count); ++i) {
      const Turns::Turn turn = turns[i];
      const Source& source = sources_[turn.source];
      const LightNumbers numbers(hash_words(seed, turn.source));
      LightOrigin origin = numbers.origin(turn.source, turn.number);
      origin.guided = guide.warp(turn.source, origin.numbers);
      if (bounce) {
        auto leaving = leave_light(*source.emitter, origin.position(), origin.direction());
        if (!leaving || is_black(leaving->sample.power)) continue;
        out.rays.push_back({leaving->sample.ray(), Hit{}});
        LightWalk& walk = out.walks.emplace_back();
        walk.origin = origin;
        walk.seed = hash_words(seed, kSeedOfWalks, i);
        walk.d = leaving->sample.d;
        walk.power = leaving->sample.power;
        walk.x = leaving->x;
      } else {
        add_surface_point(origin, out);
      }
    }
    while (!out.rays.empty()) walk_on(out);
  });
  for (size_t c = before; c < chunks.size(); ++c) context.stats().counters.add(chunks[c].counters);
}

/// Traces the walks' edges; those that go on are left in their place.
void LocalLight::walk_on(Drawn& out) const {
  scene_.intersect(out.rays, Coherence::kIncoherent, out.counters);
  out.counters[RayKind::kLight] += out.rays.size();
  const std::vector<RayHit> rays = std::move(out.rays);
  const std::vector<LightWalk> walks = std::move(out.walks);
  out.rays.clear();
  out.walks.clear();
  for (size_t k = 0; k < rays.size(); ++k) {
    if (!rays[k].hit.valid()) continue;
    const SurfaceInteraction si = scene_.interaction(rays[k]);
    land(walks[k], si, rays[k].ray.tmax, out);
    // With the next edge, that to the eye's surface point and the one to the camera.
    if (walks[k].edges + 3 <= max_depth()) go_on(walks[k], si, out);
  }
}

/// With what it loses, by roulette, so that all points of a source have about as much light.
void LocalLight::go_on(const LightWalk& walk, const SurfaceInteraction& si, Drawn& out) const {
  const uint64_t seed = hash_words(walk.seed, walk.edges);
  const auto sample = transport::sample_adjoint(si, Lobe::kAll, random_float(seed, 0),
                                                Vec2(random_float(seed, 1), random_float(seed, 2)));
  if (!sample || is_black(sample->weight)) return;
  const float survival = std::min(
      kMostSurvival, max_component(walk.power * sample->weight) / max_component(walk.power));
  if (!(random_float(seed, 3) < survival)) return;
  LightWalk next;
  next.origin = walk.origin;
  next.seed = walk.seed;
  next.edges = walk.edges + 1;
  next.d = sample->to;
  next.power = walk.power * sample->weight / survival;
  const bool is_lamps = sources_[walk.origin.source].kind == Kind::kLamp;
  next.is_shown = walk.edges == 1 ? sample->is_delta && !is_lamps : walk.is_shown;
  next.is_hidden = sample->is_delta && (walk.edges == 1 ? is_lamps : walk.is_hidden);
  Ray ray;
  ray.d = next.d;
  ray.o = si.ray_origin(ray.d);
  out.rays.push_back({ray, Hit{}});
  out.walks.push_back(next);
}

void LocalLight::land(const LightWalk& walk, const SurfaceInteraction& si, float distance,
                      Drawn& out) const {
  const Bsdf& bsdf = si.shape->bsdf();
  if (walk.is_hidden || !any(bsdf.lobes() & (Lobe::kDiffuse | Lobe::kGlossy))) return;
  const float cosine = std::abs(glm::dot(si.n, walk.d));
  if (!(cosine > 0)) return;
  const Source& source = sources_[walk.origin.source];
  const float count = static_cast<float>(bounce_count_) * source.bounce_share * walk.origin.guided;
  const SurfaceInteraction* const x = walk.x ? &*walk.x : nullptr;
  const bool is_deep = walk.edges > 1;
  Reflection reflection;
  reflection.si = si;
  reflection.to_light = si.wi;
  reflection.incident = walk.power / (count * cosine);
  const float side = si.wi.z >= 0 ? 1.f : -1.f;
  const float probability = is_deep ? 0 : asked_at(si, side).probability(walk.origin.source);
  // The reflectance that is seen from the light's side.
  reflection.si.wi = Vec3(0, 0, side);
  LightPoint point;
  if (bsdf.is_lambertian()) {
    point.power =
        bsdf.eval_pdf(reflection.si, Lobe::kDiffuse, reflection.to_light).f * reflection.incident;
  } else {
    reflection.light = -walk.d;
    reflection.normal = bsdf.reflection_frame(si).n;
    // The back of a surface that has but one side.
    if (!(glm::dot(reflection.normal, reflection.light) > 0)) return;
    const bool is_lamp = source.kind == Kind::kLamp && !is_deep;
    const LobeWidth width = is_lamp && !finds_caustics_ ? LobeWidth::kWide : lobe_width(si);
    LobeReflectance& part = reflection.reflectance;
    part = bsdf.reflectance(reflection.si);
    bool is_left_to_rays = false;
    if (width == LobeWidth::kMirroring) {
      (is_lamp ? out.lamp_meets_mirroring : out.meets_mirroring) = true;
      is_left_to_rays = !is_lamp || has_glossy_caustics_;
    }
    if (is_left_to_rays) {
      reflection.lobes = Lobe::kDiffuse;
      part.glossy = Rgb(0.f);
    } else {
      const simd::HalfVectorLobe lobe = glossy_lobe(si, bsdf.form(si));
      reflection.alpha2 = lobe.alpha_u * lobe.alpha_v;
      if (width == LobeWidth::kNarrow && !is_lamp) {
        reflection.light_density =
            is_deep ? kDeepDensity : probability * arrival_density(*source.emitter, x, si, -walk.d);
      }
    }
    point.power = (part.diffuse + part.glossy) * kInvPi * std::abs(si.wi.z) * reflection.incident;
  }
  if (is_black(point.power)) return;
  point.edges = walk.edges;
  point.is_plain = is_plain(si);
  point.is_shown = walk.is_shown;
  // Off the surface: a ray that comes along it would else meet it just before its end.
  point.position = si.ray_origin(-walk.d);
  point.normal = si.frame.n * side;
  point.geometric = glm::dot(si.n, walk.d) > 0 ? -si.n : si.n;
  if (std::abs(glm::dot(si.n, si.frame.n)) < 1 - 1e-6f) point.off_surface = si.p_error;
  if (bounce_partition_.size() > 0) {
    point.cell = bounce_cell(si, side);
    point.eye_ratio = is_deep ? deep_ratios_[point.cell]
                              : eye_factors_[point.cell] *
                                    eye_ratio(source, probability, x, si, walk.d, distance);
    if (walk.is_shown && lobe_width(si) == LobeWidth::kWide) point.eye_ratio *= kShownEyeShare;
  }
  if (!bsdf.is_lambertian()) {
    point.reflection = static_cast<uint32_t>(out.reflections.size());
    out.reflections.push_back(reflection);
  }
  out.points.push_back(point);
  out.origins.push_back(walk.origin);
  out.is_deep.push_back(is_deep ? 1 : 0);
}

}  // namespace kinome
