// Shading of surface points by light points and by the emitters without light points.
#include <algorithm>
#include <memory>
#include <numeric>

#include "clustered/points/light_pairs.h"
#include "clustered/points/point_lights.h"
#include "kinome/wide/surface_point.h"
#include "transport/direct/direct_light.h"
#include "transport/paths/camera_block.h"
#include "transport/shadows/rays.h"

namespace kinome {

using namespace wide;
using transport::Surfaces;
using transport::Vertices;

namespace {

/// Number of dimensions of the sampler for mirror reflection, rounded up.
constexpr uint32_t kMirrorDimensions = 4;

/// Light of emitters without light points: one sample of each, for each point. One per thread.
class SingleLights {
 public:
  /// Allocates memory for the points of blocks of at most `rays` rays.
  SingleLights(const transport::SceneTable& scene, const Sampler& sampler, size_t rays)
      : scene_(scene.scene()),
        sampler_(sampler),
        numbers_(rays),
        arena_(Surfaces::max_points(scene, rays)),
        all_(arena_.indices()),
        u_(arena_.two()),
        light_{arena_.three(), arena_.floats(), arena_.floats(), arena_.three(), arena_.floats()},
        wo_(arena_.three()),
        answer_(transport::make_answer(arena_)),
        reflected_(arena_.three()),
        rays_(arena_.rays()),
        occlusion_(arena_.capacity()) {
    std::iota(all_, all_ + arena_.capacity(), 0u);
  }

  /// Adds the light of `emitters`. Uses two dimensions of the sampler for each, from `dimension`
  /// on.
  void add(const PixelSamples& samples, const Vertices& vertices,
           std::span<const Emitter* const> emitters, uint32_t dimension, const Columns3& radiance,
           RenderCounters& counters) {
    const size_t count = vertices.surfaces->scattering();
    for (const Emitter* const emitter : emitters) {
      {
        const StageTimer timer(counters.stage_seconds["evaluate"]);
        sample(samples, vertices, *emitter, dimension, counters);
      }
      dimension += 2;
      const StageTimer timer(counters.stage_seconds["shadow"]);
      occlusion_.trace(scene_, rays_, count, counters);
      for (size_t i = 0; i < count; ++i) {
        // Neither inactive nor occluded.
        if (!(rays_[i / kBlockLanes].tmax[i % kBlockLanes] >= 0)) continue;
        const uint32_t k = vertices.owner[i];
        radiance.set(k, radiance.at(k) + reflected_.at(i));
      }
    }
  }

 private:
  void sample(const PixelSamples& samples, const Vertices& vertices, const Emitter& emitter,
              uint32_t dimension, RenderCounters& counters) {
    const Surfaces& surfaces = *vertices.surfaces;
    const SurfaceBlock& points = surfaces.points();
    const size_t count = surfaces.scattering();
    if (!emitter.is_delta()) {
      numbers_.fill_2d(sampler_, samples, dimension, vertices.owner, count, u_);
    }
    emitter.sample_direct_block(points.p, u_, count, light_);
    transport::drop_self_occlusion(emitter, points, all_, count, light_);
    for_lanes(count, [&](size_t i) {
      frame_at(points, i).to_local(wide::Vec3::load(light_.d, i)).store(wo_, i);
    });
    transport::shade(surfaces, {.wo = wo_, .lobes = Lobe::kDiffuse | Lobe::kGlossy}, answer_);
    for_lanes(count, [&](size_t i) {
      const Float pdf = Float::load(light_.pdf + i);
      const Mask is_sample = Float::load(surfaces.live() + i) > 0.f && pdf > 0.f;
      wide::Rgb value = wide::Rgb::load(answer_.f, i) * wide::Rgb::load(light_.radiance, i) / pdf;
      if (vertices.throughput.x) value = value * wide::Rgb::load(vertices.throughput, i);
      const Mask on = is_sample && !is_black(value);
      counters[RayKind::kShadow] += wide::count(on);
      counters.skipped_shadow_rays += wide::count(is_sample && !on);
      value.store(reflected_, i);
      transport::write_shadow_rays(points, i, wide::Vec3::load(light_.d, i),
                                   Float::load(light_.distance + i), on, true, rays_);
    });
  }

  const Scene& scene_;
  const Sampler& sampler_;
  transport::Numbers numbers_;
  transport::Arena arena_;
  uint32_t* all_;
  Columns2 u_;
  DirectBlock light_;
  Columns3 wo_;
  BsdfAnswer answer_;
  Columns3 reflected_;
  Ray16* rays_;
  transport::Occlusion occlusion_;
};

/// Shades the surfaces that the camera rays of a block hit. One per thread.
class PointLightShader {
 public:
  /// Allocates memory for blocks of at most `rays` samples.
  PointLightShader(const transport::SceneTable& scene, const ScenePointLights& lights,
                   const PointLightOptions& options, const Sampler& sampler, size_t rays)
      : lights_(lights),
        options_(options),
        has_mirrors_(
            std::any_of(scene.rows().begin(), scene.rows().end(),
                        [](const auto& row) { return any(row.bsdf->lobes() & Lobe::kDelta); })),
        pairs_(scene.scene(), options.max_geometry_term),
        single_lights_(scene, sampler, rays),
        mirrors_(scene, sampler, {0, 1, Lobe::kDelta}, rays),
        arena_(rays),
        per_point_(Surfaces::max_points(scene, rays)),
        owner_{per_point_.indices(), per_point_.indices()},
        throughput_{per_point_.three(), per_point_.three()} {
    if (options.hide_emitters && scene.scene().environment()) straight_ = arena_.floats();
  }

  /// Adds the light that the surfaces reflect.
  void add(const PixelSamples& samples, const Surfaces& seen, const Columns3& radiance,
           RenderCounters& counters) {
    Vertices vertices{&seen, seen.points().ray, {}};
    if (straight_) {
      std::fill_n(straight_, samples.count(), 1.f);
      vertices.straight = straight_;
    }
    const size_t per_vertex =
        kMirrorDimensions + kChooseDimensions * lights_.sets.size() + 2 * lights_.others.size();
    uint32_t dimension = transport::kCameraDimensions;
    for (uint32_t depth = 1; depth < options_.max_depth; ++depth) {
      if (vertices.surfaces->scattering() > 0) {
        light_points(samples, vertices, depth, dimension + kMirrorDimensions, radiance, counters);
      }
      if (!has_mirrors_ || vertices.surfaces->reflecting() == 0) return;
      vertices = reflect(samples, vertices, dimension, radiance, counters);
      dimension += static_cast<uint32_t>(per_vertex);
    }
  }

 private:
  /// Adds the light of points that are `depth` edges from the camera.
  void light_points(const PixelSamples& samples, const Vertices& vertices, uint32_t depth,
                    uint32_t dimension, const Columns3& radiance, RenderCounters& counters) {
    const SurfaceBlock& points = vertices.surfaces->points();
    for (const PointLightSet& set : lights_.sets) {
      if (depth + (set.is_indirect ? 2 : 1) <= options_.max_depth) {
        set.choose({samples, *vertices.surfaces, vertices.owner, dimension}, counters,
                   [&](size_t i, const Bsdf& bsdf, const PointSelection& chosen) {
                     const kinome::Rgb weight =
                         vertices.throughput.x ? vertices.throughput.at(i) : kinome::Rgb(1.f);
                     pairs_.add(points, i, bsdf, vertices.owner[i], weight, set.points, chosen,
                                radiance, counters);
                   });
      }
      dimension += kChooseDimensions;
    }
    pairs_.finish(radiance, counters);
    single_lights_.add(samples, vertices, lights_.others, dimension, radiance, counters);
  }

  /// Adds the emitted light that perfect mirrors among `vertices` reflect, to which light points
  /// can't contribute. Returns the surfaces that they reflect.
  Vertices reflect(const PixelSamples& samples, const Vertices& vertices, uint32_t dimension,
                   const Columns3& radiance, RenderCounters& counters) {
    {
      const StageTimer timer(counters.stage_seconds["shade"]);
      mirrors_.sample(samples, vertices, std::nullopt, dimension);
    }
    mirrors_.trace(vertices, Surfaces::Which::kAll, radiance, counters);
    const StageTimer timer(counters.stage_seconds["bounce"]);
    const Surfaces& met = mirrors_.met();
    current_ = 1 - current_;
    Vertices next{&met, owner_[current_], throughput_[current_]};
    next.straight = vertices.straight;
    for_lanes(met.reflecting(), [&](size_t i) {
      const Int from = as_int(gather(mirrors_.from(), Int::load(met.points().ray + i)));
      gather(vertices.owner, from).store(owner_[current_] + i);
      gather(mirrors_.carried(), from).store(next.throughput, i);
    });
    return next;
  }

  const ScenePointLights& lights_;
  const PointLightOptions& options_;
  bool has_mirrors_;
  LightPairs pairs_;
  SingleLights single_lights_;
  transport::DirectLight mirrors_;
  transport::Arena arena_;
  transport::Arena per_point_;
  /// State at the points that mirrors reflect: of the last call of reflect(), and of the one
  /// before.
  uint32_t* owner_[2];
  Columns3 throughput_[2];
  int current_ = 0;
  float* straight_ = nullptr;  ///< see transport::Vertices
};

}  // namespace

void render_point_lights(const Scene& scene, const Sensor& sensor, RenderContext& context,
                         const ScenePointLights& lights, const PointLightOptions& options) {
  const transport::SceneTable table(scene);
  transport::render_blocks<PointLightShader>(
      table, sensor, context, PathSettings{{options.max_depth, 5}, options.hide_emitters},
      [&] {
        return std::make_unique<PointLightShader>(table, lights, options, sensor.sampler(),
                                                  transport::kBlockSamples);
      },
      [](PointLightShader& shader, const transport::CameraBlock& block,
         const PixelSamples& samples, RenderCounters& counters) {
        shader.add(samples, block.seen(), block.radiance(), counters);
      });
}

}  // namespace kinome
