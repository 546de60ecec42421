#pragma once

#include "clustered/product/tiles/tile_grid.h"
#include "kinome/light_groups.h"
#include "kinome/primary_rays.h"
#include "kinome/scene.h"
#include "kinome/sensor.h"
#include "transport/path_parameters.h"

namespace kinome {

/// Rays of one sample of `direct`: a camera ray, a ray toward an emitter, and a BSDF ray.
inline constexpr double kRaysPerSample = 3;

/// Settings of learned product sampling: the `clustered` integrator with `importance` = product.
struct ProductSettings {
  /// Mean number of rays of all kinds per pixel.
  double rays_per_pixel = 48;
  /// Halves the number of cells of distant light if rays are few, except in scenes of few
  /// primitives and if the number of rays is unknown.
  bool fewer_cells = true;
  /// Number of edges of paths: 2 is direct light, 3 adds one bounce.
  PathLength length{2, 5};
  /// Maximum number of cells of reflected light.
  uint32_t bounce_cells = 256;
  bool hide_emitters = false;
  /// Writes kProductChannels to layer 1 of the film.
  bool diagnostics = false;
  /// Light groups by which the image is divided, if any. Light that only Caustics finds is left
  /// out then.
  LightGroups groups{};
  /// Maximum number of pixels of an image whose learned visibilities are kept. Larger images learn
  /// them again in each pass. Also limits the number of pixels whose points the pilot keeps.
  /// Results don't depend on it.
  int remembered_pixels = 1 << 18;

  // Parts that can be switched off to measure their benefit. Estimates stay unbiased.
  bool control_variate = true;  ///< adds learned visible light without rays
  bool learned_sigma = true;    ///< sends rays where visibility is uncertain
  bool checked_sigma = true;    ///< corrects sigma by the pilot's own rays
  bool adaptive = true;         ///< sends more rays to pixels with more noise
  bool smooth_plan = true;    ///< averages the plan's weights over neighbours if the pilot is small
  bool horizon_terms = true;  ///< adds control terms of cells at the horizon of flat patches
  bool shared_candidates = true;  ///< shares glossy candidates among pixels that reflect alike
  bool light_guide = true;        ///< draws light points where they contribute to the image
  bool trial = true;              ///< leaves images to `path` if it takes less work
};

/// Channels of the film's layer 1, as weighted means over passes. `samples` is the number of camera
/// rays. `cost` is the number of rays of all kinds; ten unshadowed candidates count as one ray.
/// `visibility` is the learned fraction of the cells' light that arrives, or 0 if nothing was
/// learned.
inline constexpr const char* kProductChannels[] = {"samples", "cost", "visibility"};

/// A render by product sampling. All references must outlive it.
struct ProductTask {
  const Scene& scene;
  const Sensor& sensor;
  RenderContext& context;
  const ProductSettings settings;
  const TileGrid grid;
  const uint64_t seed;

  ProductTask(const Scene& of_scene, const Sensor& of_sensor, RenderContext& of_context,
              const ProductSettings& of_settings)
      : scene(of_scene),
        sensor(of_sensor),
        context(of_context),
        settings(of_settings),
        grid(sensor.film().sampled()),
        seed(key_seed(context.job, sensor.sampler())) {}
  /// True if the image is divided by light group.
  bool divides_light() const { return !settings.groups.is_empty(); }
  PathSettings path_settings() const { return {settings.length, settings.hide_emitters}; }
};

}  // namespace kinome
