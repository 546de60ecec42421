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

}  // namespace

std::vector<Inspection> ProductMethod::inspect(const Scene& scene, const Sensor& sensor,
                                               RenderContext& context, int x, int y) const {
  const std::shared_ptr<const DistantCells> shared_cells = cells_();
  const DistantCells& cells = *shared_cells;
  const ProductTask task(scene, sensor, context, sampling_);
  const uint64_t seed = task.seed;
  const auto local = make_local_light(task);
  CellPoints distant_points;
  if (cells.size() > 0) {
    distant_points = cells.draw_points(CellLight::points_for(kInfinity), seed, context.scheduler);
  }
  LocalPoints local_points;
  if (local) local_points = local->draw(hash_words(seed, 6), context);
  const CellLight light(cells, scene.environment(), std::move(distant_points), local.get(),
                        std::move(local_points));
  const size_t padded = cells.padded_size() + (local ? local->padded_size() : 0);
  Estimator estimator(light);
  const Rect crop = sensor.film().crop();
  if (x < crop.x0 || y < crop.y0 || x >= crop.x1 || y >= crop.y1) {
    throw Error("the pixel to inspect is outside the film's crop window");
  }
  const transport::SceneTable table(scene);
  Primaries all({table, sensor, task.path_settings()});
  RenderCounters counters;
  const auto trace = [&](const Rect& pixels, uint16_t count, uint64_t key) {
    const std::vector<uint16_t> counts(pixels.area(), count);
    all.clear();
    all.add(pixels, counts);
    all.trace(hash_words(seed, key), counters);
    return all.tile(0);
  };
  const int x0 = x - (x - crop.x0) % kTileSide, y0 = y - (y - crop.y0) % kTileSide;
  TilePrimaries primaries =
      trace({x0, y0, std::min(x0 + kTileSide, crop.x1), std::min(y0 + kTileSide, crop.y1)},
            kPilotPrimaries, 1);
  std::vector<Patch> patches;
  make_patches(primaries, patches);
  std::vector<Visibility> visibility(patches.size(), Visibility(padded));
  // Sends shadow rays from the primaries and returns their records.
  const auto probe = [&](uint32_t rays, uint64_t key) {
    Records records(patches.size());
    std::vector<PointPlan> points(primaries.size());
    Unit unit;
    unit.end = static_cast<uint32_t>(primaries.size());
    unit.rays = rays;
    unit.seed = hash_words(seed, key);
    estimator.begin_tile(scene, primaries, patches, visibility, unit.seed, counters);
    estimator.probe(unit, points, records);
    estimator.flush();
    return records;
  };
  const Records pilot = probe(kInspectionRays, 2);
  CellNeighbours neighbours;
  if (cells.size() > 0) neighbours = find_neighbours(cells, context.scheduler);
  VisibilityLearner learner(padded, &neighbours);
  for (size_t p = 0; p < pilot.size(); ++p) {
    learner.begin();
    learner.add(pilot[p], kRecordWeight);
    learner.finish(visibility[p]);
  }

  primaries = trace({x, y, x + 1, y + 1}, kPrimaries, 3);
  assign_patches(primaries, patches);
  visibility.resize(patches.size(), Visibility(padded));
  std::vector<uint32_t> points(patches.size() + 1);
  for (size_t i = 0; i < primaries.size(); ++i) ++points[primaries.patch(i) + 1];
  const size_t shown = std::max_element(points.begin() + 1, points.end()) - points.begin() - 1;
  if (shown >= patches.size() || points[shown + 1] == 0) {
    throw Error("there is no surface at the pixel to inspect");
  }
  const uint32_t first_local = light.first_local();
  Inspection empty;
  empty.position = patches[shown].position;
  empty.normal = patches[shown].normal;
  std::vector<Inspection> reports;
  if (cells.size() > 0) {
    reports.push_back(empty);
    describe(shared_cells, visibility[shown], reports.back());
  }
  if (local) {
    reports.push_back(empty);
    reports.back().is_distant = false;
    describe(*local, first_local, visibility[shown], reports.back());
  }
  // Returns the report and the cluster to which a record belongs.
  const auto cluster_of = [&](const VisibilityRecord& record) {
    const bool is_local = record.cell() >= first_local;
    Inspection& report = is_local ? reports.back() : reports.front();
    return std::pair(&report, &report.clusters[record.cell() - (is_local ? first_local : 0)]);
  };
  const Records shares = probe(kShares, 4);
  for (const VisibilityRecord record : shares[shown]) {
    cluster_of(record).second->probability += 1. / static_cast<double>(shares[shown].size());
  }
  const Records rays = probe(static_cast<uint32_t>(std::max(1., sampling_.rays_per_pixel)), 5);
  for (const VisibilityRecord record : rays[shown]) {
    const auto [report, cluster] = cluster_of(record);
    ++cluster->samples;
    report->samples.push_back({cluster->mean, 1, record.visible()});
  }
  return reports;
}

}  // namespace kinome
