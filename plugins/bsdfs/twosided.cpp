#include <algorithm>
#include <array>

#include "batch.h"
#include "kinome/plugin.h"

/// Makes one-sided BSDFs visible from both sides: one nested BSDF serves both, of two the first is
/// the front's and the second the back's. The back sees everything mirrored at the surface.
///
///     <bsdf type="twosided"><bsdf type="diffuse"/></bsdf>
namespace kinome {
namespace {

constexpr Parameter kParameters[] = {
    {"bsdf", ParameterType::kObject, nullptr, "one BSDF for both sides, or front and back", true,
     Category::kBsdf, 2},
};

class TwoSided final : public Bsdf {
 public:
  explicit TwoSided(const Properties& props) : sides_(props.objects<Bsdf>()) {
    if (sides_.empty() || sides_.size() > 2) {
      throw props.error("bsdf", "must be one or two nested BSDFs");
    }
    lobes_ = sides_.front()->lobes() | sides_.back()->lobes();
    is_lambertian_ = sides_.front()->is_lambertian() && sides_.back()->is_lambertian();
    turns_to_viewer_ = sides_.front()->turns_to_viewer() || sides_.back()->turns_to_viewer();
  }

  void eval_pdf(const SurfaceInteraction& si, Lobe mask, const DirectionBatch& wo,
                const BsdfValueBatch& out) const override {
    if (!(si.wi.z < 0)) {
      sides_.front()->eval_pdf(si, mask, wo, out);
      return;
    }
    const SurfaceInteraction back = mirrored(si);
    constexpr size_t kChunk = 256;
    std::array<float, kChunk> z;
    for (size_t begin = 0; begin < wo.count; begin += kChunk) {
      const size_t count = std::min(kChunk, wo.count - begin);
      for (size_t i = 0; i < count; ++i) {
        z[i] = -wo.z[begin + i];
      }
      sides_.back()->eval_pdf(back, mask,
                              DirectionBatch{wo.x + begin, wo.y + begin, z.data(), count},
                              BsdfValueBatch{out.r + begin, out.g + begin, out.b + begin,
                                             out.pdf ? out.pdf + begin : nullptr});
    }
  }

  std::optional<BsdfSample> sample(const SurfaceInteraction& si, Lobe mask, float u1,
                                   const Vec2& u2) const override {
    if (!(si.wi.z < 0)) {
      return sides_.front()->sample(si, mask, u1, u2);
    }
    auto result = sides_.back()->sample(mirrored(si), mask, u1, u2);
    if (result) {
      result->wo.z = -result->wo.z;
    }
    return result;
  }

  std::optional<BsdfForm> form(const SurfaceInteraction& si) const override {
    return si.wi.z < 0 ? sides_.back()->form(mirrored(si)) : sides_.front()->form(si);
  }

  LobeReflectance reflectance(const SurfaceInteraction& si) const override {
    return si.wi.z < 0 ? sides_.back()->reflectance(mirrored(si)) : sides_.front()->reflectance(si);
  }

  Frame reflection_frame(const SurfaceInteraction& si) const override {
    return si.wi.z < 0 ? sides_.back()->reflection_frame(mirrored(si))
                       : sides_.front()->reflection_frame(si);
  }

 private:
  /// The point as its back sees it, in a left-handed frame.
  static SurfaceInteraction mirrored(const SurfaceInteraction& si) {
    SurfaceInteraction back = si;
    back.frame.n = -si.frame.n;
    back.wi.z = -si.wi.z;
    return back;
  }

  std::vector<std::shared_ptr<Bsdf>> sides_;
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::TwoSided, kinome::Category::kBsdf, "twosided",
              "One or two one-sided BSDFs, seen from both sides.", kinome::kParameters);
