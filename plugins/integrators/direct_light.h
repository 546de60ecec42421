#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "kinome/primary_rays.h"

namespace kinome {

/// Shadow rays at which a batch is full: what fits the caches.
inline constexpr size_t kShadowRays = 2048;

/// Dimensions of the sampler for one emitter sample (which, where) or BSDF sample (lobe, where).
inline constexpr uint32_t kLightDimensions = 3;

/// A surface point that light is looked for at. What it points to is the caller's.
struct ShadingPoint {
  const SurfaceInteraction* si;
  const SampleKey* key;
  Rgb throughput;  ///< what radiance toward the viewer counts as
  uint32_t owner;  ///< index of the radiance that it is added to
};

/// The surfaces that primary rays hit and that reflect; the owner is the ray.
void collect_shading_points(const PrimaryBatch& primary, std::vector<ShadingPoint>& points);

/// A sampled direction of a BSDF.
struct BsdfDirection {
  Vec3 d;          ///< unit, world space
  Rgb weight;      ///< the point's throughput x f |cos| / (density x number of samples)
  float pdf;       ///< per solid angle; 0: a delta lobe, which no emitter sample competes with
  uint32_t point;  ///< index into the batch
};

/// Light that comes straight from emitters to a batch of surface points: emitter samples, of
/// emitters picked uniformly, and BSDF samples, combined by the power heuristic (Veach 1997,
/// 9.2.4). Shadow rays of all points are traced as one batch; none is for a contribution of zero.
///
/// For each batch: begin(); sample_emitters(), sample_bsdfs(); then, for the directions of the
/// latter, find_environment() where no other light can be met, else make_bsdf_rays();
/// trace_shadow_rays(); trace_bsdf_rays(). Keeps its memory from one batch to the next: make one
/// per thread. Not thread-safe.
class DirectLight {
 public:
  /// What all batches share.
  struct Context {
    const Scene& scene;
    const Sampler& sampler;
    RenderCounters& counters;
    int emitter_samples = 1;  ///< of each point; 0: BSDF samples find all light that they can
    int bsdf_samples = 1;     ///< 0: emitter samples find all light that they can
    float pick_pdf() const { return 1 / static_cast<float>(scene.emitters().size()); }
  };

  /// `points` must stay where they are until the batch is done.
  void begin(std::span<const ShadingPoint> points);
  /// The scene must have emitters. Takes emitter_samples x kLightDimensions from `dimension` on.
  void sample_emitters(const Context& context, uint32_t dimension);
  /// Takes bsdf_samples x kLightDimensions from `dimension` on.
  void sample_bsdfs(const Context& context, uint32_t dimension);
  /// What sample_bsdfs() found, until one of the next two; may be changed, or made fewer.
  std::vector<BsdfDirection>& directions() { return directions_; }

  /// The scene must have an environment. The rays need but know whether they leave the scene.
  void find_environment(const Context& context);
  void make_bsdf_rays(const Context& context);

  /// Both add to radiance[ShadingPoint::owner].
  void trace_shadow_rays(const Context& context, std::span<Rgb> radiance);
  void trace_bsdf_rays(const Context& context, std::span<Rgb> radiance);
  /// Also hands on every surface that is met: fn(direction, si), in the order of directions().
  template <class Function>
  void trace_bsdf_rays(const Context& context, std::span<Rgb> radiance, Function&& fn);

 private:
  /// Light that arrives if nothing is in its ray's way.
  struct Pending {
    Rgb contribution;
    uint32_t owner;
  };
  void evaluate_emitter_samples(const Context& context, const ShadingPoint& point, size_t first);
  void add_shadow_ray(const Context& context, const Ray& ray, const Rgb& contribution,
                      uint32_t owner, RayKind kind);
  float bsdf_weight(const Context& context, float bsdf_pdf, float emitter_pdf) const;
  void evaluate_environment(const Context& context);
  void add_surface_light(const Context& context, std::span<Rgb> radiance,
                         const BsdfDirection& direction, const SurfaceInteraction& si);
  void trace_nearest(const Context& context);
  void add_environment(const Context& context, std::span<Rgb> radiance);

  std::span<const ShadingPoint> points_;
  std::vector<Ray> shadow_rays_;
  std::vector<Pending> shadow_pending_;
  std::vector<BsdfDirection> directions_;
  std::vector<RayHit> bsdf_rays_;

  /// Emitter samples of all points; then, of one point, what its BSDF is asked and says.
  std::vector<Vec3> positions_;
  std::vector<Vec2> numbers_;
  std::vector<uint32_t> picks_;
  std::vector<DirectSample> lights_;
  std::vector<uint32_t> valid_;
  std::vector<float> x_, y_, z_, r_, g_, b_, pdf_;

  /// Directions in which an environment is evaluated, and what it says.
  std::vector<Vec3> toward_;
  std::vector<uint32_t> missed_;  ///< indices of BSDF rays that look that way
  std::vector<Rgb> environment_;
  std::vector<float> environment_pdf_;
};

template <class Function>
void DirectLight::trace_bsdf_rays(const Context& context, std::span<Rgb> radiance, Function&& fn) {
  trace_nearest(context);
  for (size_t k = 0; k < bsdf_rays_.size(); ++k) {
    if (!bsdf_rays_[k].hit.valid()) continue;
    const SurfaceInteraction si = context.scene.interaction(bsdf_rays_[k]);
    if (si.shape->emitter()) add_surface_light(context, radiance, directions_[k], si);
    fn(directions_[k], si);
  }
  add_environment(context, radiance);
}

}  // namespace kinome
