#include <algorithm>
#include <array>

#include "batch.h"
#include "kinome/plugin.h"

/// Turns the shading frame of a nested BSDF by a texture of normals, stored as (n + 1) / 2 in the
/// shading frame, as in Mitsuba 3. The texture must be `raw`, or its numbers would be taken for
/// sRGB colours.
///
/// Light is only reflected where the perturbed and the original surface agree on which side it
/// comes from. A perturbed normal that faces away from the viewer is turned about the original one
/// (flip_invalid_normals), and the hard shadow edge that remains is softened by the shadowing of
/// Estevez et al. 2019 ("A microfacet-based shadowing function to solve the bump terminator
/// problem"; use_shadowing_function).
///
///     <bsdf type="normalmap">
///       <texture name="normalmap" type="bitmap">
///         <string name="filename" value="normals.png"/><boolean name="raw" value="true"/>
///       </texture>
///       <bsdf type="roughplastic"/>
///     </bsdf>
namespace kinome {
namespace {

constexpr Parameter kParameters[] = {
    {"normalmap", ParameterType::kUnitlessTexture, nullptr, "normals as colours (n + 1) / 2",
     true},
    {"bsdf", ParameterType::kObject, nullptr, "what is perturbed", true, Category::kBsdf},
    {"flip_invalid_normals", ParameterType::kBoolean, "true",
     "turn normals that face away from the viewer"},
    {"use_shadowing_function", ParameterType::kBoolean, "true", "soften the terminator"},
};

/// For bump_shadowing, of a normal that was turned so far.
template <class F>
F bump_alpha2(F cos_turned) {
  const F cos2 = min(sqr(cos_turned), F(1.f));
  return select(cos2 > 0.f, min(0.125f * (1.f - cos2) / cos2, F(1.f)), F(1.f));
}

template <class F>
MaskOf<F> same_side(const F& a, const F& b) {
  return (a > 0.f && b > 0.f) || (a < 0.f && b < 0.f);
}

/// How the frame is turned, at points.
template <class F>
struct Turn {
  FrameOf<VecOf<F>> local;  ///< perturbed axes in the coordinates of the original frame
  VecOf<F> wi;              ///< in the perturbed frame
  F bump_alpha2;
  MaskOf<F> is_seen;  ///< false where the viewer doesn't see the perturbed surface's side
};

/// Columns of a block: the points as the nested BSDF sees them, and what leads back.
class TurnedBlock {
 public:
  explicit TurnedBlock(const SurfaceBlock& from)
      : points(from), columns_(26, from.count), wo(columns_.three(0)) {
    points.s = columns_.three(3), points.t = columns_.three(6), points.sn = columns_.three(9);
    points.wi = columns_.three(12);
  }
  void store(size_t i, const Turn<wide::Float>& turn) const {
    turn.local.s.store(columns_.three(15), i);
    turn.local.t.store(columns_.three(18), i);
    turn.local.n.store(columns_.three(21), i);
    turn.bump_alpha2.store(columns_[24] + i);
    select(turn.is_seen, wide::Float(1.f)).store(columns_[25] + i);
  }
  Turn<wide::Float> load(size_t i) const {
    return {{wide::Vec3::load(columns_.three(15), i), wide::Vec3::load(columns_.three(18), i),
             wide::Vec3::load(columns_.three(21), i)},
            wide::Vec3::load(points.wi, i),
            wide::Float::load(columns_[24] + i),
            wide::Float::load(columns_[25] + i) > 0.f};
  }

  SurfaceBlock points;

 private:
  wide::ScratchColumns columns_;

 public:
  Columns3 wo;  ///< what is asked, turned
};

class NormalMap final : public Bsdf {
 public:
  explicit NormalMap(const Properties& props)
      : nested_(props.object<Bsdf>()),
        normals_(props.texture("normalmap")),
        flip_(props.boolean("flip_invalid_normals")),
        shadowing_(props.boolean("use_shadowing_function")) {
    lobes_ = nested_->lobes();
    turns_to_viewer_ = flip_ || shadowing_;
  }

  void eval_pdf(const SurfaceInteraction& si, Lobe mask, const DirectionBatch& wo,
                const BsdfValueBatch& out) const override {
    const auto turned = perturb(si);
    if (!turned) {
      zero_batch(wo, out);
      return;
    }
    constexpr size_t kChunk = 256;
    std::array<float, kChunk> x, y, z;
    for (size_t begin = 0; begin < wo.count; begin += kChunk) {
      const size_t count = std::min(kChunk, wo.count - begin);
      for (size_t i = 0; i < count; ++i) {
        const size_t k = begin + i;
        const Vec3 d = turned->local.to_local(Vec3(wo.x[k], wo.y[k], wo.z[k]));
        x[i] = d.x;
        y[i] = d.y;
        z[i] = d.z;
      }
      const BsdfValueBatch part{out.r + begin, out.g + begin, out.b + begin,
                                out.pdf ? out.pdf + begin : nullptr};
      nested_->eval_pdf(turned->si, mask, DirectionBatch{x.data(), y.data(), z.data(), count},
                        part);
      for (size_t i = 0; i < count; ++i) {
        const float original_z = wo.z[begin + i];
        const float valid = same_side(original_z, z[i]) ? 1.f : 0.f;
        const float factor = valid * bump_shadowing(original_z, turned->bump_alpha2);
        part.r[i] *= factor;
        part.g[i] *= factor;
        part.b[i] *= factor;
        if (part.pdf) {
          part.pdf[i] *= valid;
        }
      }
    }
  }

  std::optional<BsdfSample> sample(const SurfaceInteraction& si, Lobe mask, float u1,
                                   const Vec2& u2) const override {
    const auto turned = perturb(si);
    if (!turned) {
      return std::nullopt;
    }
    auto result = nested_->sample(turned->si, mask, u1, u2);
    if (!result) {
      return std::nullopt;
    }
    const Vec3 wo = glm::normalize(turned->local.to_world(result->wo));
    if (!same_side(wo.z, result->wo.z)) {
      return std::nullopt;
    }
    result->wo = wo;
    result->weight *= bump_shadowing(wo.z, turned->bump_alpha2);
    return result;
  }

  void shade_block(const SurfaceBlock& points, const BsdfQuery& query,
                   const BsdfAnswer& answer) const override {
    const ColorInput::Columns texels(normals_, points.uv, points.count);
    const TurnedBlock turned(points);
    BsdfQuery nested_query = query;
    if (query.wo.x) nested_query.wo = turned.wo;
    wide::for_lanes(points.count, [&](size_t i) {
      const FrameOf<wide::Vec3> frame{wide::Vec3::load(points.s, i), wide::Vec3::load(points.t, i),
                                      wide::Vec3::load(points.sn, i)};
      const wide::Vec3 tangent =
          points.dp_du.x ? wide::Vec3::load(points.dp_du, i) : frame.s;
      const auto turn = turn_of<wide::Float>(texels[i], wide::Vec3::load(points.wi, i),
                                             frame.to_local(tangent));
      turned.store(i, turn);
      turn.wi.store(turned.points.wi, i);
      frame.to_world(turn.local.s).store(turned.points.s, i);
      frame.to_world(turn.local.t).store(turned.points.t, i);
      frame.to_world(turn.local.n).store(turned.points.sn, i);
      if (query.wo.x) turn.local.to_local(wide::Vec3::load(query.wo, i)).store(turned.wo, i);
    });
    nested_->shade_block(turned.points, nested_query, answer);
    wide::for_lanes(points.count, [&](size_t i) {
      const auto turn = turned.load(i);
      if (query.wo.x) turn_value(turn, turned.wo, query, answer, i);
      if (query.u1) turn_sample(turn, answer, i);
    });
  }

  std::optional<BsdfForm> form(const SurfaceInteraction& si) const override {
    const auto turned = perturb(si);
    if (!turned) return BsdfForm{};
    auto form = nested_->form(turned->si);
    if (!form || form->is_turned) return std::nullopt;
    form->is_turned = true;
    form->surface_normal = si.wi.z < 0 ? -si.frame.n : si.frame.n;
    form->bump_alpha2 = turned->bump_alpha2;
    return form;
  }

  LobeReflectance reflectance(const SurfaceInteraction& si) const override {
    // Who sees the back of a turned normal sees nothing, but others do.
    const auto turned = perturb(si);
    return nested_->reflectance(turned ? turned->si : si);
  }

  Frame reflection_frame(const SurfaceInteraction& si) const override {
    const auto turned = perturb(si);
    return nested_->reflection_frame(turned ? turned->si : si);
  }

 private:
  struct Turned {
    Frame local;            ///< perturbed axes in the coordinates of the original frame
    SurfaceInteraction si;  ///< as the nested BSDF sees the point
    float bump_alpha2;
  };

  template <class F>
  Turn<F> turn_of(const RgbOf<F>& texel, const VecOf<F>& wi, const VecOf<F>& tangent) const {
    VecOf<F> n = 2.f * texel - VecOf<F>(1.f);
    const F length2 = dot(n, n);
    // A texel of middle grey is no normal; nothing is perturbed there.
    n = select(length2 > 1e-12f, n / sqrt(length2), VecOf<F>(0.f, 0.f, 1.f));
    if (flip_) n = select(same_side(dot(n, wi), wi.z), n, VecOf<F>(-n.x, -n.y, n.z));
    Turn<F> turn;
    turn.local = FrameOf<VecOf<F>>::from_normal_and_tangent(n, tangent);
    turn.wi = turn.local.to_local(wi);
    turn.bump_alpha2 = shadowing_ ? bump_alpha2(n.z) : F(0.f);
    turn.is_seen = same_side(wi.z, turn.wi.z);
    return turn;
  }

  /// nullopt where the viewer doesn't see the perturbed surface's side.
  std::optional<Turned> perturb(const SurfaceInteraction& si) const {
    const auto turn =
        turn_of<float>(normals_.at(si.uv), si.wi, si.frame.to_local(si.dp_du));
    if (!turn.is_seen) return std::nullopt;
    Turned turned{turn.local, si, turn.bump_alpha2};
    turned.si.wi = turn.wi;
    turned.si.frame = Frame{si.frame.to_world(turn.local.s), si.frame.to_world(turn.local.t),
                            si.frame.to_world(turn.local.n)};
    return turned;
  }

  static void turn_value(const Turn<wide::Float>& turn, const Columns3& turned_wo,
                         const BsdfQuery& query, const BsdfAnswer& answer, size_t i) {
    using wide::Float;
    const Float z = Float::load(query.wo.z + i);
    const auto is_valid = turn.is_seen && same_side(z, Float::load(turned_wo.z + i));
    const auto f = wide::Rgb::load(answer.f, i) * bump_shadowing(z, turn.bump_alpha2);
    select(is_valid, f).store(answer.f, i);
    select(is_valid, Float::load(answer.pdf + i)).store(answer.pdf + i);
  }

  static void turn_sample(const Turn<wide::Float>& turn, const BsdfAnswer& answer, size_t i) {
    using wide::Float;
    const wide::Vec3 nested = wide::Vec3::load(answer.wo, i);
    const wide::Vec3 wo = normalize(turn.local.to_world(nested));
    const Float pdf = Float::load(answer.sample_pdf + i);
    const auto is_valid = turn.is_seen && pdf > 0.f && same_side(wo.z, nested.z);
    const auto weight = wide::Rgb::load(answer.weight, i) * bump_shadowing(wo.z, turn.bump_alpha2);
    select(is_valid, wo, wide::Vec3(0.f, 0.f, 1.f)).store(answer.wo, i);
    select(is_valid, weight).store(answer.weight, i);
    select(is_valid, pdf).store(answer.sample_pdf + i);
    select(is_valid, Float::load(answer.is_delta + i)).store(answer.is_delta + i);
  }

  std::shared_ptr<Bsdf> nested_;
  ColorInput normals_;
  bool flip_;
  bool shadowing_;
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::NormalMap, kinome::Category::kBsdf, "normalmap",
              "Perturbs the shading frame of a nested BSDF by a texture of normals.",
              kinome::kParameters);
