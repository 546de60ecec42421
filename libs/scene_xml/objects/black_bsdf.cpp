// BSDF of emitting shapes for which the scene has none: it reflects nothing.

#include "kinome/bsdf.h"
#include "scene_xml/objects/build.h"

namespace kinome::loader {
namespace {

class BlackBsdf final : public Bsdf {
 public:
  BlackBsdf() { lobes_ = Lobe::kNone; }
  BsdfValue eval_pdf(const SurfaceInteraction&, Lobe, const Vec3&) const override { return {}; }
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
