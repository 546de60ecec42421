#include "clustered/points/thesis_method.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <utility>

#include "clustered/points/lobe_samples.h"
#include "kinome/block_points.h"
#include "transport/blocks/blocks_of_tile.h"
#include "transport/camera/camera.h"

namespace kinome {

/// Chooses light points for shading points. Shared by all threads.
class ClusterChooser {
  /// Memory that a thread reuses from block to block.
  struct Scratch {
    Scratch(uint32_t draws, const Sampler* lobe_sampler)
        : arena(draws), numbers(arena.two()), u(draws) {
      if (lobe_sampler) lobes.emplace(*lobe_sampler);
    }

    /// A point whose lobe samples haven't been drawn yet.
    struct Waiting {
      size_t i;
      const Bsdf* bsdf;
      LightCut::Point point;
      std::optional<size_t> lobe;  ///< number of the point in `lobes`
    };
    std::vector<Waiting> waiting;
    std::optional<LobeSamples> lobes;
    ClusterPmf pmf;
    PointSelection selection;
    transport::Arena arena;
    Columns2 numbers;     ///< random numbers that choose light points
    std::vector<Vec2> u;  ///< the same numbers
  };

 public:
  ClusterChooser(std::shared_ptr<const LightCut> cut, std::unique_ptr<ClusterImportance> importance,
                 std::shared_ptr<Sampler> light_sampler, std::shared_ptr<Sampler> lobe_sampler)
      : cut_(std::move(cut)),
        importance_(std::move(importance)),
        light_sampler_(std::move(light_sampler)),
        lobe_sampler_(std::move(lobe_sampler)) {
    importance_->prepare(*cut_);
  }

  void operator()(const LitPoints& points, RenderCounters& counters, const UseChosen& use) const {
    scratch_.with_one([&] { return make_scratch(); }, [&](Scratch& scratch) {
      points.for_each([&](size_t i, const Bsdf& bsdf) {
        if (!importance_->uses_point()) {
          choose(importance_->weigh({}, scratch.pmf), points, i, bsdf, scratch, counters, use);
          return;
        }
        if (scratch.lobes && !scratch.lobes->has_room()) {
          choose_waiting(points, scratch, counters, use);
        }
        const StageTimer timer(counters.stage_seconds["importance"]);
        wait(points, i, bsdf, scratch);
      });
      choose_waiting(points, scratch, counters, use);
    });
  }

  /// Returns the report of point i, without the samples' visibility.
  Inspection inspect(const LightPoints& lights, const LitPoints& points, size_t i) const {
    const SurfaceInteraction si = interaction_of(points.surfaces.points(), i);
    const Bsdf& bsdf = si.shape->bsdf();
    Inspection report;
    report.is_distant = lights.kind == LightPoints::Kind::kDistant;
    report.position = si.p;
    report.normal = bsdf.reflection_frame(si).n;
    RenderCounters counters;
    const auto scratch = make_scratch();
    wait(points, i, bsdf, *scratch);
    find_lobes(*scratch, counters);
    const LightCut::Point& point = scratch->waiting[0].point;
    const ClusterPmf& pmf = importance_->weigh(point, scratch->pmf);
    report.clusters.resize(cut_->size());
    describe_clusters(pmf, point, report);
    const PointSelection& selection = scratch->selection;
    draw(pmf, points, i, *scratch);
    for (size_t k = 0; k < selection.points.size(); ++k) {
      const uint32_t chosen = selection.points[k];
      report.samples.push_back({lights.origin(chosen, si.p - lights.position[chosen]),
                                selection.weights[k], false});
      // Draws of one point are merged: their number follows from the weight.
      const float draws = selection.weights[k] * cut_->point_probability(pmf, chosen) *
                          static_cast<float>(light_sampler_->sample_count());
      report.clusters[cut_->cluster_of(chosen)].samples +=
          static_cast<uint32_t>(std::lround(draws));
    }
    return report;
  }

 private:
  std::unique_ptr<Scratch> make_scratch() const {
    return std::make_unique<Scratch>(light_sampler_->sample_count(), lobe_sampler_.get());
  }

  /// Sets the clusters of the report, except for their samples. Importance is light x geometric x
  /// brdf; the factors are derived from three distributions.
  void describe_clusters(const ClusterPmf& pmf, const LightCut::Point& point,
                         Inspection& report) const {
    const std::unique_ptr<ClusterImportance> brdf_importance = make_brdf_importance();
    brdf_importance->prepare(*cut_);
    ClusterPmf brdf, geometric;
    brdf_importance->weigh(point, brdf);
    LightCut::Point lambertian;
    lambertian.position = report.position;
    lambertian.normal = report.normal;
    lambertian.diffuse = 1;
    brdf_importance->weigh(lambertian, geometric);
    double light = 0, best_brdf = 0, best_geometric = 0;
    for (uint32_t c = 0; c < cut_->size(); ++c) {
      const LightCell& cell = cut_->cell(c);
      InspectedCluster& out = report.clusters[c];
      out.box = cell.box;
      out.mean = cell.mean;
      out.normal = cell.normal;
      out.points = cell.count;
      out.light = cell.weight;
      out.hits = brdf.hits(c);
      const double g = geometric.empty() ? 0 : geometric.probability(c);
      out.geometric = g / cell.extent;
      out.brdf = g > 0 && !brdf.empty() ? brdf.probability(c) / g : 0;
      out.probability = pmf.empty() ? 0 : pmf.probability(c);
      light += out.light;
      best_brdf = std::max(best_brdf, out.brdf);
      best_geometric = std::max(best_geometric, out.geometric);
    }
    for (InspectedCluster& out : report.clusters) {
      if (light > 0) out.light /= light;
      if (best_brdf > 0) out.brdf /= best_brdf;
      if (best_geometric > 0) out.geometric /= best_geometric;
    }
  }

  /// Adds point i to the waiting points, with all arguments of its importance but the lobe samples.
  void wait(const LitPoints& points, size_t i, const Bsdf& bsdf, Scratch& scratch) const {
    const SurfaceInteraction si = interaction_of(points.surfaces.points(), i);
    const LobeReflectance reflectance = bsdf.reflectance(si);
    Scratch::Waiting waiting{i, &bsdf, {}, std::nullopt};
    waiting.point.position = si.p;
    waiting.point.normal = bsdf.reflection_frame(si).n;
    waiting.point.diffuse = luminance(reflectance.diffuse);
    waiting.point.glossy = luminance(reflectance.glossy);
    if (waiting.point.glossy > 0 && scratch.lobes) {
      waiting.lobe = scratch.lobes->add(points, i, bsdf);
    }
    scratch.waiting.push_back(waiting);
  }

  void find_lobes(Scratch& scratch, RenderCounters& counters) const {
    if (!scratch.lobes) return;
    scratch.lobes->draw();
    for (Scratch::Waiting& waiting : scratch.waiting) {
      if (!waiting.lobe) continue;
      waiting.point.lobe = scratch.lobes->directions(*waiting.lobe);
      counters[RayKind::kLobe] += waiting.point.lobe.count;
    }
  }

  void choose_waiting(const LitPoints& points, Scratch& scratch, RenderCounters& counters,
                      const UseChosen& use) const {
    {
      const StageTimer timer(counters.stage_seconds["importance"]);
      find_lobes(scratch, counters);
    }
    for (const Scratch::Waiting& waiting : scratch.waiting) {
      const ClusterPmf* pmf = nullptr;
      {
        const StageTimer timer(counters.stage_seconds["importance"]);
        pmf = &importance_->weigh(waiting.point, scratch.pmf);
      }
      choose(*pmf, points, waiting.i, *waiting.bsdf, scratch, counters, use);
    }
    scratch.waiting.clear();
    if (scratch.lobes) scratch.lobes->clear();
  }

  void choose(const ClusterPmf& pmf, const LitPoints& points, size_t i, const Bsdf& bsdf,
              Scratch& scratch, RenderCounters& counters, const UseChosen& use) const {
    if (pmf.empty()) return;
    {
      const StageTimer timer(counters.stage_seconds["choose"]);
      draw(pmf, points, i, scratch);
    }
    use(i, bsdf, scratch.selection);
  }

  void draw(const ClusterPmf& pmf, const LitPoints& points, size_t i, Scratch& scratch) const {
    const uint32_t count = light_sampler_->sample_count();
    const SampleKey key = transport::key_of(points.samples, points.owner[i]);
    const PixelSamples samples{&key.x, &key.y, 1, key.sample * count, count, key.seed};
    light_sampler_->fill_2d_block(samples, points.dimension + LobeSamples::kDimensions,
                                  scratch.numbers);
    for (uint32_t k = 0; k < count; ++k) scratch.u[k] = scratch.numbers.at(k);
    scratch.selection.clear();
    cut_->sample_points(pmf, scratch.u, scratch.selection);
  }

  const std::shared_ptr<const LightCut> cut_;
  const std::unique_ptr<ClusterImportance> importance_;
  const std::shared_ptr<Sampler> light_sampler_;
  const std::shared_ptr<Sampler> lobe_sampler_;  ///< nullptr: no lobe rays
  mutable transport::Workers<Scratch> scratch_;
};

/// Makes a chooser for each set, and sorts the set's points in the order of their tree.
std::deque<ClusterChooser> ThesisMethod::make_choosers(ScenePointLights& lights, const Scene& scene,
                                                       const Sensor& sensor,
                                                       RenderContext& context) const {
  std::deque<ClusterChooser> choosers;
  if (lights.sets.empty()) {
    context.job.skip("light tree", "no emitter has light points");
    return choosers;
  }
  const auto light_sampler = sensor.sampler().with_sample_count(settings_.emitter_samples);
  const auto lobe = lobe_sampler(scene, sensor, context);
  for (PointLightSet& set : lights.sets) {
    choosers.emplace_back(make_cut(set.points, context), settings_.importance(), light_sampler,
                          lobe);
  }
  return choosers;
}

/// Makes the cut, and sorts `points` in the order of the tree.
std::shared_ptr<const LightCut> ThesisMethod::make_cut(LightPoints& points,
                                                       RenderContext& context) const {
  const StageTimer timer(context.job.stats().counters.stage_seconds["tree"]);
  const LightTree tree(std::move(points));
  points = tree.points();
  return std::make_shared<LightCut>(tree, settings_.cut_size, settings_.criterion);
}

/// Returns the sampler of the lobe rays, or nullptr if they aren't needed.
std::shared_ptr<Sampler> ThesisMethod::lobe_sampler(const Scene& scene, const Sensor& sensor,
                                                    RenderContext& context) const {
  if (!settings_.importance()->uses_point()) {
    context.job.skip("lobe rays", "importance is luminance alone");
    return nullptr;
  }
  if (settings_.brdf_samples == 0) {
    context.job.skip("lobe rays", "brdf_samples is 0");
    return nullptr;
  }
  for (const auto& shape : scene.shapes()) {
    if (any(shape->bsdf().lobes() & Lobe::kGlossy)) {
      return sensor.sampler().with_sample_count(settings_.brdf_samples);
    }
  }
  context.job.skip("lobe rays", "no surface has a glossy lobe");
  return nullptr;
}

void ThesisMethod::render(const Scene& scene, const Sensor& sensor, RenderContext& context) const {
  if (lacks_diagnostics_) {
    context.job.skip("diagnostics", "the scene isn't rendered by importance 'product'");
  }
  if (render_without_surfaces(points_, scene, sensor, context)) return;
  ScenePointLights lights = gather(points_, scene, context);
  std::deque<ClusterChooser> choosers = make_choosers(lights, scene, sensor, context);
  for (size_t i = 0; i < choosers.size(); ++i) lights.sets[i].choose = std::ref(choosers[i]);
  render_point_lights(scene, sensor, context, lights, points_.options);
}

std::vector<Inspection> ThesisMethod::inspect(const Scene& scene, const Sensor& sensor,
                                              RenderContext& context, int x, int y) const {
  ScenePointLights lights = gather(points_, scene, context);
  RenderCounters counters;
  const transport::SceneTable table(scene);
  transport::Camera camera(table, sensor, 1, points_.options.hide_emitters);
  const auto column = static_cast<uint32_t>(x), row = static_cast<uint32_t>(y);
  const PixelSamples samples{&column, &row, 1, 0, 1, key_seed(context.job, sensor.sampler())};
  camera.trace(samples, counters);
  const SurfaceBlock& seen = camera.surfaces().points();
  if (seen.count == 0) throw Error("there is no surface at the pixel to inspect");
  const SurfaceInteraction si = interaction_of(seen, 0);
  const LitPoints points{samples, camera.surfaces(), seen.ray, transport::kCameraDimensions};
  const std::deque<ClusterChooser> choosers = make_choosers(lights, scene, sensor, context);
  std::vector<Inspection> reports;
  for (size_t i = 0; i < choosers.size(); ++i) {
    const LightPoints& of_set = lights.sets[i].points;
    reports.push_back(choosers[i].inspect(of_set, points, 0));
    for (InspectedSample& sample : reports.back().samples) {
      const bool distant = of_set.kind == LightPoints::Kind::kDistant;
      Ray shadow =
          distant ? si.shadow_ray(sample.position, kInfinity) : si.shadow_ray_to(sample.position);
      scene.occluded({&shadow, 1}, Coherence::kIncoherent, counters);
      sample.visible = !shadow.is_occluded();
    }
  }
  return reports;
}

}  // namespace kinome
