#pragma once

#include <span>
#include <unordered_map>
#include <vector>

#include "clustered/kernels/importance_kernels.h"
#include "clustered/kernels/local_kernels.h"
#include "clustered/product/lights/light_aim.h"
#include "clustered/product/lights/light_guide.h"
#include "clustered/product/lights/point_partition.h"
#include "clustered/product/lights/source_choice.h"
#include "clustered/product/rays/straight_rays.h"
#include "kinome/emitter.h"
#include "kinome/scene.h"
#include "transport/blocks/large_array.h"
#include "transport/path_parameters.h"
#include "transport/surfaces/scene_table.h"

namespace kinome {

class Scheduler;

/// Light point (VPL): a random point on a surface that emits or reflects light, drawn in proportion
/// to its flux.
struct LightPoint {
  Vec3 position{0.f};
  Vec3 normal{0.f};     ///< unit shading normal, on the side where light leaves
  Vec3 geometric{0.f};  ///< unit geometric normal; for reflected light, on the side of the source
  /// Radiance / density per area, equal in all directions. If `reflection` is set, it is that of a
  /// Lambertian surface instead.
  Rgb power{0.f};
  /// Factor of an eye ray's density per area at this point. The product is the density at which eye
  /// rays find this light, relative to the density of the pass's points. See LocalLight::eye_ratio.
  float eye_ratio = 0;
  uint32_t cell = 0;
  static constexpr uint32_t kLambertian = ~0u;
  uint32_t reflection = kLambertian;  ///< index in LocalPoints::reflections, or kLambertian
  /// Distance of `position` from the surface, along `geometric`, if the light is reflected and the
  /// normals differ; else 0.
  float off_surface = 0;
  /// Number of edges of the light path up to this point, for reflected light.
  uint32_t edges = 0;
  /// True if is_plain() holds for the surface.
  bool is_plain = false;
  /// True if the light came from an emitting surface or the sky, and the first surface sent it on
  /// by a delta lobe. The odds of paths from the eye are multiplied by LocalLight::kShownEyeShare.
  bool is_shown = false;
  uint8_t group = 0;  ///< light group of the source; 0 if light isn't divided

  /// Returns the end of a shadow ray along d to this point, just before the surface. The ray may
  /// come from the other side than the light did, because reflection depends on shading normals.
  Vec3 end_of_ray(const Vec3& d) const {
    const bool is_behind = glm::dot(geometric, d) > 0;
    return is_behind ? position - 2 * off_surface * geometric : position;
  }
};

/// Width of a glossy lobe. It determines how the reflected light of surfaces and skies is found:
/// - kWide: by light points, and by eye rays that hit the point.
/// - kNarrow: also by eye rays that continue from there by the lobe.
/// - kMirroring: by eye rays that continue, not by light points.
enum class LobeWidth { kWide, kNarrow, kMirroring };
/// Returns the width of the lobe on the side of si.wi. It is the same for all directions there.
LobeWidth lobe_width(const SurfaceInteraction& si);
/// True if the surface reflects all light by kWide lobes, and transmits none. `width` is that of
/// the glossy lobe, or kWide if there is none.
bool is_plain(const SurfaceInteraction& si, LobeWidth width);
inline bool is_plain(const SurfaceInteraction& si) { return is_plain(si, lobe_width(si)); }

/// Assumed density, per solid angle, of directions of light that has come by several edges. Balance
/// weights between light points and paths from the eye that continue by narrow lobes use it.
inline constexpr float kDeepDensity = kInvPi;

/// Light that arrives at a light point whose surface isn't Lambertian.
struct Reflection {
  SurfaceInteraction si;
  Vec3 to_light{0, 0, 1};                       ///< in the shading frame
  Rgb incident{0.f};                            ///< radiance x solid angle / density per area
  simd::SentLobe lobe;                          ///< estimate of the BSDF, for importance only
  Lobe lobes = Lobe::kDiffuse | Lobe::kGlossy;  ///< lobes whose light the point represents
  /// LocalLight::Arrival::density, or kDeepDensity, if the lobe is kNarrow and the light isn't
  /// direct light of a lamp; else 0.
  float light_density = 0;
  struct Sent {
    Rgb radiance{0.f};  ///< radiance / density per area
    /// For an eye ray that hits the point: density of the light's direction by the lobe, relative
    /// to that of LocalLight::sample_arrival.
    float follow_ratio = 0;
  };
  /// Returns the light reflected in the unit direction d.
  Sent toward(const Vec3& d) const;
};

struct CellSums;
struct LightOrigin;
struct LightWalk;
namespace transport {
struct AdjointSample;
}

/// Light points of one pass, sorted by cell. Within a cell, neighbours are close to one another.
struct LocalPoints {
  LargeArray<LightPoint> points;
  LargeArray<simd::LightPointRow> rows;  ///< the same points, for kernels
  LargeArray<uint32_t> reflection;       ///< LightPoint::reflection of the same points
  LargeArray<uint8_t> group;             ///< LightPoint::group of the same points
  std::vector<uint32_t> first;           ///< first point of each LocalLight cell, and the end
  LargeArray<Reflection> reflections;
  bool has_bent_normals = false;  ///< true if off_surface isn't 0 for some point
  /// Number of points relative to that of a pass. Callers must divide powers by this value, because
  /// powers are those of a full pass.
  float share = 1;
};

/// Properties of the cells, which don't change between passes. Arrays have padded_size() elements.
struct LocalCellColumns {
  std::vector<float> position[3];  ///< mean
  std::vector<float> spread2;      ///< variance of the position
  std::vector<float> normal[3];    ///< mean, not normalised: shorter if normals differ
  std::vector<float> flux;         ///< sum of |power| over the points of a pass
  std::vector<float> guided_flux;  ///< flux x mean density of guide and aim: its useful part
  std::vector<float> expected;     ///< expected number of points of a pass
};

/// Local light, divided into cells: lamps, emitting surfaces, and surfaces that reflect light of
/// any emitter (the sky included), directly or after several bounces. Cells and the density of
/// points are fixed at construction. Each pass draws new points. Immutable; thread-safe.
class LocalLight {
 public:
  /// Minimum max_depth at which light bounces.
  static constexpr uint32_t kBounceDepth = 3;
  /// padded_size() is a multiple of this number.
  static constexpr uint32_t kPadding = 16;

  /// Factor of the odds of paths from the eye, against light points, for light seen through a chain
  /// of delta lobes (mirrors, smooth glass). These paths hit its source only by chance, so that
  /// their contributions are rare and bright.
  static constexpr float kShownEyeShare = 0.1f;

  /// True if all emitters support paths of `max_depth` edges, and their flux doesn't overflow
  /// single precision.
  static bool serves(const Scene& scene, uint32_t max_depth);
  /// True if a surface has a delta lobe: a mirror or smooth glass.
  static bool has_mirrors(const Scene& scene);
  /// True if a mirror may send light of a lamp without an area to other surfaces. Only paths from
  /// the emitters find this light.
  static bool may_have_lamp_caustics(const Scene& scene);

  struct Settings {
    PathLength length{2, 5};
    uint32_t bounce_cells = 256;
    /// Number of points of a pass on reflecting surfaces if lamps light them, and on emitting
    /// surfaces. There are more on many emitting surfaces, and fewer if light bounces.
    uint32_t points = kMaxPoints;
    /// Number of points on reflecting surfaces, if larger than `points`, if all of their light
    /// comes from surfaces and the sky. Mixtures are in between. Such a point has light from one
    /// direction only, and represents its surroundings less well than a point that a lamp lights.
    uint32_t extended_points = 0;
    /// True if Caustics finds the light of lamps that arrives by mirrors.
    bool caustics = false;
    /// If aimed_share() is below this value and there are no lamps, no cells are made, and
    /// is_complete() is false.
    double min_aimed_share = 0;
    LightGroups groups{};  ///< groups of the sources, if any
  };
  static constexpr uint32_t kMinPoints = 1u << 10, kMaxPoints = 1u << 14;
  static constexpr uint32_t kMaxExtendedPoints = 1u << 17;

  /// `seen` has surface points that the camera sees, for guide and aim; may be empty.
  LocalLight(const Scene& scene, const Settings& settings, std::span<const SurfaceInteraction> seen,
             uint64_t seed, RenderContext& context);

  bool empty() const { return size_ == 0; }
  /// See Settings::min_aimed_share.
  bool is_complete() const { return is_complete_; }
  /// Estimated fraction of the flux that is emitted toward the spheres of aim; 1 if unknown.
  double aimed_share() const { return aimed_share_; }
  uint32_t size() const { return size_; }
  uint32_t padded_size() const { return static_cast<uint32_t>(columns_.flux.size()); }
  uint32_t max_depth() const { return length_.max_depth; }
  const PathLength& length() const { return length_; }
  /// The scene; nullptr if it has no surfaces that light passes straight (Lobe::kNull). Light
  /// passes them as if they weren't there, but each counts as an edge of its path. Light of lamps
  /// stops at them, unless Caustics finds it behind one of them.
  const transport::SceneTable* passing() const {
    return table_.has_null_lobe() && max_depth() > 2 ? &table_ : nullptr;
  }
  const LocalCellColumns& columns() const { return columns_; }
  /// Bounds of the points from which each cell was made, with a margin.
  const std::vector<Aabb>& boxes() const { return boxes_; }
  /// Number of cells of lamps, which are [0, lamp_cells()). Cells of emitting surfaces follow, then
  /// those of reflected light.
  uint32_t lamp_cells() const { return lamp_cells_; }
  bool has_bounce() const { return !bounce_ends_.empty(); }
  /// True if mirrors or kMirroring lobes may reflect light of the sky or of surfaces to other
  /// surfaces. Only eye rays find it.
  bool needs_eye_rays() const { return needs_eye_rays_; }
  bool has_surfaces() const { return !surface_ends_.empty(); }
  /// True if there are sources that rays can hit: emitting surfaces or a sky.
  bool has_extended() const { return has_extended_; }
  /// True if Caustics must look for light of lamps that arrives by mirrors. Nothing else finds it.
  bool has_lamp_caustics() const { return has_lamp_caustics_; }
  /// True if Caustics may look for light of emitting surfaces and the sky that arrives by mirrors.
  bool has_extended_caustics() const { return has_extended_caustics_; }
  /// True if Caustics must look for light of lamps that arrives by kMirroring lobes, because light
  /// points leave it out.
  bool has_glossy_caustics() const { return has_glossy_caustics_; }
  /// Probabilities of all emitters for caustic paths, in proportion to flux. Lamps have 0 if
  /// has_lamp_caustics() is false, other emitters if `with_extended` is false.
  std::vector<float> caustic_shares(bool with_extended) const;
  const Emitter& emitter(uint32_t source) const { return *sources_[source].emitter; }
  /// Index of an emitter of the scene.
  uint32_t source_of(const Emitter& emitter) const { return source_of_.at(&emitter); }
  bool is_lamp(uint32_t source) const { return sources_[source].kind == Kind::kLamp; }
  /// Returns the light group of an emitter of the scene; 0 if there are no groups.
  uint32_t group_of(const Emitter& emitter) const { return sources_[source_of(emitter)].group; }

  /// Lamps of all cells. Cell c has [lamp_first()[c], lamp_first()[c + 1]).
  const std::vector<const Emitter*>& lamps() const { return lamps_; }
  const std::vector<uint8_t>& lamp_groups() const { return lamp_groups_; }  ///< group_of() of each
  const std::vector<uint32_t>& lamp_first() const { return lamp_first_; }

  /// Draws about points_of_pass() x `share` points.
  LocalPoints draw(uint64_t seed, RenderContext& context, float share = 1) const;
  uint32_t points_of_pass() const { return surface_count_ + bounce_count_; }

  /// Cell and eye_ratio (as LightPoint::eye_ratio) of a surface point that a ray found.
  struct Place {
    uint32_t cell = 0;
    float eye_ratio = 0;
  };
  /// Returns the place of a point of an emitting surface.
  Place surface_place(const SurfaceInteraction& si) const;

  /// Light that arrives at a surface point found by a ray, from a source drawn by SourceChoice.
  struct Arrival {
    Vec3 d{0, 0, 1};  ///< unit, toward the light
    float distance = kInfinity;
    Rgb radiance{0.f};  ///< radiance / density; to be multiplied by BSDF x cosine
    Place place;
    float density = 0;  ///< of d, per solid angle; 0 for a lamp, which no ray can hit
    uint32_t group = 0;  ///< light group of the source
  };
  /// Samples an arrival: u1 selects the source, u the position on it. Returns nullopt if no light
  /// arrives.
  std::optional<Arrival> sample_arrival(const SurfaceInteraction& si, float u1,
                                        const Vec2& u) const;
  /// Place and density of an arrival that a ray found.
  struct Found {
    Place place;
    float density = 0;
  };
  /// Returns the place of light that reaches `si` by several edges. cos_light: cosine of the
  /// direction to the light, in the shading frame.
  Place deep_place(const SurfaceInteraction& si, float cos_light) const {
    const uint32_t cell = bounce_cell(si, cos_light >= 0 ? 1.f : -1.f);
    return {cell, deep_ratios_[cell]};
  }
  /// Returns the place of a path's third surface point, for any light on the side of si.wi.
  Place third_place(const SurfaceInteraction& si) const {
    const uint32_t cell = bounce_cell(si, si.wi.z >= 0 ? 1.f : -1.f);
    return {cell, third_ratios_[cell]};
  }
  /// Returns Place::eye_ratio of third_place() in this cell.
  float third_ratio(uint32_t cell) const { return third_ratios_[cell]; }
  /// Returns place and density of light that a ray along d from `si` found at x (nullptr: the sky).
  Found found_arrival(const SurfaceInteraction& si, const Vec3& d, float distance,
                      const SurfaceInteraction* x) const;

 private:
  enum class Kind { kLamp, kSurface, kEnvironment };
  struct Source {
    const Emitter* emitter;
    Kind kind;
    double flux = 0;
    float surface_share = 0;  ///< probability for points on its surface
    float bounce_share = 0;   ///< probability for points that it lights
    uint8_t group = 0;        ///< light group
    float aimed_part = 1;     ///< estimated fraction of its flux that is emitted toward the spheres
    AimDisks disks{};         ///< if its light is parallel for each direction
    AimCones cones{};         ///< if it emits from one position
  };
  struct Drawn;
  struct ChunkRange;
  struct Walker;
  struct Landing;
  void find_sources(const LightGroups& groups, uint64_t seed);
  void make_lamp_cells();
  /// Finds the spheres of aim, and sets the bounce_share of each source by them.
  void aim_sources(std::span<const SurfaceInteraction> seen, uint64_t seed, RenderContext& context);
  /// Returns positions around the seen ones, weighted by the light that one emitter sample finds
  /// there. If it finds hardly any, all light has the same weight.
  std::vector<WeightedPosition> lit_positions(std::span<const SurfaceInteraction> seen,
                                              uint64_t seed, RenderContext& context) const;
  /// Returns the light that one emitter sample finds at each point.
  std::vector<float> light_at(std::span<const EyePoint> points, RenderCounters& counters) const;
  AimCones surface_cones(const SurfaceInteraction& x) const;
  double flux_to_aims(const Source& source, uint64_t seed) const;
  /// Number of draws for the estimate of a source's flux.
  uint32_t draws_of_flux() const;
  /// Selects the sphere at which a ray of a source without surface is aimed; see pick_aim().
  static int pick(const Source& source, Vec2& position, Vec2& direction);
  /// Aims a ray of Emitter::sample_emission, and sets its power by the density of the mixture.
  /// Returns this density relative to that without aim.
  static float aim(const Source& source, int aimed, const Vec2& position, const Vec2& direction,
                   EmissionSample& ray);
  std::vector<LightGuide::Use> find_uses(const std::vector<Drawn>& chunks,
                                         std::span<const SurfaceInteraction> seen, uint64_t seed,
                                         RenderContext& context) const;
  /// Learns the guide. Returns `count` draws that use it, as those of passes will.
  std::vector<Drawn> learn_guide(bool bounce, uint32_t count,
                                 std::span<const SurfaceInteraction> seen, uint64_t seed,
                                 RenderContext& context);
  /// Makes at most `count` cells from draws. A pass will have `repeated` times as many points.
  void make_cells(bool bounce, uint32_t count, const std::vector<Drawn>& drawn, double repeated,
                  const Scheduler& scheduler);
  /// Adds a cell. `repeated` as for make_cells().
  void add_column(const CellSums& sums, double repeated);
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
  /// Learns where walks are split, from draws without splitting. Returns false if no walk is split.
  bool learn_splits(const std::vector<Drawn>& drawn, std::span<const SurfaceInteraction> seen,
                    uint64_t seed, RenderContext& context);
  /// Number of parts into which a walk is split at a light point.
  uint32_t parts_at(const LightPoint& point) const;
  Rgb reflect(Landing& at, Reflection& reflection, Drawn& out) const;
  void land(const LightWalk& walk, const SurfaceInteraction& si, float distance, Drawn& out) const;
  /// Counts the points and bounds of each cell in ranges of chunks.
  std::vector<ChunkRange> count_points(std::vector<Drawn>& chunks,
                                       const Scheduler& scheduler) const;
  /// Sorts points by cell, and along a Morton curve within a cell, so that every nth point is
  /// spread over the cell.
  LocalPoints sort_by_cell(std::vector<Drawn>& chunks, const Scheduler& scheduler) const;
  uint32_t surface_cell(const SurfaceInteraction& si) const {
    return lamp_cells_ + surface_partition_.cell_of({si.p, si.frame.n});
  }
  /// `side`: 1 for the side of the shading normal, -1 for the other.
  uint32_t bounce_cell(const SurfaceInteraction& si, float side) const {
    return lamp_cells_ + surface_cells_ + bounce_partition_.cell_of({si.p, si.frame.n * side});
  }
  SourceChoice::At asked_at(const SurfaceInteraction& y, float side) const {
    return arrivals_.at(y.p, y.frame.n * side);
  }
  /// Returns the density at which an eye path samples light along d (from the light) at y, relative
  /// to that of the pass's points at y without a guide. Both are conditional on the point x on the
  /// light, if it has a surface. `probability` is that of the eye path selecting the source.
  float eye_ratio(const Source& source, float probability, const SurfaceInteraction* x,
                  const SurfaceInteraction& y, const Vec3& d, float distance) const;
  Place bounce_place(const Source& source, float probability, const SurfaceInteraction* x,
                     const SurfaceInteraction& y, const Vec3& d, float distance) const;

  const Scene& scene_;
  const transport::SceneTable table_;
  const PathLength length_;
  std::vector<Source> sources_;
  std::vector<double> surface_ends_, bounce_ends_;  ///< running sums of shares, or empty
  SourceChoice arrivals_;                           ///< if light bounces
  std::unordered_map<const Emitter*, uint32_t> source_of_;
  std::vector<const Emitter*> lamps_;
  std::vector<uint8_t> lamp_groups_;
  std::vector<uint32_t> lamp_first_;
  std::vector<AimSphere> aims_;  ///< empty if light isn't aimed
  double aimed_share_ = 1;
  bool is_complete_ = true;
  LightGuide surface_guide_, bounce_guide_;
  PointPartition split_partition_;
  std::vector<float> splits_;  ///< parts of a walk per unit of power, for each cell; or empty
  PointPartition surface_partition_, bounce_partition_;
  uint32_t lamp_cells_ = 0, surface_cells_ = 0, size_ = 0;
  uint32_t surface_count_ = 0, bounce_count_ = 0;
  const bool finds_caustics_;
  bool has_extended_ = false, needs_eye_rays_ = false;
  bool has_lamp_caustics_ = false, has_glossy_caustics_ = false, has_extended_caustics_ = false;
  LocalCellColumns columns_;
  std::vector<Aabb> boxes_;
  /// Factor of eye_ratio for each cell: the mean of 1 / LightOrigin::guided.
  std::vector<float> eye_factors_;
  /// Area of each cell per point of a pass whose light has come by several edges. It is the
  /// eye_ratio of such points, and of light that paths from the eye find there.
  std::vector<float> deep_ratios_;
  std::vector<float> third_ratios_;  ///< the same for points of any light
};

/// Returns about `count` surface points that a sensor sees, spread evenly over its image; fewer if
/// some rays hit nothing. Surfaces that reflect nothing, or only by delta lobes, are left out.
std::vector<SurfaceInteraction> places_seen(const Scene& scene, const Sensor& sensor,
                                            uint32_t count, uint64_t seed, RenderContext& context);

}  // namespace kinome
