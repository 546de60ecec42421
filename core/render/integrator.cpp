#include "kinome/integrator.h"

#include <algorithm>

#include "kinome/error.h"
#include "kinome/log.h"
#include "kinome/primary_rays.h"
#include "kinome/scene.h"
#include "kinome/sensor.h"

namespace kinome {
namespace {

/// Default passes: each pass is a complete call of Integrator::render().
class RenderPasses final : public Passes {
 public:
  RenderPasses(const Integrator& integrator, const Scene& scene, const Sensor& sensor,
               RenderContext& context)
      : integrator_(integrator), scene_(scene), sensor_(sensor), context_(context) {}

  double samples() const override { return sensor_.sampler().sample_count(); }

  double render(double samples) override {
    const auto sensor = at_most(static_cast<uint32_t>(std::clamp(samples, 1., kMaxSamples)));
    integrator_.render(scene_, *sensor, context_);
    return sensor->sampler().sample_count();
  }

 private:
  static constexpr double kMaxSamples = 1 << 30;

  /// Returns the sensor with at most `samples` samples. Reduces the number until it fits, because
  /// samplers round it up.
  std::unique_ptr<Sensor> at_most(uint32_t samples) const {
    for (uint32_t count = samples;; count -= std::max(1u, count / 8)) {
      auto sensor = sensor_.with_sample_count(count);
      if (count == 1 || sensor->sampler().sample_count() <= samples) return sensor;
    }
  }

  const Integrator& integrator_;
  const Scene& scene_;
  const Sensor& sensor_;
  RenderContext& context_;
};

}  // namespace

std::vector<Stage> Integrator::stages() const {
  return {kPrimaryStage, kFilmStage};
}

std::unique_ptr<Passes> Integrator::begin(const Scene& scene, const Sensor& sensor,
                                          RenderContext& context, double /*seconds*/) const {
  return std::make_unique<RenderPasses>(*this, scene, sensor, context);
}

std::vector<Inspection> Integrator::inspect(const Scene& /*scene*/, const Sensor& /*sensor*/,
                                            RenderContext& /*context*/,
                                            const Vec2& /*film_position*/) const {
  throw Error("the scene's integrator has no clusters to inspect");
}

void warn_without_emitters(const Scene& scene) {
  if (!scene.emitters().empty()) return;
  log_warn(
      Error(Location{scene.file()}, "the scene has no emitter: the image will be black").what());
}

}  // namespace kinome
