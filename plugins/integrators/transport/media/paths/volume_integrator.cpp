#include "transport/media/paths/volume_integrator.h"

#include <memory>
#include <utility>

#include "transport/media/bodies/media_warnings.h"
#include "transport/media/paths/volume_block.h"

namespace kinome::transport {

namespace {

/// Returns the settings for `path` that give the same paths where no light passes surfaces
/// straight: its roulette begins one point earlier.
PathSettings for_surfaces(PathSettings settings) {
  ++settings.length.rr_depth;
  return settings;
}

}  // namespace

/// Tables of a scene that all blocks and passes share.
struct VolumeTables {
  VolumeTables(const Scene& from, const Sensor& sensor, const LightGroups& groups)
      : media(from, sensor), scene(from, media.phases(), groups) {}

  MediaTable media;
  SceneTable scene;
};

namespace {

/// Progressive render with one set of tables: the default passes of an integrator that has them.
class VolumePasses final : public Passes {
 public:
  VolumePasses(std::unique_ptr<const VolumeTables> tables, const PathSettings& settings,
               const Scene& scene, const Sensor& sensor, RenderContext& context)
      : integrator_(std::move(tables), settings),
        passes_(integrator_.Integrator::begin(scene, sensor, context, 0)) {}

  double samples() const override { return passes_->samples(); }
  double render(double samples) override { return passes_->render(samples); }

 private:
  class Prepared final : public Integrator {
   public:
    Prepared(std::unique_ptr<const VolumeTables> tables, const PathSettings& settings)
        : tables_(std::move(tables)), settings_(settings) {}
    void render(const Scene& /*scene*/, const Sensor& sensor,
                RenderContext& context) const override {
      render_volumes(tables_->scene, tables_->media, settings_, sensor, context);
    }

   private:
    std::unique_ptr<const VolumeTables> tables_;
    PathSettings settings_;
  };

  Prepared integrator_;
  std::unique_ptr<Passes> passes_;
};

}  // namespace

VolumeIntegrator::VolumeIntegrator(const PathSettings& settings)
    : PathIntegrator(for_surfaces(settings)), settings_(settings) {}

void VolumeIntegrator::warn_of_ignored_light(const Scene& scene, const Sensor& sensor,
                                             RenderContext& /*context*/) const {
  warn_of_media(scene, sensor);
}

bool VolumeIntegrator::has_volume_paths(const Scene& scene, const VolumeTables& tables) const {
  return (tables.media.size() > 1 || tables.scene.has_null_lobe()) &&
         settings_.length.max_depth > 0 && !scene.emitters().empty();
}

void VolumeIntegrator::render(const Scene& scene, const Sensor& sensor,
                              RenderContext& context) const {
  const VolumeTables tables(scene, sensor, light_groups());
  if (!has_volume_paths(scene, tables)) return PathIntegrator::render(scene, sensor, context);
  render_volumes(tables.scene, tables.media, settings_, sensor, context);
}

std::unique_ptr<Passes> VolumeIntegrator::begin(const Scene& scene, const Sensor& sensor,
                                                RenderContext& context, double seconds) const {
  auto tables = std::make_unique<const VolumeTables>(scene, sensor, light_groups());
  if (!has_volume_paths(scene, *tables)) {
    return PathIntegrator::begin(scene, sensor, context, seconds);
  }
  return std::make_unique<VolumePasses>(std::move(tables), settings_, scene, sensor, context);
}

}  // namespace kinome::transport
