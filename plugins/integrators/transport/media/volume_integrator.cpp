#include "volume_integrator.h"

#include <algorithm>
#include <memory>
#include <utility>

#include "../blocks_of_tile.h"
#include "../camera.h"
#include "../film_samples.h"
#include "kinome/stats.h"
#include "media_warnings.h"
#include "volume_paths.h"

namespace kinome::transport {

namespace {

/// Returns the settings for `path` that give the same paths where no light passes surfaces
/// straight: its roulette begins one point earlier.
PathSettings for_surfaces(PathSettings settings) {
  ++settings.length.rr_depth;
  return settings;
}

/// Renders blocks of camera rays, from the rays to the film. One per thread.
class VolumeBlock {
 public:
  VolumeBlock(const SceneTable& scene, const MediaTable& media, const Sensor& sensor,
              const PathSettings& settings)
      : camera_(scene, sensor, kBlockSamples, false),
        paths_(scene, media, sensor.sampler(), settings, kBlockSamples),
        film_(sensor.film().filter(), sensor.film().value_count(0), kBlockSamples,
              sensor.film().has_powers(0)),
        arena_(kBlockSamples + kBlockLanes),  // see FilmSamples::add
        radiance_(arena_.three()),
        alpha_(arena_.floats()),
        values_{radiance_.x, radiance_.y, radiance_.z} {
    if (sensor.film().has_alpha()) values_.push_back(alpha_);
  }

  void render(const PixelSamples& samples, Tile& tile) {
    {
      const StageTimer timer(tile.counters.stage_seconds["primary"]);
      camera_.make_rays(samples);
      for (float* const column : {radiance_.x, radiance_.y, radiance_.z}) {
        std::fill_n(column, padded(samples.count()), 0.f);
      }
    }
    paths_.trace(samples, camera_.rays(), radiance_, alpha_, tile.counters);
    const StageTimer timer(tile.counters.stage_seconds["film"]);
    film_.add(samples, camera_.film_position(), values_, tile.film);
  }

 private:
  Camera camera_;
  VolumePaths paths_;
  FilmSamples film_;
  Arena arena_;
  Columns3 radiance_;
  float* alpha_;
  std::vector<float*> values_;
};

}  // namespace

/// Tables of a scene that all blocks and passes share.
struct VolumeTables {
  VolumeTables(const Scene& from, const Sensor& sensor)
      : media(from, sensor), scene(from, media.phases()) {}

  MediaTable media;
  SceneTable scene;
};

namespace {

void render_volumes(const VolumeTables& tables, const PathSettings& settings, const Sensor& sensor,
                    RenderContext& context) {
  render_tiles<VolumeBlock>(
      sensor, context, 0,
      [&] { return std::make_unique<VolumeBlock>(tables.scene, tables.media, sensor, settings); },
      [](VolumeBlock& block, const PixelSamples& samples, Tile& tile) {
        block.render(samples, tile);
      });
}

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
      render_volumes(*tables_, settings_, sensor, context);
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

void VolumeIntegrator::warn_of_light_left_out(const Scene& scene, const Sensor& sensor,
                                              RenderContext& /*context*/) const {
  warn_of_media(scene, sensor);
}

bool VolumeIntegrator::has_volume_paths(const Scene& scene, const VolumeTables& tables) const {
  return (tables.media.size() > 1 || tables.scene.passes_straight()) &&
         settings_.length.max_depth > 0 && !scene.emitters().empty();
}

void VolumeIntegrator::render(const Scene& scene, const Sensor& sensor,
                              RenderContext& context) const {
  const VolumeTables tables(scene, sensor);
  if (!has_volume_paths(scene, tables)) return PathIntegrator::render(scene, sensor, context);
  render_volumes(tables, settings_, sensor, context);
}

std::unique_ptr<Passes> VolumeIntegrator::begin(const Scene& scene, const Sensor& sensor,
                                                RenderContext& context, double seconds) const {
  auto tables = std::make_unique<const VolumeTables>(scene, sensor);
  if (!has_volume_paths(scene, *tables)) {
    return PathIntegrator::begin(scene, sensor, context, seconds);
  }
  return std::make_unique<VolumePasses>(std::move(tables), settings_, scene, sensor, context);
}

}  // namespace kinome::transport
