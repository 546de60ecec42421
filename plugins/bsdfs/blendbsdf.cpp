#include "blend_graph.h"
#include "kinome/plugin.h"

/// A linear mix of two BSDFs: (1 - weight) times the first plus weight times the second. Either may
/// be smooth glass; both may be if they have the same index of refraction. Blends may be nested,
/// and a BSDF that several of them refer to is evaluated only once.
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

class Blend final : public MixOfTwo {
 public:
  explicit Blend(const Properties& props)
      : MixOfTwo(read_weight(props), read_nested(props)), graph_(*this) {
    const Bsdf &first = *nested()[0], &second = *nested()[1];
    lobes_ = first.lobes() | second.lobes();
    transmits_ = first.transmits() || second.transmits();
    has_rough_transmission_ = first.has_rough_transmission() || second.has_rough_transmission();
    has_null_lobe_ = first.has_null_lobe() || second.has_null_lobe();
    relative_index_ = read_relative_index(props);
  }

  BsdfValue eval_pdf(const SurfaceInteraction& si, Lobe mask, const Vec3& wo) const override {
    return mixed_value(BlendShares(graph_, mask, si), si, mask, wo);
  }

  std::optional<BsdfSample> sample(const SurfaceInteraction& si, Lobe mask, float u1,
                                   const Vec2& u2) const override {
    const BlendShares shares(graph_, mask, si);
    size_t node = graph_.node_of_mix(0);
    float factor = 1;
    while (node >= leaves().size()) {
      const size_t mix = node - leaves().size();
      const auto choice = shares.choose(mix, u1, 0);
      u1 = choice.u1;
      factor *= choice.factor;
      node = graph_.mixes()[mix].parts[choice.is_second ? 1 : 0].node;
    }
    auto sample = leaves()[node]->sample(si, mask, u1, u2);
    if (!sample) return std::nullopt;
    if (any(sample->lobe & Lobe::kDelta)) {
      sample->weight *= factor;
      return sample;
    }
    const BsdfValue value = mixed_value(shares, si, mask, sample->wo);
    if (!(value.pdf > 0)) return std::nullopt;
    sample->pdf = value.pdf;
    sample->weight = value.f / value.pdf;
    return sample;
  }

  void shade_block(const SurfaceBlock& points, const BsdfQuery& query,
                   const BsdfAnswer& answer) const override {
    const BlendShares shares(graph_, query.lobes, points);
    if (query.u1) sample_block(points, query, shares, answer);
    if (query.wo.x) evaluate_block(points, query, shares, answer.f, answer.pdf);
  }

  NullTransmission null_transmission(const SurfaceInteraction& si) const override {
    const BlendShares shares(graph_, Lobe::kAll, si);
    NullTransmission sum;
    for_each_leaf([&](size_t k, const Bsdf& leaf) {
      const NullTransmission nested = leaf.null_transmission(si);
      sum.transmittance += nested.transmittance * shares.weight<float>(k, 0);
      sum.probability += nested.probability * shares.probability<float>(k, 0);
    });
    return sum;
  }

  void null_transmission_block(const SurfaceBlock& points,
                               const NullTransmissionBlock& out) const override {
    using wide::Float;
    const BlendShares shares(graph_, Lobe::kAll, points);
    const wide::ScratchColumns columns(4, points.count);
    const NullTransmissionBlock other{columns.three(0), columns[3]};
    for_each_leaf([&](size_t k, const Bsdf& leaf) {
      const NullTransmissionBlock& nested = k == 0 ? out : other;
      leaf.null_transmission_block(points, nested);
      wide::for_lanes(points.count, [&](size_t i) {
        const wide::Rgb transmittance =
            wide::Rgb::load(nested.transmittance, i) * shares.weight<Float>(k, i);
        const Float probability =
            Float::load(nested.probability + i) * shares.probability<Float>(k, i);
        if (k == 0) {
          transmittance.store(out.transmittance, i), probability.store(out.probability + i);
        } else {
          (wide::Rgb::load(out.transmittance, i) + transmittance).store(out.transmittance, i);
          (Float::load(out.probability + i) + probability).store(out.probability + i);
        }
      });
    });
  }

  Rgb albedo(const SurfaceInteraction& si) const override {
    const BlendShares shares(graph_, Lobe::kAll, si);
    Rgb sum(0.f);
    for_each_leaf(
        [&](size_t k, const Bsdf& leaf) { sum += leaf.albedo(si) * shares.weight<float>(k, 0); });
    return sum;
  }
  LobeReflectance reflectance(const SurfaceInteraction& si) const override {
    const BlendShares shares(graph_, Lobe::kAll, si);
    LobeReflectance sum;
    for_each_leaf([&](size_t k, const Bsdf& leaf) {
      const LobeReflectance nested = leaf.reflectance(si);
      sum.diffuse += nested.diffuse * shares.weight<float>(k, 0);
      sum.glossy += nested.glossy * shares.weight<float>(k, 0);
    });
    return sum;
  }
  /// Returns the frame of the first BSDF that is visible from si.wi, because some may be two-sided
  /// and others not. If none is visible, returns any of their frames.
  Frame reflection_frame(const SurfaceInteraction& si) const override {
    const Vec3 viewer = si.frame.to_world(si.wi);
    Frame frame;
    for (const Bsdf* const leaf : leaves()) {
      frame = leaf->reflection_frame(si);
      if (glm::dot(frame.n, viewer) > 0) break;
    }
    return frame;
  }

 private:
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
    const auto index_of = [&](size_t i) { return nested()[i]->relative_index(); };
    const auto bends_smoothly = [&](size_t i) {
      return index_of(i) != 1 && any(nested()[i]->lobes() & Lobe::kDelta);
    };
    if (bends_smoothly(0) && bends_smoothly(1) && index_of(0) != index_of(1)) {
      throw props.error("bsdf",
                        "must not be two smooth boundaries with different indices of "
                        "refraction");
    }
    if (bends_smoothly(0) || bends_smoothly(1)) return index_of(bends_smoothly(0) ? 0 : 1);
    return index_of(index_of(0) != 1 ? 0 : 1);
  }

  const std::vector<const Bsdf*>& leaves() const { return graph_.leaves(); }
  /// Calls fn(number, leaf).
  template <class Fn>
  void for_each_leaf(const Fn& fn) const {
    for (size_t k = 0; k < leaves().size(); ++k) fn(k, *leaves()[k]);
  }

  /// Evaluates the mix at wo.
  BsdfValue mixed_value(const BlendShares& shares, const SurfaceInteraction& si, Lobe mask,
                        const Vec3& wo) const {
    BsdfValue sum;
    for_each_leaf([&](size_t k, const Bsdf& leaf) {
      const BsdfValue value = leaf.eval_pdf(si, mask, wo);
      sum.f += value.f * shares.weight<float>(k, 0);
      sum.pdf += value.pdf * shares.probability<float>(k, 0);
    });
    if (!(sum.pdf > 0)) return {};
    return sum;
  }

  /// Evaluates the mix at query.wo.
  void evaluate_block(const SurfaceBlock& points, const BsdfQuery& query, const BlendShares& shares,
                      const Columns3& f, float* pdf) const {
    using wide::Float;
    const wide::ScratchColumns columns(12, points.count);
    const BsdfAnswer other{columns.three(0), columns[3],  columns.three(4),
                           columns.three(7), columns[10], columns[11]};
    BsdfAnswer first = other;
    first.f = f;
    first.pdf = pdf;
    BsdfQuery nested_query = query;
    nested_query.u1 = nullptr;
    for_each_leaf([&](size_t k, const Bsdf& leaf) {
      const BsdfAnswer& nested = k == 0 ? first : other;
      leaf.shade_block(points, nested_query, nested);
      const bool is_last = k + 1 == leaves().size();
      wide::for_lanes(points.count, [&](size_t i) {
        wide::Rgb value = wide::Rgb::load(nested.f, i) * shares.weight<Float>(k, i);
        Float sum = Float::load(nested.pdf + i) * shares.probability<Float>(k, i);
        if (k > 0) value = wide::Rgb::load(f, i) + value, sum = Float::load(pdf + i) + sum;
        if (is_last) value = select(sum > 0.f, value);
        value.store(f, i);
        sum.store(pdf + i);
      });
    });
  }

  /// Chooses a leaf at each point by query.u1: columns of its node, of a random number for it, and
  /// of its weight divided by the probability of the choice.
  struct LeafColumns {
    float *node, *u1, *factor;
  };
  void choose_leaves(size_t count, const float* u1, const BlendShares& shares,
                     const LeafColumns& to) const {
    using wide::Float;
    const auto number = [](size_t node) { return Float(static_cast<float>(node)); };
    for (size_t m = 0; m < graph_.mixes().size(); ++m) {
      const auto& parts = graph_.mixes()[m].parts;
      wide::for_lanes(count, [&](size_t i) {
        const auto choice = shares.choose(m, Float::load((m == 0 ? u1 : to.u1) + i), i);
        Float node = select(choice.is_second, number(parts[1].node), number(parts[0].node));
        Float nested_u1 = choice.u1, factor = choice.factor;
        if (m > 0) {
          const Float before = Float::load(to.node + i);
          const wide::Mask is_here = before == number(graph_.node_of_mix(m));
          node = select(is_here, node, before);
          nested_u1 = select(is_here, nested_u1, Float::load(to.u1 + i));
          const Float product = Float::load(to.factor + i);
          factor = select(is_here, product * factor, product);
        }
        node.store(to.node + i), nested_u1.store(to.u1 + i), factor.store(to.factor + i);
      });
    }
  }

  void sample_block(const SurfaceBlock& points, const BsdfQuery& query, const BlendShares& shares,
                    const BsdfAnswer& answer) const {
    using wide::Float;
    const wide::ScratchColumns columns(19, points.count);
    const LeafColumns chosen{columns[12], columns[13], columns[14]};
    choose_leaves(points.count, query.u1, shares, chosen);
    sample_leaves(points, query, chosen, columns, answer);
    const Columns3 f = columns.three(15);
    float* const pdf = columns[18];
    BsdfQuery sampled = query;
    sampled.u1 = nullptr;
    sampled.wo = answer.wo;
    evaluate_block(points, sampled, shares, f, pdf);
    wide::for_lanes(points.count, [&](size_t i) {
      const wide::Mask is_delta = Float::load(answer.is_delta + i) > 0.f;
      const wide::Mask is_there = Float::load(answer.sample_pdf + i) > 0.f;
      const Float density = Float::load(pdf + i);
      const wide::Mask is_mixed = is_there && !is_delta && density > 0.f;
      select(is_there && is_delta,
             wide::Rgb::load(answer.weight, i) * Float::load(chosen.factor + i),
             select(is_mixed, wide::Rgb::load(f, i) / density))
          .store(answer.weight, i);
      select(is_there && is_delta, Float(1.f), select(is_mixed, density))
          .store(answer.sample_pdf + i);
    });
  }

  /// Samples the chosen leaf at each point. Uses columns 0 to 11 of `columns`.
  void sample_leaves(const SurfaceBlock& points, const BsdfQuery& query, const LeafColumns& chosen,
                     const wide::ScratchColumns& columns, const BsdfAnswer& answer) const {
    using wide::Float;
    const BsdfAnswer other{columns.three(0), columns[3],  columns.three(4),
                           columns.three(7), columns[10], columns[11]};
    BsdfQuery nested_query = query;
    nested_query.wo = {};
    nested_query.u1 = chosen.u1;  // at points of other leaves, the sample is discarded
    for_each_leaf([&](size_t k, const Bsdf& leaf) {
      leaf.shade_block(points, nested_query, k == 0 ? answer : other);
      if (k == 0) return;
      wide::for_lanes(points.count, [&](size_t i) {
        const wide::Mask is_chosen = Float::load(chosen.node + i) == Float(static_cast<float>(k));
        const auto take = [&](float* to, const float* from) {
          select(is_chosen, Float::load(from + i), Float::load(to + i)).store(to + i);
        };
        for (const auto& [to, from] :
             {std::pair(answer.wo, other.wo), std::pair(answer.weight, other.weight)}) {
          take(to.x, from.x), take(to.y, from.y), take(to.z, from.z);
        }
        take(answer.sample_pdf, other.sample_pdf);
        take(answer.is_delta, other.is_delta);
      });
    });
  }

  BlendGraph graph_;
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::Blend, kinome::Category::kBsdf, "blendbsdf", "Two BSDFs mixed by a weight.",
              kinome::kParameters);
