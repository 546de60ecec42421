#include "clustered/product/lights/local_light.h"

#include <algorithm>
#include <cmath>

#include "clustered/product/lights/light_point_draw.h"
#include "clustered/product/tiles/spread.h"
#include "kinome/render_context.h"

namespace kinome {
namespace {

constexpr uint32_t kMaxSurfacePoints = 1u << 17;
constexpr uint32_t kPointsOfSurface = 4, kCellsOfSurface = 2;
constexpr uint32_t kSurfaceCells = 256, kMaxSurfaceCells = 4096;
constexpr uint32_t kMaxLampCells = 2048;
/// Factor of the density ratio of eye paths to deep light points. It bounds the weight of a very
/// near point. It is below 1 because eye paths sample light after several bounces less well than
/// light points do. Errors at 32 samples, relative to those with 0.4: with 0.1 and 1, 1.44 and 0.79
/// in the diffuse material preview, 1.35 and 1.1 in a Cornell box, 1.08 and 1 for a bunny in a box;
/// with 3, 2 in the Cornell box.
constexpr double kEyeShare = 0.4;
/// Ratio for cells without samples. Eye rays and paths then find nearly all of their light, so that
/// light points that a pass draws by chance don't become fireflies.
constexpr float kUnknownRatio = 1e10f;
/// Minimum assumed area of a cell, relative to the mean area.
constexpr double kMinArea = 0.1;
/// Number of draws for the estimate of a source's flux; kFluxDrawsOfMany if there are more than
/// kManySources sources.
constexpr uint32_t kFluxDraws = 64, kFluxDrawsOfMany = 8, kManySources = 256;
/// Amount added to the flux of each source, relative to the mean flux.
constexpr double kMinFlux = 1e-3;
/// Maximum flux of all sources. Above it, powers of points (flux / density) could overflow single
/// precision.
constexpr double kMaxFlux = 1e34;
enum LightSeed : uint64_t { kSeedOfCells = 0x63656c6c, kSeedOfFlux = 0x666c7578 };

float importance_of(const Rgb& c) {
  return mean_of(glm::abs(c));
}

/// Estimates the flux of an emitter from a few draws. Not finite if the estimate overflows.
double flux_of(const Emitter& emitter, uint32_t draws, const LightNumbers& numbers) {
  double flux = 0;
  for (uint32_t i = 0; i < draws; ++i) {
    const auto leaving = leave_light(emitter, numbers.position(i), numbers.direction(i));
    if (leaving) flux += importance_of(leaving->sample.power) / draws;
  }
  return flux;
}

/// Returns the product of the two longest sides of a box, as an estimate of the area of the surface
/// in it.
double area_of(const Aabb& box) {
  const Vec3 extent = box.extent();
  const auto longest = static_cast<double>(max_component(extent));
  const double sum = static_cast<double>(extent.x) + extent.y + extent.z;
  const double shortest = std::min({extent.x, extent.y, extent.z});
  return longest * (sum - longest - shortest);
}

}  // namespace

/// Sums over the points of a cell, from which add_column() computes the columns.
struct CellSums {
  double weight = 0, flux = 0;
  double unguided = 0;  ///< of 1 / LightOrigin::guided
  double useless = 0;   ///< of 1 / (LightOrigin::guided x LightOrigin::aimed)
  glm::dvec3 position{0.}, squares{0.}, normal{0.};
  uint32_t count = 0;
  uint32_t deep = 0;  ///< number of points whose light has come by several edges
  Aabb box;
  void add(const OrientedPoint& point, double power, float guided = 1, float use = 1,
           bool is_deep = false) {
    // If all points are black, they still determine the position of the cell.
    const double w = power + 1e-200;
    const glm::dvec3 at(point.position);
    weight += w;
    flux += power;
    unguided += 1 / guided;
    useless += 1 / use;
    position += w * at;
    squares += w * at * at;
    normal += w * glm::dvec3(point.normal);
    box.expand(point.position);
    ++count;
    deep += is_deep ? 1 : 0;
  }
};

bool LocalLight::serves(const Scene& scene, uint32_t max_depth) {
  const uint32_t draws = scene.emitters().size() > kManySources ? 1 : kFluxDrawsOfMany;
  double flux = 0;
  for (const Emitter* const emitter : scene.emitters()) {
    // Without bounces, only emitting surfaces have light points.
    if (max_depth < kBounceDepth && !emitter->is_surface()) continue;
    if (!emitter->is_surface() && !emitter->emission_density(Vec3(0, 0, 1))) return false;
    flux += flux_of(*emitter, draws, LightNumbers(kSeedOfFlux));
  }
  return flux < kMaxFlux;
}

bool LocalLight::has_mirrors(const Scene& scene) {
  return std::ranges::any_of(
      scene.shapes(), [](const auto& shape) { return any(shape->bsdf().lobes() & Lobe::kDelta); });
}

bool LocalLight::may_have_lamp_caustics(const Scene& scene) {
  const bool has_lamps = std::ranges::any_of(scene.emitters(), [](const Emitter* emitter) {
    return !emitter->is_surface() && !emitter->is_environment();
  });
  return has_lamps && has_mirrors(scene);
}

LocalLight::LocalLight(const Scene& scene, const Settings& settings,
                       std::span<const SurfaceInteraction> seen, uint64_t seed,
                       RenderContext& context)
    : scene_(scene), table_(scene), length_(settings.length), finds_caustics_(settings.caustics) {
  find_sources(settings.groups, seed);
  if (!bounce_ends_.empty()) aim_sources(seen, seed, context);
  const bool has_lamps = std::any_of(sources_.begin(), sources_.end(),
                                     [](const Source& s) { return s.kind == Kind::kLamp; });
  is_complete_ = has_lamps || !(aimed_share_ < settings.min_aimed_share);
  if (!is_complete_) return;
  make_lamp_cells();
  const uint64_t own = hash_words(seed, kSeedOfCells);
  if (!surface_ends_.empty()) {
    const auto surfaces =
        static_cast<uint32_t>(std::count_if(sources_.begin(), sources_.end(), [](const Source& s) {
          return s.kind == Kind::kSurface;
        }));
    // If light bounces, the noise of direct light is small compared to that of reflected light.
    const uint32_t least = bounce_ends_.empty() ? settings.points : settings.points / 4;
    surface_count_ = std::clamp(surfaces * kPointsOfSurface, least, kMaxSurfacePoints);
    make_cells(false, std::clamp(surfaces * kCellsOfSurface, kSurfaceCells, kMaxSurfaceCells),
               learn_guide(false, surface_count_, seen, own, context), 1, context.scheduler);
    surface_cells_ = size_ - lamp_cells_;
  }
  if (!bounce_ends_.empty()) {
    double extended = 0;
    for (const Source& source : sources_) {
      extended += source.kind == Kind::kLamp ? 0. : static_cast<double>(source.bounce_share);
    }
    bounce_count_ = static_cast<uint32_t>(
        std::lerp(settings.points, std::max(settings.points, settings.extended_points),
                  std::min(extended, 1.)));
    std::vector<Drawn> drawn =
        learn_guide(true, settings.points, seen, hash_words(own, 1), context);
    if (learn_splits(drawn, seen, hash_words(own, 2), context)) {
      drawn.clear();
      draw_part(true, settings.points, hash_words(own, 3), context, drawn);
    }
    make_cells(true, settings.bounce_cells, drawn,
               static_cast<double>(bounce_count_) / settings.points, context.scheduler);
    const bool mirrors = has_mirrors(scene);
    needs_eye_rays_ = needs_eye_rays_ || (mirrors && has_extended_);
    has_lamp_caustics_ = has_glossy_caustics_ || (mirrors && finds_caustics_ && !lamps_.empty());
    has_extended_caustics_ = mirrors && finds_caustics_ && has_extended_;
  }
  const uint32_t padded = (size_ + kPadding - 1) / kPadding * kPadding;
  for (auto* const column :
       {&columns_.spread2, &columns_.flux, &columns_.guided_flux, &columns_.expected}) {
    column->resize(padded);
  }
  for (int axis = 0; axis < 3; ++axis) {
    columns_.position[axis].resize(padded);
    columns_.normal[axis].resize(padded);
  }
}

uint32_t LocalLight::draws_of_flux() const {
  return scene_.emitters().size() > kManySources ? kFluxDrawsOfMany : kFluxDraws;
}

void LocalLight::find_sources(const LightGroups& groups, uint64_t seed) {
  double total = 0;
  const uint32_t draws = draws_of_flux();
  for (const Emitter* const emitter : scene_.emitters()) {
    Source source{emitter, Kind::kLamp};
    if (emitter->is_surface()) source.kind = Kind::kSurface;
    if (emitter->is_environment()) source.kind = Kind::kEnvironment;
    if (!groups.is_empty()) source.group = static_cast<uint8_t>(groups.group_of(*emitter));
    // The flux of a sky may overflow, and is needed only if light bounces.
    if (max_depth() >= kBounceDepth || !emitter->is_environment()) {
      source.flux =
          flux_of(*emitter, draws, LightNumbers(hash_words(seed, kSeedOfFlux, sources_.size())));
    }
    has_extended_ = has_extended_ || source.kind != Kind::kLamp;
    source_of_[emitter] = static_cast<uint32_t>(sources_.size());
    sources_.push_back(source);
    total += source.flux;
  }
  const double least =
      sources_.empty() ? 0 : kMinFlux * total / static_cast<double>(sources_.size());
  double surfaces = 0, all = 0;
  for (Source& source : sources_) {
    source.flux = total > 0 ? source.flux + least : 1;
    all += source.flux;
    if (source.kind == Kind::kSurface) surfaces += source.flux;
  }
  double surface_end = 0, bounce_end = 0;
  for (Source& source : sources_) {
    if (surfaces > 0) {
      if (source.kind == Kind::kSurface)
        source.surface_share = static_cast<float>(source.flux / surfaces);
      surface_ends_.push_back(surface_end += static_cast<double>(source.surface_share));
    }
    if (max_depth() >= kBounceDepth) {
      source.bounce_share = static_cast<float>(source.flux / all);
      bounce_ends_.push_back(bounce_end += static_cast<double>(source.bounce_share));
    }
  }
  if (bounce_ends_.empty()) return;
  std::vector<const Emitter*> emitters;
  std::vector<double> fluxes;
  for (const Source& source : sources_) {
    emitters.push_back(source.emitter);
    fluxes.push_back(source.flux);
  }
  arrivals_ = SourceChoice(emitters, fluxes, glm::length(scene_.bounds().extent()) / 2);
}

/// Makes one cell for each lamp, or kMaxLampCells cells if there are more lamps.
void LocalLight::make_lamp_cells() {
  std::vector<uint32_t> lamps;
  std::vector<OrientedPoint> places;
  std::vector<float> flux;
  for (uint32_t s = 0; s < sources_.size(); ++s) {
    if (sources_[s].kind != Kind::kLamp) continue;
    lamps.push_back(s);
    const auto sample = sources_[s].emitter->sample_emission(Vec2(0.5f), Vec2(0.5f));
    // The position of parallel light is irrelevant.
    const bool stands = sample && sample->pdf_position == 0;
    places.push_back({stands ? sample->o : scene_.bounds().centre(), Vec3(0.f)});
    flux.push_back(static_cast<float>(sources_[s].flux));
  }
  if (lamps.empty()) return;
  const bool each = lamps.size() <= kMaxLampCells;
  const PointPartition partition(places, flux, each ? 1 : kMaxLampCells);
  lamp_cells_ = each ? static_cast<uint32_t>(lamps.size()) : partition.size();
  std::vector<std::vector<uint32_t>> of(lamp_cells_);
  for (uint32_t k = 0; k < lamps.size(); ++k)
    of[each ? k : partition.cell_of(places[k])].push_back(k);
  for (const auto& cell : of) {
    lamp_first_.push_back(static_cast<uint32_t>(lamps_.size()));
    CellSums sums;
    for (const uint32_t k : cell) {
      lamps_.push_back(sources_[lamps[k]].emitter);
      lamp_groups_.push_back(sources_[lamps[k]].group);
      sums.add(places[k], flux[k]);
    }
    add_column(sums, 1);
  }
  lamp_first_.push_back(static_cast<uint32_t>(lamps_.size()));
}

void LocalLight::add_column(const CellSums& sums, double repeated) {
  const double flux = sums.flux * repeated, expected = sums.count * repeated;
  const double scale = sums.weight > 0 ? 1 / sums.weight : 0;
  const glm::dvec3 mean = sums.position * scale;
  const glm::dvec3 variance = glm::max(sums.squares * scale - mean * mean, 0.);
  for (int axis = 0; axis < 3; ++axis) {
    columns_.position[axis].push_back(static_cast<float>(mean[axis]));
    columns_.normal[axis].push_back(static_cast<float>(sums.normal[axis] * scale));
  }
  columns_.spread2.push_back(static_cast<float>(variance.x + variance.y + variance.z));
  const double factor = expected > 0 ? sums.unguided * repeated / expected : 1.;
  columns_.flux.push_back(static_cast<float>(flux));
  columns_.guided_flux.push_back(
      static_cast<float>(expected > 0 ? flux * expected / (sums.useless * repeated) : flux));
  columns_.expected.push_back(static_cast<float>(expected));
  eye_factors_.push_back(static_cast<float>(factor));
  // The margin is about the distance between points.
  const Vec3 margin =
      sums.count > 1 ? sums.box.extent() / static_cast<float>(sums.count - 1) : Vec3(0.f);
  boxes_.push_back({sums.box.lo - margin, sums.box.hi + margin});
  ++size_;
}

/// The draws have the density of a pass's points, but don't contribute to any pass.
void LocalLight::make_cells(bool bounce, uint32_t count, const std::vector<Drawn>& drawn,
                            double repeated, const Scheduler& scheduler) {
  std::vector<OrientedPoint> places;
  std::vector<float> guided_flux;
  const auto use_of = [](const LightOrigin& origin) { return origin.guided * origin.aimed; };
  for (const Drawn& chunk : drawn) {
    for (size_t i = 0; i < chunk.points.size(); ++i) {
      const LightPoint& p = chunk.points[i];
      places.push_back({p.position, p.normal});
      guided_flux.push_back(importance_of(p.power) * use_of(chunk.origins[i]));
    }
  }
  const bool is_unknown = places.empty();
  if (is_unknown) {  // passes may still find light that these draws missed
    places.push_back({scene_.bounds().centre(), Vec3(0.f)});
    guided_flux.push_back(0);
  }
  PointPartition& partition = bounce ? bounce_partition_ : surface_partition_;
  std::vector<uint32_t> cells;
  partition = PointPartition(places, guided_flux, count, &scheduler, &cells);
  std::vector<CellSums> sums(partition.size());
  if (is_unknown) sums[0].add(places[0], 0);
  size_t next = 0;
  for (const Drawn& chunk : drawn) {
    for (size_t i = 0; i < chunk.points.size(); ++i) {
      const LightPoint& p = chunk.points[i];
      sums[cells[next]].add(places[next], importance_of(p.power), chunk.origins[i].guided,
                            use_of(chunk.origins[i]), chunk.is_deep[i] != 0);
      ++next;
    }
  }
  std::vector<double> areas;
  double all_areas = 0;
  for (uint32_t c = 0; c < partition.size(); ++c) {
    add_column(sums[c], repeated);
    areas.push_back(area_of(boxes_.back()));
    all_areas += areas.back();
  }
  // A cell with few points may be larger than their bounds.
  const double least = kMinArea * all_areas / partition.size();
  for (auto* const ratios : {&deep_ratios_, &third_ratios_}) {
    ratios->resize(size_ - partition.size());
  }
  for (uint32_t c = 0; c < partition.size(); ++c) {
    if (is_unknown) {
      deep_ratios_.push_back(kUnknownRatio);
      third_ratios_.push_back(kUnknownRatio);
      continue;
    }
    const double area = std::max(areas[c], least) / repeated;
    deep_ratios_.push_back(static_cast<float>(kEyeShare * area / std::max(sums[c].deep, 1u)));
    third_ratios_.push_back(static_cast<float>(kEyeShare * area / std::max(sums[c].count, 1u)));
  }
}

}  // namespace kinome
