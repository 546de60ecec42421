// Reports what product sampling has learned at one pixel (kinome --inspect).
#include <algorithm>
#include <cmath>

#include "clustered/product/method/product_method.h"
#include "clustered/product/pass/product_renderer.h"
#include "kinome/error.h"

namespace kinome {
namespace {

constexpr uint16_t kPilotPrimaries = 4;
/// Number of rays that the pilot sends from 5x5 tiles, from which a patch learns.
constexpr uint32_t kInspectionRays = 25 * kTileSide * kTileSide * 3 * kPilotPrimaries;
/// Weight of each ray, in sixteenths. It is limited because all rays may belong to one patch.
constexpr uint32_t kRecordWeight = std::min(16u, VisibilityLearner::kMaxWeight / kInspectionRays);
constexpr uint16_t kPrimaries = 16;
/// Number of teeth of the comb that measures each cell's share of the rays.
constexpr uint32_t kShares = 1u << 16;

/// Records of a unit's rays, patch by patch.
using Records = std::vector<std::vector<VisibilityRecord>>;

void describe(const std::shared_ptr<const DistantCells>& shared_cells, const Visibility& visibility,
              Inspection& report) {
  const DistantCells& cells = *shared_cells;
  double light = 0;
  report.clusters.resize(cells.size());
  for (uint32_t c = 0; c < cells.size(); ++c) light += cells.flux()[c];
  for (uint32_t c = 0; c < cells.size(); ++c) {
    InspectedCluster& out = report.clusters[c];
    out.mean = {cells.axis()[0][c], cells.axis()[1][c], cells.axis()[2][c]};
    const Vec3 reach(2 * std::sin(0.5f * cells.radius()[c]));
    out.box = {out.mean - reach, out.mean + reach};
    out.light = cells.flux()[c] / light;
    const bool is_below = glm::dot(out.mean, report.normal) < -std::sin(cells.radius()[c]);
    out.visibility = is_below ? 0 : visibility.v[c];
    out.sigma = is_below ? 0 : visibility.sigma[c];
  }
  report.is_learned = true;
  report.cluster_at = [shared_cells](const Vec3& d) {
    float x[DistantCells::kPadding] = {d.x}, y[DistantCells::kPadding] = {d.y},
          z[DistantCells::kPadding] = {d.z}, density[DistantCells::kPadding];
    uint32_t cell[DistantCells::kPadding];
    Rgb radiance[DistantCells::kPadding];
    shared_cells->look_up({x, y, z, cell, density, radiance}, 1);
    return cell[0];
  };
}

void describe(const LocalLight& local, uint32_t first_cell, const Visibility& visibility,
              Inspection& report) {
  report.is_learned = true;
  const LocalCellColumns& cells = local.columns();
  double light = 0;
  report.clusters.resize(local.size());
  for (uint32_t c = 0; c < local.size(); ++c) light += cells.flux[c];
  for (uint32_t c = 0; c < local.size(); ++c) {
    InspectedCluster& out = report.clusters[c];
    out.box = local.boxes()[c];
    for (int axis = 0; axis < 3; ++axis) {
      out.mean[axis] = cells.position[axis][c];
      out.normal[axis] = cells.normal[axis][c];
    }
    out.points = static_cast<uint32_t>(cells.expected[c]);
    out.light = light > 0 ? cells.flux[c] / light : 0;
    out.visibility = visibility.v[first_cell + c];
    out.sigma = visibility.sigma[first_cell + c];
  }
}

/// Camera rays through a tile or a pixel, the patches that they see, and shadow rays from them.
class PixelProbe {
 public:
  PixelProbe(const ProductTask& task, const CellLight& light, size_t padded_cells)
      : task_(task),
        padded_(padded_cells),
        estimator_(light),
        table_(task.scene),
        all_({table_, task.sensor, task.path_settings()}) {}

  /// Traces `count` camera rays through each pixel.
  void trace(const Rect& pixels, uint16_t count, uint64_t key) {
    const std::vector<uint16_t> counts(pixels.area(), count);
    all_.clear();
    all_.add(pixels, counts);
    all_.trace(hash_words(task_.seed, key), counters_);
  }
  /// Sends shadow rays from the primaries and returns their records.
  Records shadow_rays(uint32_t rays, uint64_t key) {
    TilePrimaries primaries = all_.tile(0);
    Records records(patches.size());
    std::vector<PointPlan> points(primaries.size());
    Unit unit;
    unit.end = static_cast<uint32_t>(primaries.size());
    unit.rays = rays;
    unit.seed = hash_words(task_.seed, key);
    estimator_.begin_tile(task_.scene, primaries, patches, visibility, unit.seed, counters_);
    estimator_.probe(unit, points, records);
    estimator_.flush();
    return records;
  }
  /// Learns the visibility of the patches that the tile of pixel (x, y) sees, as the pilot does.
  void learn(const DistantCells& cells, int x, int y);
  /// Traces rays through pixel (x, y), and returns the patch with the most points. Throws Error if
  /// there is no surface.
  size_t find_patch(int x, int y);

  std::vector<Patch> patches;
  std::vector<Visibility> visibility;  ///< of each patch

 private:
  const ProductTask& task_;
  const size_t padded_;
  Estimator estimator_;
  const transport::SceneTable table_;
  Primaries all_;
  RenderCounters counters_;
};

void PixelProbe::learn(const DistantCells& cells, int x, int y) {
  const Rect crop = task_.sensor.film().crop();
  const int x0 = x - (x - crop.x0) % kTileSide, y0 = y - (y - crop.y0) % kTileSide;
  trace({x0, y0, std::min(x0 + kTileSide, crop.x1), std::min(y0 + kTileSide, crop.y1)},
        kPilotPrimaries, 1);
  TilePrimaries primaries = all_.tile(0);
  make_patches(primaries, patches);
  visibility.assign(patches.size(), Visibility(padded_));
  const Records pilot = shadow_rays(kInspectionRays, 2);
  CellNeighbours neighbours;
  if (cells.size() > 0) neighbours = find_neighbours(cells, task_.context.scheduler);
  VisibilityLearner learner(padded_, &neighbours);
  for (size_t p = 0; p < pilot.size(); ++p) {
    learner.begin();
    learner.add(pilot[p], kRecordWeight);
    learner.finish(visibility[p]);
  }
}

size_t PixelProbe::find_patch(int x, int y) {
  trace({x, y, x + 1, y + 1}, kPrimaries, 3);
  TilePrimaries primaries = all_.tile(0);
  assign_patches(primaries, patches);
  visibility.resize(patches.size(), Visibility(padded_));
  std::vector<uint32_t> points(patches.size() + 1);
  for (size_t i = 0; i < primaries.size(); ++i) ++points[primaries.patch(i) + 1];
  const size_t shown = std::max_element(points.begin() + 1, points.end()) - points.begin() - 1;
  if (shown >= patches.size() || points[shown + 1] == 0) {
    throw Error("there is no surface at the pixel to inspect");
  }
  return shown;
}

}  // namespace

std::vector<Inspection> ProductMethod::inspect(const Scene& scene, const Sensor& sensor,
                                               RenderContext& context, int x, int y) const {
  const std::shared_ptr<const DistantCells> shared_cells = cells_();
  const DistantCells& cells = *shared_cells;
  const ProductTask task(scene, sensor, context, sampling_);
  const auto local = make_local_light(task);
  CellPoints distant_points;
  if (cells.size() > 0) {
    distant_points =
        cells.draw_points(CellLight::points_for(kInfinity), task.seed, context.scheduler);
  }
  LocalPoints local_points;
  if (local) local_points = local->draw(hash_words(task.seed, 6), context);
  const CellLight light(cells, scene.environment(), std::move(distant_points), local.get(),
                        std::move(local_points));
  const Rect crop = sensor.film().crop();
  if (x < crop.x0 || y < crop.y0 || x >= crop.x1 || y >= crop.y1) {
    throw Error("the pixel to inspect is outside the film's crop window");
  }
  PixelProbe probe(task, light, cells.padded_size() + (local ? local->padded_size() : 0));
  probe.learn(cells, x, y);
  const size_t shown = probe.find_patch(x, y);
  const uint32_t first_local = light.first_local();
  Inspection empty;
  empty.position = probe.patches[shown].position;
  empty.normal = probe.patches[shown].normal;
  std::vector<Inspection> reports;
  if (cells.size() > 0) {
    reports.push_back(empty);
    describe(shared_cells, probe.visibility[shown], reports.back());
  }
  if (local) {
    reports.push_back(empty);
    reports.back().is_distant = false;
    describe(*local, first_local, probe.visibility[shown], reports.back());
  }
  // Returns the report and the cluster to which a record belongs.
  const auto cluster_of = [&](const VisibilityRecord& record) {
    const bool is_local = record.cell() >= first_local;
    Inspection& report = is_local ? reports.back() : reports.front();
    return std::pair(&report, &report.clusters[record.cell() - (is_local ? first_local : 0)]);
  };
  const Records shares = probe.shadow_rays(kShares, 4);
  for (const VisibilityRecord record : shares[shown]) {
    cluster_of(record).second->probability += 1. / static_cast<double>(shares[shown].size());
  }
  const auto count = static_cast<uint32_t>(std::max(1., sampling_.rays_per_pixel));
  const Records rays = probe.shadow_rays(count, 5);
  for (const VisibilityRecord record : rays[shown]) {
    const auto [report, cluster] = cluster_of(record);
    ++cluster->samples;
    report->samples.push_back({cluster->mean, 1, record.visible()});
  }
  return reports;
}

}  // namespace kinome
