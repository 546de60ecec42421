// What a shape that emits has where the scene gives it no BSDF: it reflects nothing.

#include <algorithm>

#include "kinome/bsdf.h"
#include "loader/build.h"

namespace kinome::loader {
namespace {

class BlackBsdf final : public Bsdf {
 public:
  BlackBsdf() { lobes_ = Lobe::kNone; }
  void eval_pdf(const SurfaceInteraction&, Lobe, const DirectionBatch& wo,
                const BsdfValueBatch& out) const override {
    for (float* values : {out.r, out.g, out.b, out.pdf}) {
      if (values) std::fill_n(values, wo.count, 0.f);
    }
  }
  std::optional<BsdfSample> sample(const SurfaceInteraction&, Lobe, float,
                                   const Vec2&) const override {
    return std::nullopt;
  }
  LobeReflectance reflectance(const SurfaceInteraction&) const override { return {}; }
};

}  // namespace

std::shared_ptr<Bsdf> make_black_bsdf() {
  return std::make_shared<BlackBsdf>();
}

}  // namespace kinome::loader
