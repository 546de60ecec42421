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
float bump_alpha2(float cos_turned) {
  const float cos2 = std::min(sqr(cos_turned), 1.f);
  return cos2 > 0 ? std::min(0.125f * (1 - cos2) / cos2, 1.f) : 1.f;
}

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

  static bool same_side(float a, float b) { return (a > 0 && b > 0) || (a < 0 && b < 0); }

  /// nullopt where the viewer doesn't see the perturbed surface's side.
  std::optional<Turned> perturb(const SurfaceInteraction& si) const {
    Vec3 n = 2.f * normals_->eval(si.uv) - 1.f;
    const float length2 = glm::dot(n, n);
    // A texel of middle grey is no normal; nothing is perturbed there.
    n = length2 > 1e-12f ? n / std::sqrt(length2) : Vec3(0, 0, 1);
    if (flip_ && !same_side(glm::dot(n, si.wi), si.wi.z)) {
      n = Vec3(-n.x, -n.y, n.z);
    }
    const Frame local = Frame::from_normal_and_tangent(n, si.frame.to_local(si.dp_du));
    Turned turned{local, si, shadowing_ ? bump_alpha2(n.z) : 0.f};
    turned.si.wi = local.to_local(si.wi);
    turned.si.frame =
        Frame{si.frame.to_world(local.s), si.frame.to_world(local.t), si.frame.to_world(local.n)};
    if (!same_side(si.wi.z, turned.si.wi.z)) {
      return std::nullopt;
    }
    return turned;
  }

  std::shared_ptr<Bsdf> nested_;
  std::shared_ptr<Texture> normals_;
  bool flip_;
  bool shadowing_;
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::NormalMap, kinome::Category::kBsdf, "normalmap",
              "Perturbs the shading frame of a nested BSDF by a texture of normals.",
              kinome::kParameters);
