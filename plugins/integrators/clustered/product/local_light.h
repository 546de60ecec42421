#pragma once

#include <span>
#include <unordered_map>
#include <vector>

#include "clustered/kernels/importance_kernels.h"
#include "clustered/kernels/local_kernels.h"
#include "clustered/product/light_aim.h"
#include "clustered/product/light_guide.h"
#include "clustered/product/point_partition.h"
#include "clustered/product/source_choice.h"
#include "clustered/product/straight_rays.h"
#include "kinome/emitter.h"
#include "kinome/scene.h"
#include "path_parameters.h"
#include "transport/scene_table.h"

namespace kinome {

/// A place that light comes from, of a surface that emits or reflects it, drawn by its flux.
struct LightPoint {
  Vec3 position{0.f};
  Vec3 normal{0.f};     ///< unit shading normal, on the side that light leaves to
  Vec3 geometric{0.f};  ///< unit geometric normal; of reflected light, on the side it came from
  /// Radiance that leaves toward all sides alike / density per area. Where `reflection` is given,
  /// of a Lambertian surface in its place.
  Rgb power{0.f};
  /// Density of the point by a BSDF ray from elsewhere, and what it does there, over that of points
  /// of the pass, as far as its cell tells: to be multiplied by the ray's density per area. See
  /// LocalLight::eye_ratio.
  float eye_ratio = 0;
  uint32_t cell = 0;
  static constexpr uint32_t kLambertian = ~0u;
  uint32_t reflection = kLambertian;
  /// Of reflected light, where the normals differ: how far `position` is off the surface, to the
  /// side of `geometric`. Else 0.
  float off_surface = 0;
  /// Of reflected light: edges of its path up to here.
  uint32_t edges = 0;
  /// All that the surface does with light is to send it on by wide lobes, on one side.
  bool is_plain = false;
  /// Its light has left an emitter that rays can meet by delta lobes, straight after the emitter:
  /// paths from the eye have LocalLight::kShownEyeShare of the odds of finding it.
  bool is_shown = false;

  /// Where a ray along d, on its way to the point, is to end: before the surface. Light may leave
  /// it on the other side than it came to, for shading normals alone tell what is reflected.
  Vec3 end_of_ray(const Vec3& d) const {
    const bool is_behind = glm::dot(geometric, d) > 0;
    return is_behind ? position - 2 * off_surface * geometric : position;
  }
};

/// How the light of sources that rays can hit is found where it comes by a point's glossy lobe:
/// kWide: by light points, and by eye rays that meet the point; kNarrow: also by eye rays that go
/// on from there by the lobe; kMirroring: by these, with no light points.
enum class LobeWidth { kWide, kNarrow, kMirroring };
/// Of the lobe on the side of si.wi; the same for all directions there.
LobeWidth lobe_width(const SurfaceInteraction& si);
/// True where all light is sent on by kWide lobes, to the side that it comes from. `width`: of the
/// glossy lobe, if there is one.
bool is_plain(const SurfaceInteraction& si, LobeWidth width);
inline bool is_plain(const SurfaceInteraction& si) { return is_plain(si, lobe_width(si)); }

/// Density of the directions that light comes from by more than an edge, per solid angle: a guess,
/// by which light points share it with paths from the eye that go on by narrow lobes.
inline constexpr float kDeepDensity = kInvPi;

/// Light on a surface that isn't Lambertian.
struct Reflection {
  SurfaceInteraction si;
  Vec3 to_light{0, 0, 1};                       ///< in the shading frame
  Rgb incident{0.f};                            ///< radiance x solid angle / density per area
  simd::SentLobe lobe;                          ///< estimate of the BSDF, for importance only
  Lobe lobes = Lobe::kDiffuse | Lobe::kGlossy;  ///< that send the light of the point on
  /// If the lobe is kNarrow and the source is no lamp, LocalLight::Arrival::density, or
  /// kDeepDensity; else 0.
  float light_density = 0;
  struct Sent {
    Rgb radiance{0.f};  ///< / density per area
    /// Of an eye ray from where it is sent to: density of the light's direction by the lobe, over
    /// that of LocalLight::sample_arrival.
    float follow_ratio = 0;
  };
  /// Toward the unit direction d.
  Sent toward(const Vec3& d) const;
};

struct CellSums;
struct LightOrigin;
struct LightWalk;
namespace transport {
struct AdjointSample;
}

/// Points of one pass, cell by cell and near one another within each.
struct LocalPoints {
  std::vector<LightPoint> points;
  std::vector<simd::LightPointRow> rows;  ///< of the same points
  std::vector<uint32_t> reflection;       ///< LightPoint::reflection of the same points
  std::vector<uint32_t> first;            ///< of each cell of LocalLight; one more entry than cells
  std::vector<Reflection> reflections;
  bool has_bent_normals = false;  ///< some point's off_surface isn't 0
  /// Number of points over that of a pass. Powers are those of points of a pass all the same, which
  /// readers must divide by this.
  float share = 1;
};

/// What is known of the cells before any pass; arrays of padded_size().
struct LocalCellColumns {
  std::vector<float> position[3];  ///< mean
  std::vector<float> spread2;      ///< variance of the position
  std::vector<float> normal[3];    ///< mean, not of unit length: shorter where normals differ
  std::vector<float> flux;         ///< sum of |power|, of all points of a pass
  std::vector<float> guided_flux;  ///< flux x density of the guide: how much of it is of use
  std::vector<float> expected;     ///< points of a pass
};

/// Light of sources within a scene, directly and after bounces, divided into cells: of lamps (which
/// have no extent), of surfaces that emit, and of surfaces that any emitter lights, the environment
/// included: straight, and by way of other surfaces. Cells and the density of points are fixed at
/// construction; each pass draws points anew. Immutable; thread-safe.
class LocalLight {
 public:
  /// Below this depth there is no bounce.
  static constexpr uint32_t kBounceDepth = 3;
  /// Multiples of this many cells.
  static constexpr uint32_t kPadding = 16;

  /// By what odds of paths from the eye, against light points, are multiplied in light that a chain
  /// of delta lobes (mirrors, smooth glass) shows: they can but meet its source by chance, so that
  /// what they find of it is rare and bright.
  static constexpr float kShownEyeShare = 0.1f;

  /// True where all emitters offer what is needed for paths of so many segments, and their flux is
  /// no more than single precision holds.
  static bool serves(const Scene& scene, uint32_t max_depth);

  struct Settings {
    PathLength length{2, 5};
    uint32_t bounce_cells = 256;
    /// Of a pass: so many of surfaces, or more where these are many, and as many of the bounce.
    uint32_t points = kMostPoints;
    /// But so many of the bounce, if these are more, if all of its light were that of sources that
    /// have an extent, or the sky's: each point has one direction of it, and says less of what is
    /// around it than one that a lamp lights.
    uint32_t extended_points = 0;
    /// Light of lamps by way of mirrors is found by paths from the lamps, see Caustics.
    bool caustics = false;
    /// If aimed_share() is below this and there are no lamps, no cells are made, and is_complete() is
    /// false.
    double min_aimed_share = 0;
  };
  static constexpr uint32_t kLeastPoints = 1u << 10, kMostPoints = 1u << 14;
  static constexpr uint32_t kMostExtendedPoints = 1u << 17;

  /// seen: places that the camera sees, by which draws are guided; may be empty.
  LocalLight(const Scene& scene, const Settings& settings, std::span<const SurfaceInteraction> seen,
             uint64_t seed, RenderContext& context);

  bool empty() const { return size_ == 0; }
  /// See Settings::min_aimed_share.
  bool is_complete() const { return is_complete_; }
  /// Estimated share of the flux of bounced light that is emitted toward what the camera sees the
  /// effect of; 1 if unknown.
  double aimed_share() const { return aimed_share_; }
  uint32_t size() const { return size_; }
  uint32_t padded_size() const { return static_cast<uint32_t>(columns_.flux.size()); }
  uint32_t max_depth() const { return length_.max_depth; }
  const PathLength& length() const { return length_; }
  /// The scene, if it has surfaces that light passes straight (Lobe::kNull); nullptr: it has none.
  /// Light passes them, each as one edge of its path, as if it came to what is behind them by the
  /// edge before. But light of lamps stops at them, unless Caustics finds it behind one of them.
  const transport::SceneTable* passing() const {
    return passes_straight(table_, max_depth()) ? &table_ : nullptr;
  }
  const LocalCellColumns& columns() const { return columns_; }
  /// Around the points that the cell was made of.
  const std::vector<Aabb>& boxes() const { return boxes_; }
  /// Cells of lamps are [0, lamp_cells()); then those of surfaces, then those of the bounce.
  uint32_t lamp_cells() const { return lamp_cells_; }
  bool has_bounce() const { return !bounce_ends_.empty(); }
  /// What mirrors, or nearly does, shows light of sources that have an extent, or the sky's, to
  /// other surfaces: no light point does.
  bool needs_eye_rays() const { return needs_eye_rays_; }
  bool has_surfaces() const { return !surface_ends_.empty(); }
  /// There are sources that rays can meet.
  bool has_extended() const { return has_extended_; }
  /// There may be light by way of mirrors that paths from its sources are to look for: of lamps,
  /// which nothing else finds, and of sources that rays can meet.
  bool has_lamp_caustics() const { return has_lamp_caustics_; }
  bool has_extended_caustics() const { return has_extended_caustics_; }
  /// The same of what nearly mirrors, to which light points of lamps leave it.
  bool has_glossy_caustics() const { return has_glossy_caustics_; }
  /// Of all emitters, by which those are drawn whose light may come by mirrors, sources that rays
  /// can meet among them or not: by their flux; 0 for others.
  std::vector<float> caustic_shares(bool with_extended) const;
  const Emitter& emitter(uint32_t source) const { return *sources_[source].emitter; }
  /// Of an emitter of the scene.
  uint32_t source_of(const Emitter& emitter) const { return source_of_.at(&emitter); }
  bool is_lamp(uint32_t source) const { return sources_[source].kind == Kind::kLamp; }

  /// Lamps of each cell: lamp_first()[c] to lamp_first()[c + 1] of lamps().
  const std::vector<const Emitter*>& lamps() const { return lamps_; }
  const std::vector<uint32_t>& lamp_first() const { return lamp_first_; }

  /// Draws a share of the points of a pass: about points_of_pass() times `share`.
  LocalPoints draw(uint64_t seed, RenderContext& context, float share = 1) const;
  uint32_t points_of_pass() const { return surface_count_ + bounce_count_; }

  /// Of a point of an emitting surface that a ray found; its cell, and as LightPoint::eye_ratio.
  struct Place {
    uint32_t cell = 0;
    float eye_ratio = 0;
  };
  Place surface_place(const SurfaceInteraction& si) const;

  /// Light at a surface point that a ray found, from a source drawn by SourceChoice.
  struct Arrival {
    Vec3 d{0, 0, 1};  ///< unit, toward the light
    float distance = kInfinity;
    Rgb radiance{0.f};  ///< / density; to be multiplied by f cos of the surface
    Place place;
    float density = 0;  ///< of d, per solid angle; 0: no ray finds the source, which is a lamp
  };
  /// u1 picks the source, u the place on it. nullopt: no light.
  std::optional<Arrival> sample_arrival(const SurfaceInteraction& si, float u1,
                                        const Vec2& u) const;
  /// Place and density of the arrival that light is which a ray along d from `si` found: at x or,
  /// if that is nullptr, in the sky.
  struct Found {
    Place place;
    float density = 0;
  };
  /// Of light that comes to `si` by more than one edge; cos_light: of the direction that it comes
  /// from, in the shading frame.
  Place deep_place(const SurfaceInteraction& si, float cos_light) const;
  /// The same where paths from the eye have come to as their third surface point, of points of any
  /// light: the side is that of si.wi.
  Place third_place(const SurfaceInteraction& si) const;
  /// Place::eye_ratio of those of the cell.
  float third_ratio(uint32_t cell) const { return third_ratios_[cell]; }
  Found found_arrival(const SurfaceInteraction& si, const Vec3& d, float distance,
                      const SurfaceInteraction* x) const;

 private:
  enum class Kind { kLamp, kSurface, kEnvironment };
  struct Source {
    const Emitter* emitter;
    Kind kind;
    double flux = 0;
    float surface_share = 0;  ///< probability of points of its surface
    float bounce_share = 0;   ///< and of points that it lights
    float aimed_part = 1;     ///< of its flux, estimated share that is emitted toward the spheres
    AimDisks disks{};         ///< if its light is parallel for each direction
    AimCones cones{};         ///< if it is emitted from one position
  };
  /// What one thread draws.
  struct Drawn;
  struct Walker;
  class Walkers;
  void find_sources(uint64_t seed);
  void make_lamp_cells();
  /// Finds the spheres that the light of a bounce is aimed at, and sets sources' shares by them.
  void aim_sources(std::span<const SurfaceInteraction> seen, uint64_t seed, RenderContext& context);
  /// The points, weighted by the light that a sample of an emitter finds there. Where it finds
  /// hardly any, all light counts alike.
  std::vector<WeightedPosition> lit_positions(const std::vector<EyePoint>& points,
                                              RenderContext& context) const;
  AimCones surface_cones(const SurfaceInteraction& x) const;
  double flux_to_aims(const Source& source, uint64_t seed) const;
  /// Number of draws that the flux of a source is estimated from.
  uint32_t draws_of_flux() const;
  /// Chooses what a ray of a source without surface is aimed at, as pick_aim() does.
  static int pick(const Source& source, Vec2& position, Vec2& direction);
  /// Aims a ray of Emitter::sample_emission, and sets its power by the density of all aims. Returns
  /// this density over that without aims.
  static float aim(const Source& source, int aimed, const Vec2& position, const Vec2& direction,
                   EmissionSample& ray);
  std::vector<LightGuide::Use> find_uses(const std::vector<Drawn>& chunks,
                                         std::span<const SurfaceInteraction> seen, uint64_t seed,
                                         RenderContext& context) const;
  /// Returns `count` draws that are guided as those of passes will be.
  std::vector<Drawn> learn_guide(bool bounce, uint32_t count,
                                 std::span<const SurfaceInteraction> seen, uint64_t seed,
                                 RenderContext& context);
  /// At most `count`; a pass will have `repeated` times as many points as were drawn.
  void make_cells(bool bounce, uint32_t count, const std::vector<Drawn>& drawn, double repeated);
  /// unguided, useless: sums over the expected points of 1 / LightOrigin::guided and of
  /// 1 / (LightOrigin::guided x LightOrigin::aimed).
  void add_column(const CellSums& sums, double flux, double expected, double unguided,
                  double useless);
  void draw_part(bool bounce, uint32_t count, uint64_t seed, RenderContext& context,
                 std::vector<Drawn>& chunks) const;
  void sample_source(std::span<const LightOrigin> origins, Walker& walker) const;
  void add_surface_points(std::span<const LightOrigin> origins, Walker& walker, Drawn& out) const;
  void leave(std::span<const LightOrigin> origins, uint64_t seed, uint32_t first_draw,
             Walker& walker, Drawn& out) const;
  void walk_on(Walker& walker, Drawn& out) const;
  const BsdfAnswer& sample_next(std::span<const LightWalk> walks, Walker& walker) const;
  bool take_parts(Walker& walker, Drawn& out) const;
  void add_part(const LightWalk& walk, const SurfaceInteraction& si, float distance, uint32_t parts,
                uint32_t index, Drawn& out) const;
  std::optional<Ray> go_on(LightWalk& walk, const SurfaceInteraction& si,
                           const transport::AdjointSample& sample, float distance) const;
  /// Learns where walks are split, from draws without. Returns false if no walk is.
  bool learn_splits(const std::vector<Drawn>& drawn, std::span<const SurfaceInteraction> seen,
                    uint64_t seed, RenderContext& context);
  /// Number of parts in which a walk goes on from a light point that it has left.
  uint32_t parts_at(const LightPoint& point) const;
  void land(const LightWalk& walk, const SurfaceInteraction& si, float distance, Drawn& out) const;
  LocalPoints sort_by_cell(std::vector<Drawn>& chunks, RenderContext& context) const;
  uint32_t surface_cell(const SurfaceInteraction& si) const;
  uint32_t bounce_cell(const SurfaceInteraction& si, float side) const;
  SourceChoice::At asked_at(const SurfaceInteraction& y, float side) const;
  /// Density of a place y that is lit along d (from the light) by a bounce's eye path, over that of
  /// the pass's points at y, unless these are guided: both given the place x on the light, if it
  /// has a surface. probability: that the path asks the source.
  float eye_ratio(const Source& source, float probability, const SurfaceInteraction* x,
                  const SurfaceInteraction& y, const Vec3& d, float distance) const;
  Place bounce_place(const Source& source, float probability, const SurfaceInteraction* x,
                     const SurfaceInteraction& y, const Vec3& d, float distance) const;

  const Scene& scene_;
  const transport::SceneTable table_;
  const PathLength length_;
  std::vector<Source> sources_;
  std::vector<double> surface_ends_, bounce_ends_;  ///< running sums of shares, or empty
  SourceChoice arrivals_;                           ///< where there is a bounce
  std::unordered_map<const Emitter*, uint32_t> source_of_;
  std::vector<const Emitter*> lamps_;
  std::vector<uint32_t> lamp_first_;
  std::vector<AimSphere> aims_;  ///< empty: light isn't aimed
  double aimed_share_ = 1;
  bool is_complete_ = true;
  LightGuide surface_guide_, bounce_guide_;
  PointPartition split_partition_;
  std::vector<float> splits_;  ///< of its cells: parts of a walk for each unit of power; or empty
  PointPartition surface_partition_, bounce_partition_;
  uint32_t lamp_cells_ = 0, surface_cells_ = 0, size_ = 0;
  uint32_t surface_count_ = 0, bounce_count_ = 0;
  const bool finds_caustics_;
  bool has_extended_ = false, needs_eye_rays_ = false;
  bool has_lamp_caustics_ = false, has_glossy_caustics_ = false, has_extended_caustics_ = false;
  LocalCellColumns columns_;
  std::vector<Aabb> boxes_;
  /// Of each cell: mean of 1 / density of the guide, by which eye_ratio is to be multiplied.
  std::vector<float> eye_factors_;
  /// Of each cell: area that it has for each point of a pass whose light has come by more than an
  /// edge: what eye_ratio is of such points, and of what paths from the eye find there.
  std::vector<float> deep_ratios_;
  std::vector<float> third_ratios_;  ///< the same of points of any light
};

/// About `count` places of surfaces that a sensor sees, spread evenly over its picture; fewer where
/// it sees none. Surfaces that reflect nothing, or only mirror, are not among them.
std::vector<SurfaceInteraction> places_seen(const Scene& scene, const Sensor& sensor,
                                            uint32_t count, uint64_t seed, RenderContext& context);

}  // namespace kinome
