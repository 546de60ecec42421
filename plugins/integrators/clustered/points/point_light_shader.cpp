#include "clustered/points/point_light_shader.h"

#include <array>

namespace kinome {
namespace {

/// Shadow rays to one call of Embree.
constexpr size_t kShadowBatch = 4096;
/// Directions to one call of a BSDF.
constexpr size_t kEvaluateBatch = 256;
/// Dimensions of the sampler that mirror reflection takes, rounded up.
constexpr uint32_t kMirrorDimensions = 4;

/// Light points as one shading point sees them.
struct Arrivals {
  std::array<float, kEvaluateBatch> x, y, z;  ///< directions, in the shading frame
  std::array<Vec3, kEvaluateBatch> d;         ///< in the world
  std::array<float, kEvaluateBatch> distance;
  std::array<Rgb, kEvaluateBatch> light;  ///< what multiplies f cos
};

void see_distant(const LightPoints& points, std::span<const uint32_t> chosen, Arrivals& out) {
  for (size_t k = 0; k < chosen.size(); ++k) {
    out.d[k] = points.position[chosen[k]];
    out.distance[k] = kInfinity;
    out.light[k] = points.power[chosen[k]];
  }
}

/// Thesis, eq. 2.2, but for the cosine at the shading point, which the BSDF brings along.
void see_local(const LightPoints& points, std::span<const uint32_t> chosen,
               const SurfaceInteraction& si, float max_geometry_term, Arrivals& out) {
  for (size_t k = 0; k < chosen.size(); ++k) {
    const uint32_t i = chosen[k];
    const Vec3 to = points.position[i] - si.p;
    const float distance2 = glm::dot(to, to);
    const float distance = std::sqrt(distance2);
    const float height = std::abs(glm::dot(si.n, to));
    // A point in the plane of the surface sends nothing to it. As rounding has moved both, this is
    // all that can be known of points that are no higher than that, and dividing by the square of
    // their distance would make much of it.
    if (!(height > si.p_error) || !(distance2 > 0)) {
      out.d[k] = si.frame.n;
      out.distance[k] = 1;
      out.light[k] = Rgb(0.f);
      continue;
    }
    const Vec3 d = to / distance;
    const float cosine = -glm::dot(points.normal[i], d);
    const bool lambertian = points.is_lambertian(i);
    Rgb intensity(0.f);
    if (cosine > 0) {
      intensity = lambertian ? points.power[i] * cosine
                             : points.emission->intensity(points.emission_id[i], -d);
    }
    if (max_geometry_term > 0) {
      const float term = std::abs(glm::dot(si.frame.n, d)) * cosine / distance2;
      if (term > max_geometry_term) intensity *= max_geometry_term / term;
    }
    out.d[k] = d;
    out.distance[k] = distance;
    out.light[k] = intensity / distance2;
    if (!lambertian && !is_black(intensity)) {
      const Vec3 way = points.origin(i, -d) - si.p;
      const float length = glm::length(way);
      if (length > 0) out.distance[k] = length, out.d[k] = way / length;
    }
  }
}

}  // namespace

PointLightShader::PointLightShader(const Scene& scene, const ScenePointLights& lights,
                                   const PointLightOptions& options, const Sampler& sampler,
                                   const PrimaryBatch& primary, std::span<Rgb> radiance,
                                   RenderCounters& counters, PointLightScratch& scratch)
    : scene_(scene),
      lights_(lights),
      options_(options),
      sampler_(sampler),
      primary_(primary),
      radiance_(radiance),
      counters_(counters),
      s_(scratch),
      evaluate_seconds_(counters.stage_seconds["evaluate"]),
      shadow_seconds_(counters.stage_seconds["shadow"]) {}

void PointLightShader::shade_all() {
  clear();  // something is left only where an earlier render on this thread threw
  for (uint32_t i = 0; i < primary_.size(); ++i) {
    if (primary_.hit(i)) shade({primary_.interaction(i), i, 1, Rgb(1.f)});
  }
  for (uint32_t depth = 2; !s_.reflected.empty(); ++depth) trace_reflected(depth);
  trace_shadow_rays();
}

void PointLightShader::shade(const Vertex& vertex) {
  const Bsdf& bsdf = vertex.si.shape->bsdf();
  if (vertex.depth < options_.max_depth && any(bsdf.lobes() & (Lobe::kDiffuse | Lobe::kGlossy))) {
    uint32_t dimension = first_dimension(vertex.depth) + kMirrorDimensions;
    for (const PointLightSet& set : lights_.sets) {
      if (vertex.depth + (set.is_indirect ? 2 : 1) <= options_.max_depth) {
        s_.selection.clear();
        set.choose(vertex.si, primary_.key(vertex.owner), dimension, counters_, s_.selection);
        const size_t chosen = s_.selection.points.size();
        for (size_t first = 0; first < chosen; first += kEvaluateBatch) {
          evaluate(vertex, set, first, std::min(kEvaluateBatch, chosen - first));
          if (s_.rays.size() >= kShadowBatch) trace_shadow_rays();
        }
      }
      dimension += kChooseDimensions;
    }
    sample_others(vertex);
  }
  if (any(bsdf.lobes() & Lobe::kDelta)) reflect(vertex);
}

uint32_t PointLightShader::first_dimension(uint32_t depth) const {
  const size_t per_vertex =
      kMirrorDimensions + kChooseDimensions * lights_.sets.size() + 2 * lights_.others.size();
  return kPrimaryDimensions + (depth - 1) * static_cast<uint32_t>(per_vertex);
}

/// Selected points [first, first + count) of a set: their reflected radiance, and a shadow ray for
/// each that has any.
void PointLightShader::evaluate(const Vertex& vertex, const PointLightSet& set, size_t first,
                                size_t count) {
  const StageTimer timer(evaluate_seconds_);
  const SurfaceInteraction& si = vertex.si;
  Arrivals in;
  const std::span<const uint32_t> chosen(s_.selection.points.data() + first, count);
  if (set.points.kind == LightPoints::Kind::kDistant) {
    see_distant(set.points, chosen, in);
  } else {
    see_local(set.points, chosen, si, options_.max_geometry_term, in);
  }
  for (size_t k = 0; k < count; ++k) {
    const Vec3 d = si.frame.to_local(in.d[k]);
    in.x[k] = d.x;
    in.y[k] = d.y;
    in.z[k] = d.z;
  }
  std::array<float, kEvaluateBatch> r, g, b;
  si.shape->bsdf().eval_pdf(si, Lobe::kDiffuse | Lobe::kGlossy,
                            {in.x.data(), in.y.data(), in.z.data(), count},
                            {r.data(), g.data(), b.data(), nullptr});
  for (size_t k = 0; k < count; ++k) {
    const Rgb reflected = Rgb(r[k], g[k], b[k]) * in.light[k];
    add_shadow_ray(vertex, in.d[k], in.distance[k], reflected * s_.selection.weights[first + k]);
  }
}

void PointLightShader::sample_others(const Vertex& vertex) {
  const uint32_t dimension = first_dimension(vertex.depth) + kMirrorDimensions +
                             kChooseDimensions * static_cast<uint32_t>(lights_.sets.size());
  SampleStream numbers(sampler_, primary_.key(vertex.owner), dimension);
  const SurfaceInteraction& si = vertex.si;
  for (const Emitter* emitter : lights_.others) {
    const auto light = emitter->sample_direct(si.p, numbers.next_2d());
    if (!light) continue;
    if (emitter->shape() == si.shape && !si.resolves(light->d, light->distance)) continue;
    const BsdfValue value =
        si.shape->bsdf().eval_pdf(si, Lobe::kDiffuse | Lobe::kGlossy, si.frame.to_local(light->d));
    add_shadow_ray(vertex, light->d, light->distance, value.f * light->radiance / light->pdf);
    if (s_.rays.size() >= kShadowBatch) trace_shadow_rays();
  }
}

void PointLightShader::reflect(const Vertex& vertex) {
  if (vertex.depth >= options_.max_depth) return;
  const SurfaceInteraction& si = vertex.si;
  SampleStream numbers(sampler_, primary_.key(vertex.owner), first_dimension(vertex.depth));
  const float u1 = numbers.next_1d();
  const auto sample = si.shape->bsdf().sample(si, Lobe::kDelta, u1, numbers.next_2d());
  if (!sample || is_black(sample->weight)) return;
  const Vec3 d = si.frame.to_world(sample->wo);
  PointLightScratch::Reflected reflected{{}, vertex.owner, vertex.weight * sample->weight};
  reflected.ray.ray.o = si.ray_origin(d);
  reflected.ray.ray.d = d;
  s_.reflected.push_back(reflected);
}

/// What mirrors show: light, and surfaces that are lit in turn.
void PointLightShader::trace_reflected(uint32_t depth) {
  std::swap(s_.traced, s_.reflected);
  s_.reflected.clear();
  s_.hits.clear();
  for (const auto& reflected : s_.traced) s_.hits.push_back(reflected.ray);
  scene_.intersect(s_.hits, Coherence::kIncoherent, counters_);
  counters_[RayKind::kBsdf] += s_.hits.size();
  for (size_t k = 0; k < s_.traced.size(); ++k) {
    const RayHit& ray = s_.hits[k];
    const auto& [unused, owner, weight] = s_.traced[k];
    if (!ray.hit.valid()) {
      if (const Emitter* e = scene_.environment()) {
        radiance_[owner] += weight * e->eval_environment(ray.ray.d);
      }
      continue;
    }
    const SurfaceInteraction si = scene_.interaction(ray);
    if (const Emitter* e = si.shape->emitter()) radiance_[owner] += weight * e->eval_surface(si);
    shade({si, owner, depth, weight});
  }
  s_.traced.clear();
}

void PointLightShader::add_shadow_ray(const Vertex& vertex, const Vec3& d, float distance,
                                      const Rgb& contribution) {
  if (is_black(contribution)) {
    ++counters_.skipped_shadow_rays;
    return;
  }
  s_.rays.push_back(vertex.si.shadow_ray(d, distance));
  s_.owner.push_back(vertex.owner);
  s_.contribution.push_back(contribution * vertex.weight);
}

void PointLightShader::trace_shadow_rays() {
  const StageTimer timer(shadow_seconds_);
  scene_.occluded(s_.rays, Coherence::kIncoherent, counters_);
  counters_[RayKind::kShadow] += s_.rays.size();
  for (size_t k = 0; k < s_.rays.size(); ++k) {
    if (!s_.rays[k].is_occluded()) radiance_[s_.owner[k]] += s_.contribution[k];
  }
  s_.rays.clear();
  s_.owner.clear();
  s_.contribution.clear();
}

void PointLightShader::clear() {
  s_.rays.clear();
  s_.owner.clear();
  s_.contribution.clear();
  s_.reflected.clear();
  s_.traced.clear();
}

}  // namespace kinome
