#include "kinome/medium.h"

#include <algorithm>
#include <stdexcept>

#include "kinome/block_points.h"
#include "scene/point_by_point.h"

/// Default implementations of volumes, phase functions and media.
namespace kinome {

void Volume::eval_block(const Columns3& p, size_t count, float* const* values) const {
  UpperHalves::clear();
  float at_point[kMaxChannels];
  for (size_t i = 0; i < count; ++i) {
    eval(p.at(i), at_point);
    for (uint32_t c = 0; c < channels(); ++c) values[c][i] = at_point[c];
  }
}

void Volume::extremes(const BlockGrid& blocks, float* lo, float* hi) const {
  std::fill_n(lo, blocks.count(), min());
  std::fill_n(hi, blocks.count(), max());
}

void Volume::integral_block(const Columns3& o, const Columns3& /*d*/, const float* length,
                            size_t count, float* const* values) const {
  if (!is_uniform()) throw std::logic_error("Volume::integral_block() is missing");
  eval_block(o, count, values);
  for (uint32_t c = 0; c < channels(); ++c) {
    for (size_t i = 0; i < count; ++i) values[c][i] *= length[i];
  }
}

Rgb Volume::color(const Vec3& p) const {
  float values[kMaxChannels];
  eval(p, values);
  return channels() == 1 ? Rgb(values[0]) : Rgb(values[0], values[1], values[2]);
}

void Volume::color_block(const Columns3& p, size_t count, const Columns3& out) const {
  float* const columns[kMaxChannels] = {out.x, out.y, out.z};
  eval_block(p, count, columns);
  if (channels() > 1) return;
  if (out.y != out.x) std::copy_n(out.x, count, out.y);
  if (out.z != out.x) std::copy_n(out.x, count, out.z);
}

UniformVolume::UniformVolume(const Rgb& value, const Aabb& box)
    : value_(value), box_(box), channels_(value.x == value.y && value.y == value.z ? 1 : 3) {}

void UniformVolume::eval(const Vec3& /*p*/, float* values) const {
  for (uint32_t c = 0; c < channels_; ++c) values[c] = value_[static_cast<int>(c)];
}

void UniformVolume::eval_block(const Columns3& /*p*/, size_t count, float* const* values) const {
  for (uint32_t c = 0; c < channels_; ++c) {
    std::fill_n(values[c], count, value_[static_cast<int>(c)]);
  }
}

void Phase::eval_block(const MediumPointBlock& points, const Columns3& wo, float* value) const {
  UpperHalves::clear();
  for (size_t i = 0; i < points.count; ++i) value[i] = eval(points.at(i), wo.at(i));
}

void Phase::sample_block(const MediumPointBlock& points, const float* u1, const Columns2& u2,
                         const Columns3& wo, float* pdf) const {
  UpperHalves::clear();
  for (size_t i = 0; i < points.count; ++i) {
    const PhaseSample drawn = sample(points.at(i), u1[i], u2.at(i));
    wo.set(i, drawn.wo);
    pdf[i] = drawn.pdf;
  }
}

void Phase::projected_area_block(const Columns3& p, const Columns3& d, size_t count,
                                 float* area) const {
  UpperHalves::clear();
  for (size_t i = 0; i < count; ++i) area[i] = projected_area(p.at(i), d.at(i));
}

PhaseBsdf::PhaseBsdf(const Phase& phase) : phase_(phase) {
  lobes_ = Lobe::kGlossy;
  transmits_ = true;
  has_rough_transmission_ = true;
}

BsdfValue PhaseBsdf::eval_pdf(const SurfaceInteraction& si, Lobe mask, const Vec3& wo) const {
  if (!any(mask & lobes_)) return {};
  const float value = phase_.eval({si.p, si.frame}, wo);
  return {Rgb(value), value};
}

std::optional<BsdfSample> PhaseBsdf::sample(const SurfaceInteraction& si, Lobe mask, float u1,
                                            const Vec2& u2) const {
  if (!any(mask & lobes_)) return std::nullopt;
  const PhaseSample drawn = phase_.sample({si.p, si.frame}, u1, u2);
  if (!(drawn.pdf > 0)) return std::nullopt;
  return BsdfSample{drawn.wo, drawn.pdf, Rgb(1.f), Lobe::kGlossy};
}

LobeReflectance PhaseBsdf::reflectance(const SurfaceInteraction& /*si*/) const {
  return {Rgb(0.f), Rgb(1.f)};
}

void PhaseBsdf::shade_block(const SurfaceBlock& points, const BsdfQuery& query,
                            const BsdfAnswer& answer) const {
  const bool is_wanted = any(query.lobes & lobes_);
  const MediumPointBlock at{points.count, points.p, points.s, points.t, points.sn};
  if (query.wo.x) {
    if (is_wanted) phase_.eval_block(at, query.wo, answer.pdf);
    if (!is_wanted) std::fill_n(answer.pdf, points.count, 0.f);
    for (float* const channel : {answer.f.x, answer.f.y, answer.f.z}) {
      std::copy_n(answer.pdf, points.count, channel);
    }
  }
  if (!query.u1) return;
  std::fill_n(answer.is_delta, points.count, 0.f);
  if (is_wanted) {
    phase_.sample_block(at, query.u1, query.u2, answer.wo, answer.sample_pdf);
  } else {
    std::fill_n(answer.sample_pdf, points.count, 0.f);
    for (size_t i = 0; i < points.count; ++i) answer.wo.set(i, Vec3(0, 0, 1));
  }
  for (size_t i = 0; i < points.count; ++i) {
    answer.weight.set(i, Vec3(answer.sample_pdf[i] > 0 ? 1.f : 0.f));
  }
}

void Medium::coefficients_block(const Columns3& p, const Columns3& d, size_t count,
                                const MediumBlock& out) const {
  UpperHalves::clear();
  for (size_t i = 0; i < count; ++i) {
    const auto at = coefficients(p.at(i), d.x ? d.at(i) : Vec3(0, 0, 1));
    out.extinction.set(i, at.extinction);
    if (out.scattering.x) out.scattering.set(i, at.scattering);
  }
}

void Medium::extremes(const BlockGrid& blocks, float* lo, float* hi) const {
  std::fill_n(lo, blocks.count(), min_extinction_);
  std::fill_n(hi, blocks.count(), max_extinction_);
}

void Medium::optical_depth_block(const Columns3&, const Columns3&, const float*, size_t,
                                 const Columns3&) const {
  throw std::logic_error("Medium::optical_depth_block() is missing");
}

}  // namespace kinome
