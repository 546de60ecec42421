#include <array>

#include "batch.h"
#include "kinome/plugin.h"

/// A linear mix of two BSDFs: (1 - weight) times the first plus weight times the second. Either may
/// be smooth glass; both may be if they have the same index of refraction.
///
///     <bsdf type="blendbsdf">
///       <texture type="bitmap" name="weight"><string name="filename" value="dust.png"/></texture>
///       <bsdf type="roughconductor"/>
///       <bsdf type="diffuse"/>
///     </bsdf>
namespace kinome {
namespace {

constexpr Parameter kParameters[] = {
    {"weight", ParameterType::kUnitlessTexture, nullptr,
     "weight of the second BSDF, clamped to [0,1]", true},
    {"bsdf", ParameterType::kObject, nullptr, "the first and the second BSDF", true,
     Category::kBsdf, 2},
};

std::shared_ptr<Texture> read_weight(const Properties& props) {
  constexpr float kRounding = 1e-3f;  // of half floats and filters
  auto weight = props.texture("weight");
  if (weight->min() < -kRounding || weight->max() > 1 + kRounding) {
    props.warn("weight", "has values outside [0,1], which are clamped: from " +
                             format_number(weight->min()) + " to " + format_number(weight->max()));
  }
  return weight;
}

class Blend final : public Bsdf {
 public:
  explicit Blend(const Properties& props)
      : weight_(read_weight(props)), nested_(read_nested(props)) {
    lobes_ = nested_[0]->lobes() | nested_[1]->lobes();
    transmits_ = nested_[0]->transmits() || nested_[1]->transmits();
    has_rough_transmission_ =
        nested_[0]->has_rough_transmission() || nested_[1]->has_rough_transmission();
    has_null_lobe_ = nested_[0]->has_null_lobe() || nested_[1]->has_null_lobe();
    relative_index_ = read_relative_index(props);
  }

  BsdfValue eval_pdf(const SurfaceInteraction& si, Lobe mask, const Vec3& wo) const override {
    const auto [weight, second] = shares_of(mask, weight_.at(si));
    const BsdfValue a = nested_[0]->eval_pdf(si, mask, wo), b = nested_[1]->eval_pdf(si, mask, wo);
    BsdfValue value{a.f * (1 - weight) + b.f * weight, a.pdf * (1 - second) + b.pdf * second};
    if (!(value.pdf > 0)) return {};
    return value;
  }

  std::optional<BsdfSample> sample(const SurfaceInteraction& si, Lobe mask, float u1,
                                   const Vec2& u2) const override {
    const auto [weight, second] = shares_of(mask, weight_.at(si));
    const bool is_second = u1 < second;
    const float nested_u1 = is_second ? u1 / second : (u1 - second) / (1 - second);
    auto sample =
        nested_[is_second]->sample(si, mask, std::clamp(nested_u1, 0.f, kOneMinusEpsilon), u2);
    if (!sample) return std::nullopt;
    if (any(sample->lobe & Lobe::kDelta)) {
      sample->weight *= is_second ? weight / second : (1 - weight) / (1 - second);
      return sample;
    }
    const BsdfValue value = eval_pdf(si, mask, sample->wo);
    if (!(value.pdf > 0)) return std::nullopt;
    sample->pdf = value.pdf;
    sample->weight = value.f / value.pdf;
    return sample;
  }

  void shade_block(const SurfaceBlock& points, const BsdfQuery& query,
                   const BsdfAnswer& answer) const override {
    const NumberInput::Columns weights(weight_, points);
    if (query.u1) sample_block(points, query, weights, answer);
    if (query.wo.x) evaluate_block(points, query, weights, answer.f, answer.pdf);
  }

  NullTransmission null_transmission(const SurfaceInteraction& si) const override {
    const auto [weight, second] = shares_of(Lobe::kAll, weight_.at(si));
    const NullTransmission a = nested_[0]->null_transmission(si),
                           b = nested_[1]->null_transmission(si);
    return {a.transmittance * (1 - weight) + b.transmittance * weight,
            a.probability * (1 - second) + b.probability * second};
  }

  void null_transmission_block(const SurfaceBlock& points,
                               const NullTransmissionBlock& out) const override {
    using wide::Float;
    const NumberInput::Columns weights(weight_, points);
    const wide::ScratchColumns columns(4, points.count);
    const NullTransmissionBlock other{columns.three(0), columns[3]};
    nested_[0]->null_transmission_block(points, out);
    nested_[1]->null_transmission_block(points, other);
    wide::for_lanes(points.count, [&](size_t i) {
      const auto [weight, second] = shares_of(Lobe::kAll, weights[i]);
      (wide::Rgb::load(out.transmittance, i) * (1.f - weight) +
       wide::Rgb::load(other.transmittance, i) * weight)
          .store(out.transmittance, i);
      (Float::load(out.probability + i) * (1.f - second) +
       Float::load(other.probability + i) * second)
          .store(out.probability + i);
    });
  }

  Rgb albedo(const SurfaceInteraction& si) const override {
    const float weight = clamped_share(weight_.at(si));
    return nested_[0]->albedo(si) * (1 - weight) + nested_[1]->albedo(si) * weight;
  }
  LobeReflectance reflectance(const SurfaceInteraction& si) const override {
    const float weight = clamped_share(weight_.at(si));
    const LobeReflectance a = nested_[0]->reflectance(si), b = nested_[1]->reflectance(si);
    return {a.diffuse * (1 - weight) + b.diffuse * weight,
            a.glossy * (1 - weight) + b.glossy * weight};
  }
  /// Returns the frame of the BSDF that is visible from si.wi: one may be two-sided, the other not.
  Frame reflection_frame(const SurfaceInteraction& si) const override {
    const Frame first = nested_[0]->reflection_frame(si);
    const bool is_seen = glm::dot(first.n, si.frame.to_world(si.wi)) > 0;
    return is_seen ? first : nested_[1]->reflection_frame(si);
  }

 private:
  using Two = std::array<std::shared_ptr<Bsdf>, 2>;
  static Two read_nested(const Properties& props) {
    const auto nested = props.objects<Bsdf>();
    if (nested.size() != 2) {
      throw props.error("bsdf", "must be two nested BSDFs, got " + std::to_string(nested.size()));
    }
    for (const auto& one : nested) {
      if (one->turns_to_viewer()) {
        throw props.error("bsdf",
                          "can't be a normal map: nest the blend in the normal map instead");
      }
    }
    return {nested[0], nested[1]};
  }

  /// Returns the index by which delta lobes refract light: integrators query it for these. The
  /// values of rough glass already account for its own index.
  float read_relative_index(const Properties& props) const {
    const auto index_of = [&](size_t i) { return nested_[i]->relative_index(); };
    const auto bends_smoothly = [&](size_t i) {
      return index_of(i) != 1 && any(nested_[i]->lobes() & Lobe::kDelta);
    };
    if (bends_smoothly(0) && bends_smoothly(1) && index_of(0) != index_of(1)) {
      throw props.error("bsdf",
                        "must not be two smooth boundaries with different indices of "
                        "refraction");
    }
    if (bends_smoothly(0) || bends_smoothly(1)) return index_of(bends_smoothly(0) ? 0 : 1);
    return index_of(index_of(0) != 1 ? 0 : 1);
  }

  /// Weight of the second BSDF, and the probability of sampling it.
  template <class F>
  struct Shares {
    F weight, probability;
  };
  /// `value` is the texture's. The probability is for samples of the lobes in `mask`.
  template <class F>
  Shares<F> shares_of(Lobe mask, const F& value) const {
    const F weight = clamped_share(value);
    if (!any(mask & nested_[1]->lobes())) return {weight, F(0.f)};
    return {weight, any(mask & nested_[0]->lobes()) ? weight : F(1.f)};
  }

  /// Evaluates the mix at query.wo.
  void evaluate_block(const SurfaceBlock& points, const BsdfQuery& query,
                      const NumberInput::Columns& weights, const Columns3& f, float* pdf) const {
    using wide::Float;
    const wide::ScratchColumns columns(12, points.count);
    const BsdfAnswer other{columns.three(0), columns[3],  columns.three(4),
                           columns.three(7), columns[10], columns[11]};
    BsdfAnswer first = other;
    first.f = f;
    first.pdf = pdf;
    BsdfQuery nested_query = query;
    nested_query.u1 = nullptr;
    nested_[0]->shade_block(points, nested_query, first);
    nested_[1]->shade_block(points, nested_query, other);
    wide::for_lanes(points.count, [&](size_t i) {
      const auto [weight, second] = shares_of(query.lobes, weights[i]);
      const Float sum =
          Float::load(pdf + i) * (1.f - second) + Float::load(other.pdf + i) * second;
      const wide::Rgb value =
          wide::Rgb::load(f, i) * (1.f - weight) + wide::Rgb::load(other.f, i) * weight;
      select(sum > 0.f, value).store(f, i);
      sum.store(pdf + i);
    });
  }

  void sample_block(const SurfaceBlock& points, const BsdfQuery& query,
                    const NumberInput::Columns& weights, const BsdfAnswer& answer) const {
    using wide::Float;
    const wide::ScratchColumns columns(18, points.count);
    const BsdfAnswer second{columns.three(0), columns[3],  columns.three(4),
                            columns.three(7), columns[10], columns[11]};
    const Columns3 f = columns.three(13);
    float* const pdf = columns[16];
    BsdfQuery nested_query = query;
    nested_query.wo = {};
    nested_query.u1 = columns[12];
    for (const bool is_second : {false, true}) {
      wide::for_lanes(points.count, [&](size_t i) {
        const Float split = shares_of(query.lobes, weights[i]).probability;
        const Float u1 = Float::load(query.u1 + i);
        const Float nested_u1 = is_second ? u1 / split : (u1 - split) / (1.f - split);
        // Samples of the BSDF that isn't chosen are discarded; their u1 only has to be valid.
        select(nested_u1 >= 0.f, min(nested_u1, Float(kOneMinusEpsilon)), Float(0.f))
            .store(nested_query.u1 + i);
      });
      nested_[is_second]->shade_block(points, nested_query, is_second ? second : answer);
    }
    wide::for_lanes(points.count, [&](size_t i) {
      const Float split = shares_of(query.lobes, weights[i]).probability;
      const wide::Mask takes_second = Float::load(query.u1 + i) < split;
      const auto select_into = [&](float* to, const float* from) {
        select(takes_second, Float::load(from + i), Float::load(to + i)).store(to + i);
      };
      for (const auto& [to, from] : {std::pair(answer.wo, second.wo),
                                     std::pair(answer.weight, second.weight)}) {
        select_into(to.x, from.x), select_into(to.y, from.y), select_into(to.z, from.z);
      }
      select_into(answer.sample_pdf, second.sample_pdf);
      select_into(answer.is_delta, second.is_delta);
    });
    BsdfQuery sampled = query;
    sampled.u1 = nullptr;
    sampled.wo = answer.wo;
    evaluate_block(points, sampled, weights, f, pdf);
    wide::for_lanes(points.count, [&](size_t i) {
      const auto [weight, split] = shares_of(query.lobes, weights[i]);
      const wide::Mask is_second = Float::load(query.u1 + i) < split;
      const Float share = select(is_second, weight / split, (1.f - weight) / (1.f - split));
      const wide::Mask is_delta = Float::load(answer.is_delta + i) > 0.f;
      const wide::Mask is_there = Float::load(answer.sample_pdf + i) > 0.f;
      const Float density = Float::load(pdf + i);
      const wide::Mask is_mixed = is_there && !is_delta && density > 0.f;
      select(is_there && is_delta, wide::Rgb::load(answer.weight, i) * share,
             select(is_mixed, wide::Rgb::load(f, i) / density))
          .store(answer.weight, i);
      select(is_there && is_delta, Float(1.f), select(is_mixed, density)).store(answer.sample_pdf + i);
    });
  }

  NumberInput weight_;
  Two nested_;
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::Blend, kinome::Category::kBsdf, "blendbsdf", "Two BSDFs mixed by a weight.",
              kinome::kParameters);
