#pragma once

#include "batch.h"
#include "kinome/wide/surface_point.h"

/// Perturbs the shading frame of a nested BSDF. Base of normal maps and bump maps, after Mitsuba 3.
///
/// Light only contributes if it is on the same side of the perturbed and of the original surface.
/// If a perturbed normal faces away from the viewer, it is rotated by 180 degrees about the
/// original normal (flip_invalid_normals). The hard shadow edge that remains is softened by the
/// shadowing function of Estevez et al. 2019, "A microfacet-based shadowing function to solve the
/// bump terminator problem" (use_shadowing_function).
namespace kinome {

/// Parameters of both plugins.
#define KINOME_TURNED_FRAME_PARAMETERS                                      \
  {"bsdf", ::kinome::ParameterType::kObject, nullptr, "the perturbed BSDF", \
   true,   ::kinome::Category::kBsdf},                                      \
      {"flip_invalid_normals", ::kinome::ParameterType::kBoolean, "true",   \
       "flip normals that face away from the viewer"},                      \
  {                                                                         \
    "use_shadowing_function", ::kinome::ParameterType::kBoolean, "true",    \
        "soften the hard shadow edge of perturbed normals"                  \
  }

/// Returns the alpha² of bump_shadowing for a normal whose cosine with the original is cos_turned.
template <class F>
F bump_alpha2(F cos_turned) {
  const F cos2 = min(sqr(cos_turned), F(1.f));
  return select(cos2 > 0.f, min(0.125f * (1.f - cos2) / cos2, F(1.f)), F(1.f));
}

template <class F>
MaskOf<F> same_side(const F& a, const F& b) {
  return (a > 0.f && b > 0.f) || (a < 0.f && b < 0.f);
}

/// Axes from a map at a point, in coordinates of the original shading frame.
template <class F>
struct TurnedAxes {
  VecOf<F> normal;   ///< need not be normalised; 0 leaves the normal unchanged
  VecOf<F> tangent;  ///< need not be perpendicular to the normal
};

/// Perturbation of the frame at points.
template <class F>
struct Turn {
  FrameOf<VecOf<F>> local;  ///< perturbed axes in the coordinates of the original frame
  VecOf<F> wi;              ///< in the perturbed frame
  F bump_alpha2;
  MaskOf<F> is_seen;  ///< false if the viewer is behind the perturbed surface
};

/// Visibility and shadowing of a light direction with the given z in the original and the perturbed
/// frame.
template <class F>
struct Passage {
  Passage(const Turn<F>& turn, const F& z, const F& turned_z)
      : is_open(turn.is_seen && same_side(z, turned_z)),
        factor(bump_shadowing(z, turn.bump_alpha2)) {}
  MaskOf<F> is_open;
  F factor;
};

/// Columns of a block: the points in the perturbed frame, and the perturbation for the way back.
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
            bump_alpha2(i),
            wide::Float::load(columns_[25] + i) > 0.f};
  }
  wide::Float bump_alpha2(size_t i) const { return wide::Float::load(columns_[24] + i); }
  bool is_seen(size_t i) const { return columns_[25][i] > 0; }

  SurfaceBlock points;

 private:
  wide::ScratchColumns columns_;

 public:
  Columns3 wo;  ///< query.wo in the perturbed frame
};

/// Base of BSDFs that perturb frames. Self must provide
///
///     /// At one point.
///     TurnedAxes<float> axes_at(const SurfaceInteraction& si) const;
///     /// Calls fn(axes_at) once. axes_at(i, frame) returns the TurnedAxes<wide::Float> of points
///     /// i, i + 1, … of the block; frame has their shading frames.
///     template <class Fn>
///     void with_axes(const SurfaceBlock& points, const Fn& fn) const;
template <class Self>
class TurnedFrame : public Bsdf {
 public:
  explicit TurnedFrame(const Properties& props)
      : nested_(props.object<Bsdf>()),
        flip_(props.boolean("flip_invalid_normals")),
        shadowing_(props.boolean("use_shadowing_function")) {
    if (nested_->transmits() && any(nested_->lobes() & Lobe::kDelta)) {
      throw props.error("bsdf",
                        "must not be smooth glass or transmit light straight through: light "
                        "paths can't be traced backwards through perturbed normals");
    }
    lobes_ = nested_->lobes();
    transmits_ = nested_->transmits();
    has_rough_transmission_ = nested_->has_rough_transmission();
    relative_index_ = nested_->relative_index();
    turns_to_viewer_ = flip_ || shadowing_;
  }

  BsdfValue eval_pdf(const SurfaceInteraction& si, Lobe mask, const Vec3& wo) const override {
    const auto turned = perturb(si);
    if (!turned) return {};
    const Vec3 nested_wo = turned->turn.local.to_local(wo);
    const Passage<float> passage(turned->turn, wo.z, nested_wo.z);
    if (!passage.is_open) return {};
    const BsdfValue value = nested_->eval_pdf(turned->si, mask, nested_wo);
    return {value.f * passage.factor, value.pdf};
  }

  std::optional<BsdfSample> sample(const SurfaceInteraction& si, Lobe mask, float u1,
                                   const Vec2& u2) const override {
    const auto turned = perturb(si);
    if (!turned) return std::nullopt;
    auto result = nested_->sample(turned->si, mask, u1, u2);
    if (!result) return std::nullopt;
    const Vec3 wo = glm::normalize(turned->turn.local.to_world(result->wo));
    const Passage<float> passage(turned->turn, wo.z, result->wo.z);
    if (!passage.is_open) return std::nullopt;
    result->wo = wo;
    result->weight *= passage.factor;
    return result;
  }

  void shade_block(const SurfaceBlock& points, const BsdfQuery& query,
                   const BsdfAnswer& answer) const override {
    const TurnedBlock turned(points);
    BsdfQuery nested_query = query;
    if (query.wo.x) nested_query.wo = turned.wo;
    perturb(points, [&](size_t i, const FrameOf<wide::Vec3>& frame, const Turn<wide::Float>& turn) {
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

  void describe_block(const SurfaceBlock& points, const BsdfFormBlock& out) const override {
    const TurnedBlock turned(points);
    perturb(points, [&](size_t i, const FrameOf<wide::Vec3>& frame, const Turn<wide::Float>& turn) {
      turned.store(i, turn);
      // As in reflection_frame and reflectance.
      const auto turned_to = [&](const wide::Vec3& axis, const wide::Vec3& original) {
        return select(turn.is_seen, frame.to_world(axis), original);
      };
      turned_to(turn.local.s, frame.s).store(turned.points.s, i);
      turned_to(turn.local.t, frame.t).store(turned.points.t, i);
      turned_to(turn.local.n, frame.n).store(turned.points.sn, i);
      const wide::Vec3 wi = wide::Vec3::load(points.wi, i);
      select(turn.is_seen, turn.wi, wi).store(turned.points.wi, i);
    });
    nested_->describe_block(turned.points, out);
    wide::for_lanes(points.count, [&](size_t i) {
      const wide::Vec3 n = wide::Vec3::load(points.sn, i);
      select(wide::Float::load(points.wi.z + i) < 0.f, -n, n).store(out.surface_normal, i);
      turned.bump_alpha2(i).store(out.bump_alpha2 + i);
    });
    TurnedKinds kinds(*out.kinds);
    for (size_t i = 0; i < points.count; ++i) {
      if (turned.is_seen(i)) {
        out.kind[i] = kinds.turned(out.kind[i]);
      } else {
        out.kind[i] = kinds.black();
        out.diffuse.set(i, Rgb(0.f)), out.specular.set(i, Rgb(0.f));
      }
      if (out.kind[i] == BsdfFormKinds::kNone) describe_by_colours(points, i, out);
    }
  }

  Rgb albedo(const SurfaceInteraction& si) const override { return nested_->albedo(si); }
  LobeReflectance reflectance(const SurfaceInteraction& si) const override {
    // Viewers behind the perturbed surface see nothing. The original frame serves the others.
    const auto turned = perturb(si);
    return nested_->reflectance(turned ? turned->si : si);
  }

  Frame reflection_frame(const SurfaceInteraction& si) const override {
    const auto turned = perturb(si);
    return nested_->reflection_frame(turned ? turned->si : si);
  }

 private:
  const Self& self() const { return static_cast<const Self&>(*this); }

  struct Turned {
    Turn<float> turn;
    SurfaceInteraction si;  ///< the point in the perturbed frame
  };

  /// Maps kinds of forms to the kinds with `has_perturbed_normal` set.
  class TurnedKinds {
   public:
    explicit TurnedKinds(BsdfFormKinds& all) : all_(all) {}
    uint32_t turned(uint32_t kind) {
      if (kind == kind_) return turned_;
      kind_ = kind;
      turned_ = BsdfFormKinds::kNone;
      if (kind == BsdfFormKinds::kNone || all_[kind].has_perturbed_normal) return turned_;
      BsdfForm form = all_[kind];
      form.has_perturbed_normal = true;
      return turned_ = all_.number_of(form);
    }
    uint32_t black() { return all_.number_of(BsdfForm()); }

   private:
    BsdfFormKinds& all_;
    uint32_t kind_ = BsdfFormKinds::kNone, turned_ = BsdfFormKinds::kNone;  ///< the last pair
  };

  template <class F>
  Turn<F> turn_of(const TurnedAxes<F>& axes, const VecOf<F>& wi) const {
    VecOf<F> n = safe_normalize(axes.normal, VecOf<F>(0.f, 0.f, 1.f));
    if (flip_) n = select(same_side(dot(n, wi), wi.z), n, VecOf<F>(-n.x, -n.y, n.z));
    Turn<F> turn;
    turn.local = FrameOf<VecOf<F>>::from_normal_and_tangent(n, axes.tangent);
    turn.wi = turn.local.to_local(wi);
    turn.bump_alpha2 = shadowing_ ? bump_alpha2(n.z) : F(0.f);
    turn.is_seen = same_side(wi.z, turn.wi.z);
    return turn;
  }

  /// Returns nullopt if the viewer is behind the perturbed surface.
  std::optional<Turned> perturb(const SurfaceInteraction& si) const {
    const auto turn = turn_of<float>(self().axes_at(si), si.wi);
    if (!turn.is_seen) return std::nullopt;
    Turned turned{turn, si};
    turned.si.wi = turn.wi;
    turned.si.frame = Frame{si.frame.to_world(turn.local.s), si.frame.to_world(turn.local.t),
                            si.frame.to_world(turn.local.n)};
    return turned;
  }

  /// Calls fn(i, frame, turn) for the points of a block; `frame` is their original shading frame.
  template <class Fn>
  void perturb(const SurfaceBlock& points, const Fn& fn) const {
    self().with_axes(points, [&](const auto& axes_at) {
      wide::for_lanes(points.count, [&](size_t i) {
        const FrameOf<wide::Vec3> frame = wide::frame_at(points, i);
        fn(i, frame, turn_of<wide::Float>(axes_at(i, frame), wide::Vec3::load(points.wi, i)));
      });
    });
  }

  static void turn_value(const Turn<wide::Float>& turn, const Columns3& turned_wo,
                         const BsdfQuery& query, const BsdfAnswer& answer, size_t i) {
    using wide::Float;
    const Passage<Float> passage(turn, Float::load(query.wo.z + i), Float::load(turned_wo.z + i));
    select(passage.is_open, wide::Rgb::load(answer.f, i) * passage.factor).store(answer.f, i);
    select(passage.is_open, Float::load(answer.pdf + i)).store(answer.pdf + i);
  }

  static void turn_sample(const Turn<wide::Float>& turn, const BsdfAnswer& answer, size_t i) {
    using wide::Float;
    const wide::Vec3 nested = wide::Vec3::load(answer.wo, i);
    const wide::Vec3 wo = normalize(turn.local.to_world(nested));
    const Float pdf = Float::load(answer.sample_pdf + i);
    const Passage<Float> passage(turn, wo.z, nested.z);
    const auto is_valid = passage.is_open && pdf > 0.f;
    select(is_valid, wo, wide::Vec3(0.f, 0.f, 1.f)).store(answer.wo, i);
    select(is_valid, wide::Rgb::load(answer.weight, i) * passage.factor).store(answer.weight, i);
    select(is_valid, pdf).store(answer.sample_pdf + i);
    select(is_valid, Float::load(answer.is_delta + i)).store(answer.is_delta + i);
  }

  std::shared_ptr<Bsdf> nested_;
  bool flip_;
  bool shadowing_;
};

}  // namespace kinome
