#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "clustered/kernels/lobe_kernels.h"
#include "clustered/product/visibility.h"
#include "kinome/primary_rays.h"

namespace kinome {

/// Draws places of samples around a pixel's centre with the density of the film's filter, so that
/// each sample counts for its own pixel alone, whatever their number in the next pixel ("filter
/// importance sampling", Ernst et al. 2006). Filters must not be negative.
class FilterSampler {
 public:
  explicit FilterSampler(const ReconstructionFilter& filter);
  /// Film position of a sample of pixel (x, y), which lies in `region`: there the filter is cut off
  /// and normalised again, as the film's weighted mean is.
  Vec2 place(int x, int y, const Vec2& u, const Rect& region) const;

 private:
  static constexpr int kBins = 4096;
  float place_1d(int pixel, float u, int low, int high) const;
  float cumulated(float offset) const;
  float radius_;
  bool is_box_;
  std::vector<float> cumulated_;  ///< of the filter from -radius to each bin's end
};

/// Side of the tiles that learn together, in pixels.
inline constexpr int kTileSide = 4;

/// Camera rays of a small tile of pixels, each with a number of its own, and the surfaces that they
/// meet. Keeps its memory: one per thread.
class TilePrimaries {
 public:
  struct View {
    const Scene& scene;
    const Sensor& sensor;
    const FilterSampler& filter;
    Rect region;  ///< where film positions may lie
    bool hide_emitters = false;
  };

  /// The whole film of the sensor.
  static View view_of(const Scene& scene, const Sensor& sensor, const FilterSampler& filter,
                      bool hide_emitters);

  /// counts[i] rays for pixel i of `pixels`, row by row. Each pixel's are the first so many of one
  /// sequence for each seed, in the order of a Hilbert curve.
  void trace(const View& view, const Rect& pixels, std::span<const uint16_t> counts, uint64_t seed,
             RenderCounters& counters);

  size_t size() const { return rays_.size(); }
  /// Rays [first(i), first(i + 1)) are those of pixel i.
  uint32_t first(size_t pixel) const { return first_[pixel]; }
  uint32_t pixel(size_t i) const { return pixels_[i]; }
  const SurfaceInteraction& interaction(size_t i) const { return interactions_[i]; }
  bool hit(size_t i) const { return rays_[i].hit.valid(); }
  /// Light that the ray sees itself.
  const Rgb& emitted(size_t i) const { return emitted_[i]; }

  /// What reflects light from the cells; patch[i] < 0: nothing does.
  std::vector<int32_t> patch;
  std::vector<Vec3> normal;  ///< Bsdf::reflection_frame
  simd::PointFrames frames;  ///< the same, with its tangent and the viewer; where patch >= 0
  /// BsdfForm::diffuse, or LobeReflectance::diffuse where there is no form; 0: no such lobe.
  std::vector<Rgb> diffuse;
  simd::MicrofacetPoints microfacets;  ///< of points whose patch is_described
  simd::TurnedPoints turned;           ///< the same, where its form is_turned

  /// Length of a tile's side at a distance of t, world units.
  float width_at(float t) const { return origin_width_ + t * direction_width_; }

 private:
  void make_rays(const View& view, const Rect& pixels, std::span<const uint16_t> counts,
                 uint64_t seed);
  void look_behind_emitters(const View& view, RenderCounters& counters);
  void add_emitters(const View& view);

  std::vector<uint32_t> first_;
  std::vector<uint16_t> pixels_;
  std::vector<RayHit> rays_;
  std::vector<SurfaceInteraction> interactions_;
  std::vector<Rgb> emitted_;
  std::vector<uint32_t> missed_;
  std::vector<Vec3> directions_;
  std::vector<Rgb> environment_;
  float origin_width_ = 0;
  float direction_width_ = 0;
};

/// A piece of surface of one material and nearly one normal, as a tile of pixels sees it: what
/// shares learned visibility and a list of cells.
struct Patch {
  const Bsdf* bsdf = nullptr;
  Vec3 normal{0, 0, 1};          ///< mean
  Vec3 position{0.f};            ///< mean
  Vec3 viewer{0, 0, 1};          ///< mean, unit
  float cone_cosine = 1;         ///< all normals are within
  float tolerance = 0;           ///< distance from the plane within which points belong here
  Rgb diffuse{0.f};              ///< mean
  float glossy_reflectance = 0;  ///< of the first point, mean of channels
  /// All points have a BsdfForm of the kind of `form`, by which kernels may evaluate them.
  bool is_described = false;
  BsdfForm form;
  bool is_uniform = false;  ///< and their glossy lobes are alike
  /// Of a diffuse lobe without a form: its value relative to a Lambertian one of `diffuse`, at
  /// cosines as in BsdfForm::transmittance; nullptr: 1. Only control terms depend on it.
  std::shared_ptr<const std::array<float, BsdfForm::kTableSize>> probed;
  const float* transmittance() const {
    return is_described ? form.transmittance : probed ? probed->data() : nullptr;
  }
  /// Width of the glossy lobe, as of a GGX distribution of half vectors. Only importance depends on
  /// it.
  simd::HalfVectorLobe lobe{1, 1};
  float alpha2() const { return lobe.alpha_u * lobe.alpha_v; }
  uint32_t count = 0;  ///< points of the pilot
  /// Records of the pilot, of TileMemory::records.
  uint32_t first_record = 0;
  uint32_t end_record = 0;

  // What the plan found, of one primary:
  float uncertainty = 0;      ///< sum over strata of what rays are distributed by
  float glossy = 0;           ///< unshadowed glossy radiance
  float cell_share = 0.5f;    ///< of candidates that are drawn from the cells
  float mean_visibility = 1;  ///< of glossy light, and of local light but lamps
  float lamp_visibility = 1;
  float mean_sigma = 1;
  /// Rays that a primary's BSDF sends after local light, on average; at most 1.
  float eye_rays = 0.5f;
  bool trust = true;  ///< false: v is of no use to the glossy lobe
};

/// BsdfForm::transmittance at a cosine.
inline float interpolate_transmittance(const float* table, float cosine) {
  constexpr int kLast = BsdfForm::kTableSize - 1;
  const float x = std::clamp(cosine, 0.f, 1.f) * kLast;
  const int i = std::min(static_cast<int>(x), kLast - 1);
  const float w = x - static_cast<float>(i);
  return (1 - w) * table[i] + w * table[i + 1];
}

inline bool is_microfacet(const BsdfForm& form) {
  return form.glossy == BsdfForm::Glossy::kBeckmann || form.glossy == BsdfForm::Glossy::kGgx;
}

/// The same for kernels.
inline simd::MicrofacetKind kind_of(const BsdfForm& form) {
  simd::MicrofacetKind kind;
  kind.is_ggx = form.glossy == BsdfForm::Glossy::kGgx;
  kind.is_conductor = form.is_conductor;
  for (int c = 0; c < 3; ++c) {
    kind.eta[c] = form.eta[c];
    kind.k[c] = form.k[c];
  }
  return kind;
}
inline simd::FirstMicrofacet microfacet_of(const BsdfForm& form) {
  return {form.alpha_u, form.alpha_v, {form.specular.x, form.specular.y, form.specular.z}};
}

/// Reflects by a lobe so sharp that points of different normals share no directions.
inline bool is_sharp(const Patch& patch) {
  return patch.alpha2() < 0.01f && !any(patch.bsdf->lobes() & Lobe::kDiffuse);
}

/// What a tile keeps between pilot and the main pass.
struct TileMemory {
  std::vector<Patch> patches;
  std::vector<VisibilityRecord> records;
  /// Of each patch: v, then the root of sigma, of each cell, in 8 bits. Empty where the film is so
  /// large that each pass learns them again.
  std::vector<uint8_t> learned;
};

/// True where the point may belong to the patch.
bool belongs(const Patch& patch, const Bsdf* bsdf, const Vec3& normal, const Vec3& position);

/// Width of the glossy lobe at a point, whose form is `form` if it has one.
simd::HalfVectorLobe glossy_lobe(const SurfaceInteraction& si, const std::optional<BsdfForm>& form);

/// Divides the points of a pilot into patches.
void make_patches(TilePrimaries& primaries, std::vector<Patch>& patches);
/// Assigns the points of a later pass to the patches, making more where none fits.
void assign_patches(TilePrimaries& primaries, std::vector<Patch>& patches);

}  // namespace kinome
