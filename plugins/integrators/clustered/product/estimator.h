#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "clustered/cells/light_cells.h"
#include "clustered/kernels/candidate_kernels.h"
#include "clustered/product/comb.h"
#include "clustered/product/local_choice.h"
#include "clustered/product/spread.h"
#include "clustered/product/stage_scope.h"
#include "clustered/product/tile.h"

namespace kinome {

/// Light of one pass: its cells and the points drawn of them. Cells of distant light are numbered
/// first, those of local light from first_local() on.
struct CellLight {
  /// About so many points fit a core's own cache, and fewer or more do no better.
  static constexpr uint32_t kPoints = 1u << 15;
  const DistantCells& cells;
  const Emitter* environment;  ///< nullptr: there is none
  CellPoints points;
  const LocalLight* local;  ///< nullptr: there is none
  LocalPoints local_points;
  simd::CellColumns columns;
  CellLight(const DistantCells& cells, const Emitter* environment, CellPoints points,
            const LocalLight* local = nullptr, LocalPoints local_points = {});
  uint32_t first_local() const { return cells.padded_size(); }
};

/// Estimates the light that surface points reflect from cells of distant and local light, by
///
///     sum over cells of v_c A_c + (1 / n) sum over rays of (f V - v_c A_c q_c) / (P_c q_c)
///
/// A_c is the unshadowed reflected light of cell c, v_c a visibility that was learned earlier, q_c
/// the density within the cell. Of diffuse light A_c is known without rays; of glossy light it is
/// estimated by many unshadowed candidates, and so is that of local light, whose candidates are a
/// choice of the pass's points. What rays of the BSDF would find as well shares its light with
/// them, and is found by a few of these (eye rays). Shadow rays correct the control terms, and go
/// where the visibility is uncertain: P_c ~ A_c sigma_c, by one comb for all points of a unit.
///
/// Unbiased whatever v, sigma and the patches are, as long as they were fixed before the rays were
/// drawn. One per thread; not thread-safe.
class Estimator {
 public:
  explicit Estimator(const CellLight& light);

  /// What shares one comb: the points of a pixel, or of a tile.
  struct Unit {
    uint32_t first = 0;  ///< its primaries, [first, end)
    uint32_t end = 0;
    uint32_t rays = 0;
    float candidates = 0;  ///< unshadowed glossy directions of all groups together
    uint64_t seed = 0;
  };

  /// The tile whose units follow; `visibility` of each patch must outlive them. A patch's
  /// visibility is asked for when the first unit needs it.
  void begin_tile(const Scene& scene, const TilePrimaries& primaries, std::vector<Patch>& patches,
                  std::span<const Visibility> visibility, uint64_t seed, RenderCounters& counters);

  /// Adds the reflected light of the unit's points, summed, to `sum`: control terms at once, what
  /// rays find when they are traced. `sum` must stay where it is until flush().
  void estimate(const Unit& unit, Rgb& sum);

  /// The same without an estimate: rays find out visibilities, and what they find is kept for each
  /// patch, with what the plan needs to know of patches and points. Its time is counted to no stage
  /// until the next begin_tile(): all stages here are parts of the main pass.
  struct PointPlan {
    /// Unshadowed radiance of glossy lobes, and of all lobes from local light that has an extent,
    /// of the group that it is in.
    float glossy = 0;
    float lamps = 0;  ///< of its own, unshadowed, from those lamps that no ray asked for
    /// Gets what it sees of the other lamps, by flush() at the latest; nullptr: nobody asks.
    float* lit = nullptr;
    double glossy_variance = 0;  ///< of one candidate; in float, bright light's would overflow
    float mirrored = 0;          ///< unshadowed, by delta lobes
  };
  void probe(const Unit& unit, std::span<PointPlan> points,
             std::span<std::vector<VisibilityRecord>> records);
  /// Traces the rays that wait.
  void flush();

  /// What is expected of a patch's points, from learned visibilities.
  struct PatchPlan {
    float uncertainty = 0;  ///< sum of the diffuse strata of one point: the scale of its noise
    float control[9] = {};  ///< of the light that they see [channel x 3 + axis]
  };
  PatchPlan plan_patch(const Patch& patch, const Visibility& visibility);

  /// Rays that each primary of the patch sends by its BSDF toward local light, on average.
  static float expected_eye_rays(const Patch& patch, const LocalLight& light);

 private:
  /// Points of a unit that share strata: of one patch.
  struct Group {
    int32_t patch = 0;
    uint32_t first = 0;  ///< in order_
    uint32_t count = 0;
    Vec3 normal{0.f};
    Vec3 viewer{0.f};
    float cosine = 1;       ///< of the cone of its normals
    Vec3 albedo_normal[3];  ///< sum of diffuse reflectance x normal, of each channel
    float albedo = 0;       ///< sum of the mean reflectance
  };
  enum class Strata { kDiffuse, kGlossy, kLocal };
  struct Segment {
    Strata strata = Strata::kDiffuse;
    uint32_t group = 0;
    size_t begin = 0;  ///< in weights_
    size_t size = 0;
    size_t other = 0;  ///< its candidates, or mixed visibilities
  };
  /// Unshadowed directions of a unit, of glossy lobes or toward local light, group by group (padded
  /// by candidates of weight 0), as structure of arrays.
  struct Candidates {
    std::vector<uint32_t> member, cell;  ///< member: of the group
    std::vector<float> dx, dy, dz;
    std::vector<Rgb> radiance;
    std::vector<float> cell_density;  ///< of the draw from cells, per solid angle
    std::vector<float> lobe_density;  ///< local light: of an eye ray
    std::vector<uint32_t> point;      ///< local light: of LocalPoints
    std::vector<float> distance;      ///< the same
    std::vector<float> eye_ratio;     ///< the same: ConnectionColumns::eye_ratio
    std::vector<float> f[3];          ///< BSDF x cosine
    std::vector<float> weight[3];  ///< f L / density: they sum to an estimate of unshadowed light
    size_t size() const { return size_; }
    /// Memory only grows: what is new is not initialised.
    void resize(size_t size);
    Vec3 direction(size_t i) const { return {dx[i], dy[i], dz[i]}; }
    Rgb weight_of(size_t i) const { return {weight[0][i], weight[1][i], weight[2][i]}; }
    simd::WeightColumns weight_columns(size_t i, float* uncertainty) {
      return {{&f[0][i], &f[1][i], &f[2][i]},
              &radiance[i].x,
              &cell[i],
              {&weight[0][i], &weight[1][i], &weight[2][i]},
              uncertainty};
    }

   private:
    size_t size_ = 0;
  };
  /// Directions at members of a group, and where f cos of their BSDFs is to go.
  struct AskedDirections {
    const uint32_t* member;
    const float *dx, *dy, *dz;
    float* f[3];
    size_t count;
  };
  /// Rays of diffuse light whose BSDFs have to be asked.
  struct Shots {
    std::vector<uint32_t> member, cell;
    std::vector<float> dx, dy, dz, f[3];
    std::vector<Rgb> weight;  ///< of f
    void clear();
    void push_back(uint32_t to_member, uint32_t to_cell, const Vec3& d, const Rgb& weight_of_f);
    AskedDirections asked();
  };
  /// What a ray's result goes to: a sum, or the records of a patch.
  struct Pending {
    Rgb weight;
    uint32_t cell;
    union {
      Rgb* sum;
      std::vector<VisibilityRecord>* records;
    };
  };
  /// A ray that a primary's BSDF sends, to find light by itself.
  struct EyeRay {
    Rgb weight;     ///< of the radiance that it finds
    float density;  ///< expected number of such rays, per solid angle; 0: of a delta lobe
    size_t rates;   ///< in eye_rates_, of its tile
    uint64_t seed;
    Rgb* sum;
  };
  /// A patch prepared for its units.
  struct Prepared {
    bool ready = false;
    simd::PatchCells cells;
    std::vector<float> transmittance;  ///< of each cell; empty: 1
  };

  /// Time by stage, of RenderCounters.
  struct Stages {
    double *strata, *candidates, *comb, *shadow, *eye;
  };
  const Prepared& prepare(int32_t patch);
  void prepare_patch(const Patch& patch, const Visibility& visibility, Prepared& prepared) const;
  void find_transmittance(const Patch& patch, std::vector<float>& transmittance) const;
  simd::GroupNormal group_normal(const Vec3& n, float cosine) const;
  void make_groups(const Unit& unit);
  void add_to_group(uint32_t primary);
  void begin_unit(const Unit& unit);
  void add_diffuse(uint32_t group, Rgb& control);
  void add_glossy(uint32_t group, const Unit& unit, Rgb& control);
  Rgb add_glossy_segment(uint32_t group, size_t first, uint32_t lobe, uint32_t from_cells);
  void probe_glossy(uint32_t group, const Unit& unit, std::span<PointPlan> points);
  size_t draw_candidates(const Group& group, uint32_t lobe_log2, uint32_t from_cells,
                         uint64_t seed);
  void draw_from_lobe(const Group& group, size_t first, uint32_t lobe_log2, uint64_t seed);
  void draw_from_cells(const Group& group, size_t first, uint32_t count, uint64_t seed);
  void evaluate_candidates(const Group& group, size_t first);
  void ask(const Group& group, Lobe mask, const AskedDirections& asked);
  void ask_for_candidates(const Group& group, Lobe mask, size_t first);
  struct Mirrored {
    Vec3 d;
    Rgb radiance;
  };
  std::optional<Mirrored> mirror(uint32_t primary, uint64_t seed) const;
  bool has_local() const { return light_.local != nullptr; }
  void add_local(uint32_t group, const Unit& unit, Rgb& control, std::span<PointPlan> points);
  size_t connect_points(const Group& group, const Unit& unit);
  float geometry_of(const LightPoint& point, size_t candidate) const;
  void add_reflections(size_t first);
  void connect_lamps(const Group& group, const Unit& unit);
  static float diffuse_share(const Patch& patch);
  float eye_rays_of(const Patch& patch) const;
  void evaluate_all_lobes(const Group& group, size_t first);
  void add_diffuse_values(const Group& group, size_t first);
  void plan_local(const Group& group, size_t first, size_t end_points, std::span<PointPlan> points);
  void shoot_local(const Segment& segment, float scale, Rgb* sum);
  void send_eye_rays(const Group& group, uint64_t seed, Rgb* sum);
  void send_mirrored(uint32_t primary, uint64_t seed, Rgb* sum);
  void push_eye_ray(const Ray& ray, const EyeRay& eye);
  void trace_eye_rays();
  void find_light(const RayHit& ray, const EyeRay& eye);
  struct Met {
    RayHit ray;
    std::optional<SurfaceInteraction> x;
    Rgb radiance{0.f};
  };
  void find_arrival(const RayHit& ray, const SurfaceInteraction& y, LobeWidth width,
                    const EyeRay& eye);
  std::optional<Met> meet(const SurfaceInteraction& y, const Vec3& wo);
  void follow(const RayHit& ray, const SurfaceInteraction& y, LobeWidth width, const EyeRay& eye);
  void look_behind(const SurfaceInteraction& y, const EyeRay& eye);
  float eye_odds(const EyeRay& eye, const SurfaceInteraction& y, const RayHit& ray,
                 const LocalLight::Place& place) const;
  void push_shadow_ray(const Ray& ray, const Rgb& weight, uint32_t cell, int32_t patch, Rgb* sum);
  void note_pending(const Rgb& weight, uint32_t cell, int32_t patch, Rgb* sum);
  void note_lamp(size_t candidate, uint32_t primary);
  void trace_shadow_rays();
  double cap_candidates(size_t rays);
  template <class Function>
  void for_heavy_blocks(double weight, const Function& fn) const;
  std::pair<size_t, double> heavier_candidates(double weight) const;
  void comb_unit(const Unit& unit, Rgb* sum);
  void shoot_diffuse(const Segment& segment, float scale, uint32_t offset, size_t first_hit,
                     Rgb* sum);
  void shoot_glossy(const Segment& segment, float scale, Rgb* sum);
  void push_ray(uint32_t primary, const Vec3& d, const Rgb& weight, uint32_t cell, Rgb* sum);
  float turned_factor(uint32_t primary, const Vec3& d) const;
  /// The group's member at a share of all, in units of 2^-32.
  static uint32_t pick(const Group& group, uint32_t share) { return scaled(share, group.count); }
  /// A member's primary.
  uint32_t member_of(const Group& group, uint32_t member) const {
    return order_[group.first + member];
  }
  simd::PointGroup points_of(const Group& group) const {
    return {primaries_->frames, &order_[group.first], group.count};
  }
  void plan_glossy(const Group& group, size_t first, uint32_t lobe, uint32_t from_cells,
                   std::span<PointPlan> points);

  const CellLight& light_;
  const Scene* scene_ = nullptr;
  const TilePrimaries* primaries_ = nullptr;
  std::vector<Patch>* patches_ = nullptr;
  std::span<const Visibility> visibility_;
  RenderCounters* counters_ = nullptr;
  Stages stages_{};
  double untold_seconds_ = 0;  ///< the parts of a pilot, which is one stage
  StageScope* innermost_stage_ = nullptr;
  /// What all rays that wait are for: records or an estimate.
  bool is_probing_ = false;
  std::vector<VisibilityRecord>* records_ = nullptr;  ///< of each patch
  std::span<PointPlan> probed_;

  std::vector<Prepared> prepared_;
  Prepared planned_;
  std::vector<Group> groups_;
  std::vector<int32_t> group_of_;     ///< of each primary of the unit, from unit.first on
  std::vector<uint32_t> order_;       ///< primaries, group by group
  std::vector<int32_t> first_group_;  ///< of each patch
  std::vector<Segment> segments_;
  std::vector<float> weights_;
  std::vector<float> block_sums_;
  std::vector<float> mixed_visibility_;
  Candidates candidates_;
  std::vector<Comb::Hit> hits_;
  Shots shots_;
  std::vector<uint32_t> evaluation_order_, evaluation_first_;
  std::vector<float> x_, y_, z_, r_, g_, b_;
  std::vector<float> importance_, importance_blocks_;
  float importance_total_ = 0;
  std::vector<Ray> rays_;  ///< those that wait are the first waiting_
  std::vector<Pending> pending_;
  /// Of rays that wait for records: what they add where they see light; nothing, of most.
  struct Lit {
    float* sum = nullptr;
    float radiance = 0;
  };
  std::vector<Lit> lit_;
  size_t waiting_ = 0;
  LocalChoice choice_;
  std::vector<uint32_t> chosen_, numbers_[2];
  std::vector<RayHit> eye_hits_;
  std::vector<EyeRay> eye_rays_;
  std::vector<float> eye_rates_;  ///< LocalChoice::rates of the tiles that eye rays wait for
  size_t tile_rates_ = 0;         ///< where those of this tile are
};

}  // namespace kinome
