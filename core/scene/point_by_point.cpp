#include "scene/point_by_point.h"

#include <algorithm>
#include <cmath>

#include "kinome/block_points.h"
#include "kinome/bsdf.h"
#include "kinome/emitter.h"
#include "kinome/reconstruction_filter.h"
#include "kinome/sampler.h"
#include "kinome/sensor.h"
#include "kinome/shape.h"
#include "kinome/texture.h"

/// Default implementations of block functions, for plugins that implement only the functions for
/// single points: loops over the points.
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

void set_point(const SurfaceBlock& points, size_t i, const SurfaceInteraction& si) {
  points.p.set(i, si.p);
  points.n.set(i, si.n);
  points.s.set(i, si.frame.s);
  points.t.set(i, si.frame.t);
  points.sn.set(i, si.frame.n);
  if (points.dp_du.x) points.dp_du.set(i, si.dp_du);
  if (points.dp_dv.x) points.dp_dv.set(i, si.dp_dv);
  points.wi.set(i, si.wi);
  points.uv.set(i, si.uv);
  points.p_error[i] = si.p_error;
  points.primitive[i] = si.primitive;
}

PointBlock::PointBlock(const SurfaceInteraction& si) {
  size_t used = 0;
  const auto one = [&] { return columns_[used++]; };
  const auto three = [&] { return Columns3{one(), one(), one()}; };
  block_ = {1,       three(), three(),        three(), three(),     three(),     three(),
            three(), three(), {one(), one()}, one(),   indices_[0], indices_[1], shapes_};
  set_point(block_, 0, si);
  std::fill_n(shapes_, kBlockLanes, si.shape);
}

void Bsdf::shade_block(const SurfaceBlock& points, const BsdfQuery& query,
                       const BsdfAnswer& answer) const {
  UpperHalves::clear();
  for (size_t i = 0; i < points.count; ++i) {
    const SurfaceInteraction si = interaction_of(points, i);
    if (query.wo.x) {
      const BsdfValue value = eval_pdf(si, query.lobes, query.wo.at(i));
      answer.f.set(i, value.f);
      answer.pdf[i] = value.pdf;
    }
    if (query.u1) {
      const BsdfSample s =
          sample(si, query.lobes, query.u1[i], query.u2.at(i)).value_or(BsdfSample{});
      answer.wo.set(i, s.wo);
      answer.weight.set(i, s.weight);
      answer.sample_pdf[i] = s.pdf;
      answer.is_delta[i] = any(s.lobe & Lobe::kNull)    ? kNullSample
                           : any(s.lobe & Lobe::kDelta) ? 1.f
                                                        : 0.f;
    }
  }
}

void Bsdf::null_transmission_block(const SurfaceBlock& points,
                                   const NullTransmissionBlock& out) const {
  UpperHalves::clear();
  for (size_t i = 0; i < points.count; ++i) {
    const NullTransmission through = null_transmission(interaction_of(points, i));
    out.transmittance.set(i, through.transmittance);
    out.probability[i] = through.probability;
  }
}

uint32_t BsdfFormKinds::number_of(const BsdfForm& form) {
  for (size_t k = 0; k < kinds_.size(); ++k) {
    if (kinds_[k].same_kind(form)) return static_cast<uint32_t>(k + 1);
  }
  if (kinds_.size() == kMaxKinds) return kNone;
  kinds_.push_back(form);
  return static_cast<uint32_t>(kinds_.size());
}

void Bsdf::describe_block(const SurfaceBlock& points, const BsdfFormBlock& out) const {
  UpperHalves::clear();
  for (size_t i = 0; i < points.count; ++i) {
    const Frame frame = reflection_frame(interaction_of(points, i));
    out.normal.set(i, frame.n);
    out.tangent.set(i, frame.s);
    describe_by_colours(points, i, out);
  }
}

void Bsdf::describe_by_colours(const SurfaceBlock& points, size_t i,
                               const BsdfFormBlock& out) const {
  const LobeReflectance colours = reflectance(interaction_of(points, i));
  out.diffuse.set(i, colours.diffuse);
  out.specular.set(i, colours.glossy);
  out.kind[i] = BsdfFormKinds::kNone;
}

std::optional<BsdfForm> Bsdf::form(const SurfaceInteraction& si) const {
  const PointBlock point(si);
  alignas(kColumnAlignment) float columns[18][kBlockLanes];
  alignas(kColumnAlignment) uint32_t kind[kBlockLanes];
  const auto three = [&](size_t k) {
    return Columns3{columns[k], columns[k + 1], columns[k + 2]};
  };
  BsdfFormKinds kinds;
  const BsdfFormBlock out{three(0),    three(3),  three(6),    three(9), columns[12],
                          columns[13], three(14), columns[17], kind,     &kinds};
  describe_block(point.block(), out);
  if (kind[0] == BsdfFormKinds::kNone) return std::nullopt;
  BsdfForm form = kinds[kind[0]];
  form.diffuse = out.diffuse.at(0), form.specular = out.specular.at(0);
  form.alpha_u = out.alpha_u[0], form.alpha_v = out.alpha_v[0];
  if (form.has_perturbed_normal) {
    form.surface_normal = out.surface_normal.at(0);
    form.bump_alpha2 = out.bump_alpha2[0];
  }
  return form;
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
    set_ray(out[i / 16].ray, i % 16, sample_ray(film_position.at(i), aperture.at(i)));
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

void Texture::eval_1_gradient_block(const Columns2& uv, size_t count, const Columns2& out) const {
  UpperHalves::clear();
  for (size_t i = 0; i < count; ++i) out.set(i, eval_1_gradient(uv.at(i)));
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

void Shape::interaction_block(const RayHit16* rays, const SurfaceBlock& out) const {
  UpperHalves::clear();
  for (size_t i = 0; i < out.count; ++i) {
    const RayHit hit = ray_hit_of(rays, out.ray[i]);
    set_point(out, i, interaction(hit.ray, hit.hit));
  }
}

void Shape::sample_surface_block(const Columns2& u, const SurfaceBlock& out) const {
  UpperHalves::clear();
  for (size_t i = 0; i < out.count; ++i) set_point(out, i, sample_surface(u.at(i)));
}

void Shape::sample_solid_angle_block(const Columns3& p, const Columns2& u, size_t count,
                                     const SurfaceSampleBlock& out) const {
  UpperHalves::clear();
  for (size_t i = 0; i < count; ++i) {
    const SurfaceSample s = sample_solid_angle(p.at(i), u.at(i)).value_or(SurfaceSample{});
    out.p.set(i, s.si.p);
    out.sn.set(i, s.si.frame.n);
    if (out.uv.x) out.uv.set(i, s.si.uv);
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
