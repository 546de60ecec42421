#include "scene/point_by_point.h"

#include <cmath>

#include "kinome/block_points.h"
#include "kinome/bsdf.h"
#include "kinome/emitter.h"
#include "kinome/reconstruction_filter.h"
#include "kinome/sampler.h"
#include "kinome/sensor.h"
#include "kinome/shape.h"
#include "kinome/texture.h"

/// What blocks are for plugins that have but functions of single points: loops over those.
namespace kinome {

SurfaceInteraction interaction_of(const SurfaceBlock& block, size_t i) {
  SurfaceInteraction si;
  si.p = block.p.at(i);
  si.p_error = block.p_error[i];
  si.n = block.n.at(i);
  si.frame = {block.s.at(i), block.t.at(i), block.sn.at(i)};
  si.dp_du = block.dp_du.x ? block.dp_du.at(i) : si.frame.s;
  si.dp_dv = block.dp_dv.x ? block.dp_dv.at(i) : si.frame.t;
  si.uv = block.uv.at(i);
  si.wi = block.wi.at(i);
  si.primitive = block.primitive[i];
  si.shape = block.shape[i];
  return si;
}

void Bsdf::shade_block(const SurfaceBlock& points, const BsdfQuery& query,
                       const BsdfAnswer& answer) const {
  UpperHalves::clear();
  for (size_t i = 0; i < points.count; ++i) {
    const SurfaceInteraction si = interaction_of(points, i);
    if (query.wo.x) {
      eval_pdf(si, query.lobes, DirectionBatch{query.wo.x + i, query.wo.y + i, query.wo.z + i, 1},
               BsdfValueBatch{answer.f.x + i, answer.f.y + i, answer.f.z + i, answer.pdf + i});
    }
    if (query.u1) {
      const BsdfSample s =
          sample(si, query.lobes, query.u1[i], query.u2.at(i)).value_or(BsdfSample{});
      answer.wo.set(i, s.wo);
      answer.weight.set(i, s.weight);
      answer.sample_pdf[i] = s.pdf;
      answer.is_delta[i] = any(s.lobe & Lobe::kDelta) ? 1.f : 0.f;
    }
  }
}

uint32_t BsdfFormKinds::number_of(const BsdfForm& form) {
  for (size_t k = 0; k < kinds_.size(); ++k) {
    if (kinds_[k].same_kind(form)) return static_cast<uint32_t>(k + 1);
  }
  if (kinds_.size() == kMost) return kNone;
  kinds_.push_back(form);
  return static_cast<uint32_t>(kinds_.size());
}

void Bsdf::describe_block(const SurfaceBlock& points, const BsdfFormBlock& out) const {
  UpperHalves::clear();
  for (size_t i = 0; i < points.count; ++i) {
    const SurfaceInteraction si = interaction_of(points, i);
    const Frame frame = reflection_frame(si);
    out.normal.set(i, frame.n);
    out.tangent.set(i, frame.s);
    const std::optional<BsdfForm> found = form(si);
    out.kind[i] = found ? out.kinds->number_of(*found) : BsdfFormKinds::kNone;
    if (out.kind[i] == BsdfFormKinds::kNone) {
      const LobeReflectance colours = reflectance(si);
      out.diffuse.set(i, colours.diffuse);
      out.specular.set(i, colours.glossy);
      continue;
    }
    out.diffuse.set(i, found->diffuse);
    out.specular.set(i, found->specular);
    out.alpha_u[i] = found->alpha_u;
    out.alpha_v[i] = found->alpha_v;
    out.surface_normal.set(i, found->surface_normal);
    out.bump_alpha2[i] = found->bump_alpha2;
  }
}

void Emitter::sample_direct_block(const Columns3& p, const Columns2& u, size_t count,
                                  const DirectBlock& out) const {
  UpperHalves::clear();
  for (size_t i = 0; i < count; ++i) {
    const DirectSample s = sample_direct(p.at(i), u.at(i)).value_or(DirectSample{});
    out.d.set(i, s.d);
    out.radiance.set(i, s.radiance);
    out.distance[i] = s.distance;
    out.pdf[i] = s.pdf;
    out.is_delta[i] = s.is_delta ? 1.f : 0.f;
  }
}

void Emitter::eval_environment_block(const Columns3& d, size_t count, const Columns3& radiance,
                                     float* pdf) const {
  UpperHalves::clear();
  for (size_t i = 0; i < count; ++i) {
    radiance.set(i, eval_environment(d.at(i)));
    if (pdf) pdf[i] = pdf_environment(d.at(i));
  }
}

void Emitter::eval_surface_block(const SurfaceBlock& points, const Columns3& from,
                                 const Columns3& radiance, float* pdf) const {
  UpperHalves::clear();
  for (size_t i = 0; i < points.count; ++i) {
    const SurfaceInteraction si = interaction_of(points, i);
    radiance.set(i, eval_surface(si));
    if (pdf) pdf[i] = pdf_surface(from.at(i), si);
  }
}

void Emitter::sample_emission_block(const Columns2& position, const Columns2& direction,
                                    size_t count, const EmissionBlock& out) const {
  UpperHalves::clear();
  for (size_t i = 0; i < count; ++i) {
    const EmissionSample s =
        sample_emission(position.at(i), direction.at(i)).value_or(EmissionSample{});
    const Ray ray = s.ray();
    out.o.set(i, ray.o);
    out.d.set(i, ray.d);
    out.power.set(i, s.power);
  }
}

void Sensor::connect_block(const Columns3& p, const Columns2& aperture, size_t count,
                           const ConnectionBlock& out) const {
  UpperHalves::clear();
  for (size_t i = 0; i < count; ++i) {
    const SensorConnection c = connect(p.at(i), aperture.at(i)).value_or(SensorConnection{});
    out.film_position.set(i, c.film_position);
    out.d.set(i, c.d);
    out.distance[i] = c.distance;
    out.weight[i] = c.weight;
  }
}

void Sensor::sample_ray_block(const Columns2& film_position, const Columns2& aperture, size_t count,
                              RayHit16* out) const {
  UpperHalves::clear();
  for (size_t i = 0; i < count; ++i) {
    const Ray ray = sample_ray(film_position.at(i), aperture.at(i));
    Ray16& to = out[i / 16].ray;
    const size_t lane = i % 16;
    Columns3{to.ox, to.oy, to.oz}.set(lane, ray.o);
    Columns3{to.dx, to.dy, to.dz}.set(lane, ray.d);
    to.tmin[lane] = ray.tmin;
    to.tmax[lane] = ray.tmax;
  }
}

void Sampler::fill_1d_block(const PixelSamples& samples, uint32_t dimension, float* out) const {
  UpperHalves::clear();
  for (size_t p = 0; p < samples.pixels; ++p) {
    SampleKey key{samples.x[p], samples.y[p], samples.first_sample, samples.seed};
    for (uint32_t s = 0; s < samples.samples; ++s, ++key.sample) *out++ = value_1d(key, dimension);
  }
}

void Sampler::fill_2d_block(const PixelSamples& samples, uint32_t dimension,
                            const Columns2& out) const {
  UpperHalves::clear();
  size_t i = 0;
  for (size_t p = 0; p < samples.pixels; ++p) {
    SampleKey key{samples.x[p], samples.y[p], samples.first_sample, samples.seed};
    for (uint32_t s = 0; s < samples.samples; ++s, ++key.sample) {
      out.set(i++, value_2d(key, dimension));
    }
  }
}

void Texture::eval_block(const Columns2& uv, size_t count, const Columns3& out) const {
  UpperHalves::clear();
  for (size_t i = 0; i < count; ++i) out.set(i, eval(uv.at(i)));
}

void Texture::eval_1_block(const Columns2& uv, size_t count, float* out) const {
  UpperHalves::clear();
  for (size_t i = 0; i < count; ++i) out[i] = eval_1(uv.at(i));
}

void ReconstructionFilter::eval_block(const float* x, size_t count, float* out) const {
  UpperHalves::clear();
  for (size_t i = 0; i < count; ++i) out[i] = eval(x[i]);
}

void Shape::intersect_block(const Ray16& rays, const int* valid, ShapeHit16& out) const {
  UpperHalves::clear();
  for (size_t i = 0; i < 16; ++i) {
    out.t[i] = kInfinity;
    if (valid[i] == 0) continue;
    const Ray ray = ray_of(&rays, i);
    float t = 0;
    Hit hit;
    if (!intersect(ray, t, hit) || !(t >= ray.tmin && t <= ray.tmax)) continue;
    out.t[i] = t;
    Columns3{out.ngx, out.ngy, out.ngz}.set(i, hit.ng);
    out.u[i] = hit.u;
    out.v[i] = hit.v;
    out.primitive[i] = hit.primitive == kNoHit ? 0 : hit.primitive;
  }
}

namespace {

/// What interaction_of() reads, but for the shape.
void store(const SurfaceInteraction& si, const SurfaceBlock& out, size_t i) {
  out.p.set(i, si.p);
  out.n.set(i, si.n);
  out.s.set(i, si.frame.s);
  out.t.set(i, si.frame.t);
  out.sn.set(i, si.frame.n);
  if (out.dp_du.x) out.dp_du.set(i, si.dp_du);
  if (out.dp_dv.x) out.dp_dv.set(i, si.dp_dv);
  out.wi.set(i, si.wi);
  out.uv.set(i, si.uv);
  out.p_error[i] = si.p_error;
  out.primitive[i] = si.primitive;
}

}  // namespace

void Shape::interaction_block(const RayHit16* rays, const SurfaceBlock& out) const {
  UpperHalves::clear();
  for (size_t i = 0; i < out.count; ++i) {
    const RayHit hit = ray_hit_of(rays, out.ray[i]);
    store(interaction(hit.ray, hit.hit), out, i);
  }
}

void Shape::sample_surface_block(const Columns2& u, const SurfaceBlock& out) const {
  UpperHalves::clear();
  for (size_t i = 0; i < out.count; ++i) store(sample_surface(u.at(i)), out, i);
}

void Shape::sample_solid_angle_block(const Columns3& p, const Columns2& u, size_t count,
                                     const SurfaceSampleBlock& out) const {
  UpperHalves::clear();
  for (size_t i = 0; i < count; ++i) {
    const SurfaceSample s = sample_solid_angle(p.at(i), u.at(i)).value_or(SurfaceSample{});
    out.p.set(i, s.si.p);
    out.sn.set(i, s.si.frame.n);
    out.uv.set(i, s.si.uv);
    out.pdf[i] = s.pdf;
  }
}

void Shape::pdf_solid_angle_block(const Columns3& p, const SurfaceBlock& points,
                                  float* pdf) const {
  UpperHalves::clear();
  for (size_t i = 0; i < points.count; ++i) {
    pdf[i] = pdf_solid_angle(p.at(i), interaction_of(points, i));
  }
}

}  // namespace kinome
