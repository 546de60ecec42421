#pragma once

// Base class of BSDFs whose formulas are written once, for single points and for blocks.

#include <optional>
#include <tuple>

#include "kinome/bsdf.h"
#include "kinome/wide/functions.h"
#include "kinome/wide/textures.h"

namespace kinome::wide {
inline namespace HWY_NAMESPACE {

/// BsdfValue over F.
template <class F>
struct BsdfValueOf {
  RgbOf<F> f;
  F pdf;
};

/// BsdfSample over F. There is no sample if pdf is 0 or NaN.
template <class F>
struct BsdfSampleOf {
  VecOf<F> wo;
  F pdf;
  RgbOf<F> weight;
  IntOf<F> lobe;  ///< a Lobe as a number; see lobe_number()
};
/// NullTransmission over F.
template <class F>
struct NullTransmissionOf {
  RgbOf<F> transmittance;
  F probability;
};
constexpr int32_t lobe_number(Lobe lobe) {
  return static_cast<int32_t>(lobe);
}

KINOME_WIDE BsdfSampleOf<Float> select(Mask m, const BsdfSampleOf<Float>& a,
                                       const BsdfSampleOf<Float>& b) {
  return {select(m, a.wo, b.wo), select(m, a.pdf, b.pdf), select(m, a.weight, b.weight),
          select(m, a.lobe, b.lobe)};
}

/// Returns the sample wo of `lobe`, weighted by the value and density of all lobes.
template <class F, class Lobes>
KINOME_WIDE BsdfSampleOf<F> weighted_sample(const Lobes& lobes, const VecOf<F>& wo,
                                            const IntOf<F>& lobe) {
  const BsdfValueOf<F> v = lobes.value(wo);
  return {wo, v.pdf, v.f / v.pdf, lobe};
}

/// Fields of a BsdfForm that vary from point to point.
template <class F>
struct FormOf {
  RgbOf<F> diffuse;
  RgbOf<F> specular;
  F alpha_u, alpha_v;
};

/// Returns if_true() in lanes where m is true, and if_false() elsewhere. Calls each function only
/// if some lane needs it.
template <class A, class B>
KINOME_WIDE auto choose(bool m, const A& if_true, const B& if_false) {
  return m ? if_true() : if_false();
}
template <class A, class B>
KINOME_WIDE auto choose(Mask m, const A& if_true, const B& if_false) {
  if (none(m)) return if_false();
  if (all(m)) return if_true();
  return select(m, if_true(), if_false());
}

inline namespace formulas {

/// Interpolates BsdfForm::transmittance, a table of BsdfForm::kTableSize values over the cosine,
/// linearly.
template <class F>
F tabulated(const float* table, const F& cosine) {
  constexpr int32_t kLast = BsdfForm::kTableSize - 1;
  const F x = clamp(cosine, F(0.f), F(1.f)) * static_cast<float>(kLast);
  // The index is valid even if x is NaN.
  const auto i = clamp(to_int(x), IntOf<F>(0), IntOf<F>(kLast - 1));
  return lerp(gather(table, i), gather(table + 1, i), x - to_float(i));
}

/// Shadowing by bumps of squared roughness alpha2 at a cosine with the geometric normal (Estevez et
/// al. 2019, "A Microfacet-Based Shadowing Function to Solve the Bump Terminator Problem"). It is 1
/// if alpha2 = 0.
template <class F>
F bump_shadowing(const F& cosine, const F& alpha2) {
  const F cos2 = clamp(cosine * cosine, F(1e-12f), F(1.f));
  return 2.f / (1.f + sqrt(1.f + alpha2 * (1.f - cos2) / cos2));
}
/// Factor of lobes around a perturbed normal; see BsdfForm::has_perturbed_normal.
template <class F>
F perturbed_normal_factor(const F& cosine, const F& alpha2) {
  return select(cosine > 0.f, bump_shadowing(cosine, alpha2), F(0.f));
}

}  // namespace formulas

/// Base class of BSDFs written as formulas over a number type F, float or Float. Implements the
/// functions for points and for blocks. The BSDF reflects on its front side only, unless Self
/// declares `static constexpr bool kSeenFromBehind = true`. Self has
///
///     /// Returns the textures that the formulas read: a tuple of ColorInput and NumberInput.
///     auto inputs() const { return std::tie(reflectance_, alpha_); }
///
///     /// Calls fn(lobes_at) once. lobes_at(wi, value of each input ...) returns an object with
///     /// the lobes in `mask`, which is a subset of lobes() and not empty. Lanes with wi.z <= 0
///     /// are ignored (with kSeenFromBehind, only those with wi.z = 0). The object has
///     ///     BsdfValueOf<F> value(const VecOf<F>& wo) const;   // without delta lobes
///     ///     BsdfSampleOf<F> sample(const F& u1, const Vec2Of<F>& u2) const;
///     template <class F, class Fn>
///     void with_lobes(Lobe mask, const Fn& fn) const;
///
/// If Self has `static constexpr bool kPassesStraight = true`, the object also has
///
///     NullTransmissionOf<F> null_transmission() const;
///
/// If all points have a BsdfForm of the same kind, with si.frame as reflection frame, Self has
///
///     /// Returns the form without the fields of FormOf.
///     BsdfForm form_kind() const;
///     template <class F>
///     FormOf<F> form_of(const VecOf<F>& wi, value of each input ...) const;
template <class Self>
class FormulaBsdf : public Bsdf {
 public:
  BsdfValue eval_pdf(const SurfaceInteraction& si, Lobe mask, const glm::vec3& wo) const override {
    BsdfValue result;
    if (!is_seen(si, mask)) return result;
    with_lobes_at(si, mask, [&](const auto& lobes) {
      const BsdfValueOf<float> v = lobes.value(wo);
      result = {v.f, v.pdf};
    });
    return result;
  }

  std::optional<BsdfSample> sample(const SurfaceInteraction& si, Lobe mask, float u1,
                                   const glm::vec2& u2) const override {
    std::optional<BsdfSample> result;
    if (!is_seen(si, mask)) return result;
    with_lobes_at(si, mask, [&](const auto& lobes) {
      const BsdfSampleOf<float> s = lobes.sample(u1, u2);
      if (s.pdf > 0) result = BsdfSample{s.wo, s.pdf, s.weight, static_cast<Lobe>(s.lobe)};
    });
    return result;
  }

  NullTransmission null_transmission(const SurfaceInteraction& si) const override {
    NullTransmission result;
    if constexpr (passes()) {
      if (!is_seen(si, Lobe::kDelta)) return result;
      with_lobes_at(si, Lobe::kAll, [&](const auto& lobes) {
        const NullTransmissionOf<float> through = lobes.null_transmission();
        result = {through.transmittance, through.probability};
      });
    }
    return result;
  }

  void null_transmission_block(const SurfaceBlock& points,
                               const NullTransmissionBlock& out) const override {
    if constexpr (passes()) {
      with_columns(points, [&](const auto&... columns) {
        self().template with_lobes<Float>(lobes_, [&](const auto& lobes_at) {
          for_lanes(points.count, [&](size_t i) {
            const Vec3 wi = Vec3::load(points.wi, i);
            const NullTransmissionOf<Float> through =
                lobes_at(wi, columns[i]...).null_transmission();
            const Mask is_seen = is_facing(wi.z);
            select(is_seen, through.transmittance).store(out.transmittance, i);
            select(is_seen, through.probability).store(out.probability + i);
          });
        });
      });
    } else {
      Bsdf::null_transmission_block(points, out);
    }
  }

  void describe_block(const SurfaceBlock& points, const BsdfFormBlock& out) const override {
    if constexpr (requires(const Self& self) { self.form_kind(); }) {
      const uint32_t kind = out.kinds->number_of(self().form_kind());
      if (kind != BsdfFormKinds::kNone) {
        std::fill_n(out.kind, points.count, kind);
        return store_forms(points, out);
      }
    }
    Bsdf::describe_block(points, out);
  }

  void shade_block(const SurfaceBlock& points, const BsdfQuery& query,
                   const BsdfAnswer& answer) const override {
    const Lobe wanted = query.lobes & lobes_;
    if (!any(wanted)) return write_nothing(points.count, query, answer);
    with_columns(points, [&](const auto&... columns) {
      self().template with_lobes<Float>(wanted, [&](const auto& lobes_at) {
        for_lanes(points.count, [&](size_t i) {
          const Vec3 wi = Vec3::load(points.wi, i);
          shade(lobes_at(wi, columns[i]...), is_facing(wi.z), query, answer, i);
        });
      });
    });
  }

 protected:
  /// Writes the output of describe_block() except the kind of form.
  void store_forms(const SurfaceBlock& points, const BsdfFormBlock& out) const {
    with_columns(points, [&](const auto&... columns) {
      for_lanes(points.count, [&](size_t i) {
        Vec3::load(points.sn, i).store(out.normal, i);
        Vec3::load(points.s, i).store(out.tangent, i);
        const Vec3 wi = Vec3::load(points.wi, i);
        const FormOf<Float> own = self().template form_of<Float>(wi, columns[i]...);
        own.diffuse.store(out.diffuse, i);
        own.specular.store(out.specular, i);
        own.alpha_u.store(out.alpha_u + i);
        own.alpha_v.store(out.alpha_v + i);
      });
    });
  }

 private:
  const Self& self() const { return static_cast<const Self&>(*this); }

  static constexpr bool passes() {
    return requires { requires Self::kPassesStraight; };
  }

  /// Calls fn with the values of each input at the points.
  template <class Fn>
  void with_columns(const SurfaceBlock& points, const Fn& fn) const {
    std::apply(
        [&](const auto&... inputs) {
          fn(typename std::remove_cvref_t<decltype(inputs)>::Columns(inputs, points)...);
        },
        self().inputs());
  }

  template <class F>
  static MaskOf<F> is_facing(const F& wi_z) {
    using std::abs;
    if constexpr (requires { requires Self::kSeenFromBehind; }) return abs(wi_z) > 0.f;
    return wi_z > 0.f;
  }
  bool is_seen(const SurfaceInteraction& si, Lobe mask) const {
    return is_facing(si.wi.z) && any(mask & lobes_);
  }

  template <class Fn>
  void with_lobes_at(const SurfaceInteraction& si, Lobe mask, const Fn& fn) const {
    self().template with_lobes<float>(mask & lobes_, [&](const auto& lobes_at) {
      std::apply([&](const auto&... inputs) { fn(lobes_at(si.wi, inputs.at(si)...)); },
                 self().inputs());
    });
  }

  template <class Lobes>
  KINOME_WIDE static void shade(const Lobes& lobes, Mask is_seen, const BsdfQuery& query,
                                const BsdfAnswer& answer, size_t i) {
    if (query.wo.x) {
      const BsdfValueOf<Float> v = lobes.value(Vec3::load(query.wo, i));
      const Mask found = is_seen && v.pdf > 0.f;
      select(found, v.f).store(answer.f, i);
      select(found, v.pdf).store(answer.pdf + i);
    }
    if (query.u1) {
      const BsdfSampleOf<Float> s =
          lobes.sample(Float::load(query.u1 + i), Vec2::load(query.u2, i));
      const Mask found = is_seen && s.pdf > 0.f;
      select(found, s.wo, Vec3(0.f, 0.f, 1.f)).store(answer.wo, i);
      select(found, s.weight).store(answer.weight, i);
      select(found, s.pdf).store(answer.sample_pdf + i);
      const Float is_delta = select(s.lobe == lobe_number(Lobe::kDelta | Lobe::kNull), kNullSample,
                                    select(s.lobe == lobe_number(Lobe::kDelta), Float(1.f)));
      select(found, is_delta).store(answer.is_delta + i);
    }
  }

  static void write_nothing(size_t count, const BsdfQuery& query, const BsdfAnswer& answer) {
    for_lanes(count, [&](size_t i) {
      if (query.wo.x) {
        Vec3(0.f).store(answer.f, i);
        Float(0.f).store(answer.pdf + i);
      }
      if (query.u1) {
        Vec3(0.f, 0.f, 1.f).store(answer.wo, i);
        Vec3(0.f).store(answer.weight, i);
        Float(0.f).store(answer.sample_pdf + i);
        Float(0.f).store(answer.is_delta + i);
      }
    });
  }
};

}  // namespace HWY_NAMESPACE
}  // namespace kinome::wide
