#include "batch.h"
#include "kinome/plugin.h"

/// A surface with holes, or a partly transparent one. A fraction `opacity` of the light is
/// scattered by the nested BSDF; the rest goes straight through, from both sides. The nested BSDF
/// may be smooth glass, which refracts the light.
///
///     <bsdf type="mask">
///       <texture type="bitmap" name="opacity"><string name="filename" value="leaf.png"/></texture>
///       <bsdf type="twosided"><bsdf type="diffuse"/></bsdf>
///     </bsdf>
namespace kinome {
namespace {

constexpr Parameter kParameters[] = {
    {"opacity", ParameterType::kUnitlessTexture, "0.5",
     "fraction of light that the nested BSDF scatters, clamped to [0,1]"},
    {"bsdf", ParameterType::kObject, nullptr, "BSDF of the opaque part", true, Category::kBsdf},
};

class OpacityMask final : public Bsdf {
 public:
  explicit OpacityMask(const Properties& props)
      : opacity_(props.texture("opacity")), nested_(props.object<Bsdf>()) {
    lobes_ = nested_->lobes() | Lobe::kDelta;
    turns_to_viewer_ = nested_->turns_to_viewer();
    transmits_ = true;
    has_null_lobe_ = true;
    has_rough_transmission_ = nested_->has_rough_transmission();
    relative_index_ = nested_->relative_index();
  }

  BsdfValue eval_pdf(const SurfaceInteraction& si, Lobe mask, const Vec3& wo) const override {
    BsdfValue value = nested_->eval_pdf(si, mask, wo);
    const float opacity = clamped_share(opacity_.at(si));
    value.f *= opacity;
    value.pdf *= nested_probability(mask, opacity);
    if (!(value.pdf > 0)) return {};
    return value;
  }

  std::optional<BsdfSample> sample(const SurfaceInteraction& si, Lobe mask, float u1,
                                   const Vec2& u2) const override {
    const float opacity = clamped_share(opacity_.at(si));
    const float probability = nested_probability(mask, opacity);
    if (!(u1 < probability)) {
      if (!any(mask & Lobe::kDelta)) return std::nullopt;
      return BsdfSample{-si.wi, 1, Rgb((1 - opacity) / (1 - probability)),
                        Lobe::kDelta | Lobe::kNull};
    }
    auto sample = nested_->sample(si, mask, std::min(u1 / probability, kOneMinusEpsilon), u2);
    if (!sample) return std::nullopt;
    sample->weight *= opacity / probability;
    if (!any(sample->lobe & Lobe::kDelta)) sample->pdf *= probability;
    return sample;
  }

  void shade_block(const SurfaceBlock& points, const BsdfQuery& query,
                   const BsdfAnswer& answer) const override {
    using wide::Float;
    const NumberInput::Columns opacities(opacity_, points);
    const wide::ScratchColumns columns(1, points.count);
    BsdfQuery nested_query = query;
    if (query.u1) {
      nested_query.u1 = columns[0];
      wide::for_lanes(points.count, [&](size_t i) {
        const Float probability = nested_probability(query.lobes, clamped_share(opacities[i]));
        min(Float::load(query.u1 + i) / max(probability, Float(1e-30f)), Float(kOneMinusEpsilon))
            .store(columns[0] + i);
      });
    }
    nested_->shade_block(points, nested_query, answer);
    wide::for_lanes(points.count, [&](size_t i) {
      const Float opacity = clamped_share(opacities[i]);
      const Float probability = nested_probability(query.lobes, opacity);
      if (query.wo.x) {
        const Float pdf = Float::load(answer.pdf + i) * probability;
        select(pdf > 0.f, wide::Rgb::load(answer.f, i) * opacity).store(answer.f, i);
        pdf.store(answer.pdf + i);
      }
      if (query.u1) add_transmitted_samples(points, query, answer, opacity, probability, i);
    });
  }

  NullTransmission null_transmission(const SurfaceInteraction& si) const override {
    const float opacity = clamped_share(opacity_.at(si));
    const float probability = nested_probability(Lobe::kAll, opacity);
    NullTransmission through{Rgb(1 - opacity), 1 - probability};
    if (nested_->has_null_lobe()) {
      const NullTransmission nested = nested_->null_transmission(si);
      through.transmittance += nested.transmittance * opacity;
      through.probability += nested.probability * probability;
    }
    return through;
  }

  void null_transmission_block(const SurfaceBlock& points,
                               const NullTransmissionBlock& out) const override {
    using wide::Float;
    const NumberInput::Columns opacities(opacity_, points);
    const bool is_nested = nested_->has_null_lobe();
    if (is_nested) nested_->null_transmission_block(points, out);
    wide::for_lanes(points.count, [&](size_t i) {
      const Float opacity = clamped_share(opacities[i]);
      const Float probability = nested_probability(Lobe::kAll, opacity);
      wide::Rgb transmittance(1.f - opacity);
      Float passed = 1.f - probability;
      if (is_nested) {
        transmittance = transmittance + wide::Rgb::load(out.transmittance, i) * opacity;
        passed = passed + Float::load(out.probability + i) * probability;
      }
      transmittance.store(out.transmittance, i);
      passed.store(out.probability + i);
    });
  }

  Rgb albedo(const SurfaceInteraction& si) const override { return nested_->albedo(si); }
  LobeReflectance reflectance(const SurfaceInteraction& si) const override {
    LobeReflectance parts = nested_->reflectance(si);
    const float opacity = clamped_share(opacity_.at(si));
    parts.diffuse *= opacity;
    parts.glossy *= opacity;
    return parts;
  }
  Frame reflection_frame(const SurfaceInteraction& si) const override {
    return nested_->reflection_frame(si);
  }

 private:
  /// Probability that the nested BSDF is sampled, for samples of the lobes in `mask`.
  template <class F>
  F nested_probability(Lobe mask, const F& opacity) const {
    if (!any(mask & nested_->lobes())) return F(0.f);
    return any(mask & Lobe::kDelta) ? opacity : F(1.f);
  }

  /// Replaces the samples at points i, i + 1, … whose u1 selects straight transmission.
  static void add_transmitted_samples(const SurfaceBlock& points, const BsdfQuery& query,
                                      const BsdfAnswer& answer, const wide::Float& opacity,
                                      const wide::Float& probability, size_t i) {
    using wide::Float;
    const wide::Mask is_nested = Float::load(query.u1 + i) < probability;
    const Float through = any(query.lobes & Lobe::kDelta) ? 1.f : 0.f;
    const Float is_delta = Float::load(answer.is_delta + i);
    const Float pdf = Float::load(answer.sample_pdf + i);
    select(is_nested, wide::Vec3::load(answer.wo, i), -wide::Vec3::load(points.wi, i))
        .store(answer.wo, i);
    select(is_nested, wide::Rgb::load(answer.weight, i) * (opacity / probability),
           wide::Rgb(through * (1.f - opacity) / (1.f - probability)))
        .store(answer.weight, i);
    select(is_nested, select(is_delta > 0.f, pdf, pdf * probability), through)
        .store(answer.sample_pdf + i);
    select(is_nested, is_delta, through * kNullSample).store(answer.is_delta + i);
  }

  NumberInput opacity_;
  std::shared_ptr<Bsdf> nested_;
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::OpacityMask, kinome::Category::kBsdf, "mask",
              "A BSDF with holes: an opacity texture lets part of the light straight through.",
              kinome::kParameters);
