#include "clustered/points/thesis_method.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include "kinome/primary_rays.h"

namespace kinome {
namespace {

/// What a thread keeps from point to point.
struct Scratch {
  ClusterPmf pmf;
  std::vector<float> x, y, z;  ///< lobe directions
  std::vector<Vec2> u;         ///< numbers that choose light points
};

}  // namespace

/// Chooses light points for shading points; shared by all threads.
class ClusterChooser {
 public:
  ClusterChooser(std::shared_ptr<const LightCut> cut, Importance importance,
                 std::shared_ptr<Sampler> light_sampler, std::shared_ptr<Sampler> lobe_sampler)
      : cut_(std::move(cut)),
        importance_(importance),
        light_sampler_(std::move(light_sampler)),
        lobe_sampler_(std::move(lobe_sampler)) {
    if (importance == Importance::kLuminance) luminance_pmf_ = cut_->luminance_pmf();
  }

  void operator()(const SurfaceInteraction& si, const SampleKey& key, uint32_t dimension,
                  RenderCounters& counters, PointSelection& selection) const {
    thread_local Scratch scratch;
    const ClusterPmf* pmf = &luminance_pmf_;
    if (importance_ != Importance::kLuminance) {
      const StageTimer timer(counters.stage_seconds["importance"]);
      build_pmf(importance_, si, key, dimension, counters, scratch);
      pmf = &scratch.pmf;
    }
    const StageTimer timer(counters.stage_seconds["choose"]);
    if (!pmf->empty()) draw(*pmf, key, dimension + kLobeDimensions, scratch, selection);
  }

  /// Without the samples' visibility.
  Inspection inspect(const LightPoints& points, const SurfaceInteraction& si, const SampleKey& key,
                     uint32_t dimension) const {
    Inspection report;
    report.kind = points.kind;
    report.position = si.p;
    report.normal = si.shape->bsdf().reflection_frame(si).n;
    RenderCounters counters;
    Scratch scratch;
    PointSelection selection;
    (*this)(si, key, dimension, counters, selection);
    report.clusters.resize(cut_->size());
    build_pmf(Importance::kBrdf, si, key, dimension, counters, scratch);
    const ClusterPmf brdf = scratch.pmf;
    if (importance_ != Importance::kLuminance) {
      build_pmf(importance_, si, key, dimension, counters, scratch);
    }
    const ClusterPmf& pmf = importance_ == Importance::kLuminance ? luminance_pmf_ : scratch.pmf;
    describe_clusters(pmf, brdf, report);
    for (size_t k = 0; k < selection.points.size(); ++k) {
      const uint32_t point = selection.points[k];
      report.samples.push_back(
          {points.origin(point, si.p - points.position[point]), selection.weights[k], false});
      // Draws of one point are merged: its weight tells how many there were.
      const float draws = selection.weights[k] * cut_->point_probability(pmf, point) *
                          static_cast<float>(light_sampler_->sample_count());
      report.clusters[cut_->cluster_of(point)].samples += static_cast<uint32_t>(std::lround(draws));
    }
    return report;
  }

 private:
  static constexpr uint32_t kLobeDimensions = 4;

  /// All of the clusters but their samples. Three distributions tell the parts: the importance is
  /// light x geometric x brdf.
  void describe_clusters(const ClusterPmf& pmf, const ClusterPmf& brdf, Inspection& report) const {
    LightCut::Point lambertian;
    lambertian.position = report.position;
    lambertian.normal = report.normal;
    lambertian.diffuse = 1;
    ClusterPmf geometric;
    cut_->build(Importance::kBrdf, lambertian, geometric);
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

  void build_pmf(Importance importance, const SurfaceInteraction& si, const SampleKey& key,
                 uint32_t dimension, RenderCounters& counters, Scratch& scratch) const {
    const Bsdf& bsdf = si.shape->bsdf();
    const LobeReflectance reflectance = bsdf.reflectance(si);
    LightCut::Point point;
    point.position = si.p;
    point.normal = bsdf.reflection_frame(si).n;
    point.diffuse = luminance(reflectance.diffuse);
    point.glossy = luminance(reflectance.glossy);
    if (point.glossy > 0 && lobe_sampler_) {
      sample_lobe(si, key, dimension, scratch);
      counters[RayKind::kLobe] += scratch.x.size();
      point.lobe = {scratch.x.data(), scratch.y.data(), scratch.z.data(), scratch.x.size()};
    }
    cut_->build(importance, point, scratch.pmf);
  }

  /// Directions of the glossy lobe, in world space; those below the horizon are left out, as their
  /// light is (4.2.2 covers the diffuse lobe by the horizon test instead).
  void sample_lobe(const SurfaceInteraction& si, const SampleKey& key, uint32_t dimension,
                   Scratch& scratch) const {
    scratch.x.clear();
    scratch.y.clear();
    scratch.z.clear();
    const uint32_t count = lobe_sampler_->sample_count();
    SampleKey lobe_key = key;
    for (uint32_t i = 0; i < count; ++i) {
      lobe_key.sample = key.sample * count + i;
      SampleStream stream(*lobe_sampler_, lobe_key, dimension);
      const Vec2 direction = stream.next_2d();
      const auto sample = si.shape->bsdf().sample(si, Lobe::kGlossy, stream.next_1d(), direction);
      if (!sample) continue;
      const Vec3 d = si.frame.to_world(sample->wo);
      scratch.x.push_back(d.x);
      scratch.y.push_back(d.y);
      scratch.z.push_back(d.z);
    }
  }

  void draw(const ClusterPmf& pmf, const SampleKey& key, uint32_t dimension, Scratch& scratch,
            PointSelection& selection) const {
    const uint32_t count = light_sampler_->sample_count();
    SampleKey first = key;
    first.sample = key.sample * count;
    scratch.u.resize(count);
    light_sampler_->fill_2d(first, dimension, count, scratch.u.data());
    cut_->sample_points(pmf, scratch.u, selection);
  }

  const std::shared_ptr<const LightCut> cut_;
  const Importance importance_;
  const std::shared_ptr<Sampler> light_sampler_;
  const std::shared_ptr<Sampler> lobe_sampler_;  ///< nullptr: no lobe rays
  ClusterPmf luminance_pmf_;
};

/// One for each set, whose points are put in the order of their tree.
std::vector<ClusterChooser> ThesisMethod::make_choosers(ScenePointLights& lights,
                                                        const Scene& scene, const Sensor& sensor,
                                                        RenderContext& context) const {
  std::vector<ClusterChooser> choosers;
  if (lights.sets.empty()) {
    context.skip("light tree", "no emitter offers light points");
    return choosers;
  }
  const auto light_sampler = sensor.sampler().with_sample_count(settings_.emitter_samples);
  const auto lobe = lobe_sampler(scene, sensor, context);
  for (PointLightSet& set : lights.sets) {
    choosers.emplace_back(make_cut(set.points, context), settings_.importance, light_sampler, lobe);
  }
  return choosers;
}

/// Leaves `points` in the order of the tree.
std::shared_ptr<const LightCut> ThesisMethod::make_cut(LightPoints& points,
                                                       RenderContext& context) const {
  const StageTimer timer(context.stats().counters.stage_seconds["tree"]);
  const LightTree tree(std::move(points));
  points = tree.points();
  return std::make_shared<LightCut>(tree, settings_.cut_size, settings_.criterion);
}

/// The sampler of the lobe rays, or nullptr where nothing needs them.
std::shared_ptr<Sampler> ThesisMethod::lobe_sampler(const Scene& scene, const Sensor& sensor,
                                                    RenderContext& context) const {
  if (settings_.importance == Importance::kLuminance) {
    context.skip("lobe rays", "importance is luminance alone");
    return nullptr;
  }
  if (settings_.brdf_samples == 0) {
    context.skip("lobe rays", "brdf_samples is 0");
    return nullptr;
  }
  for (const auto& shape : scene.shapes()) {
    if (any(shape->bsdf().lobes() & Lobe::kGlossy)) {
      return sensor.sampler().with_sample_count(settings_.brdf_samples);
    }
  }
  context.skip("lobe rays", "no surface has a glossy lobe");
  return nullptr;
}

void ThesisMethod::render(ScenePointLights lights, const Scene& scene, const Sensor& sensor,
                          RenderContext& context) const {
  std::vector<ClusterChooser> choosers = make_choosers(lights, scene, sensor, context);
  for (size_t i = 0; i < choosers.size(); ++i) lights.sets[i].choose = std::ref(choosers[i]);
  render_point_lights(scene, sensor, context, lights, settings_.options);
}

std::vector<Inspection> ThesisMethod::inspect(ScenePointLights lights, const Scene& scene,
                                              const Sensor& sensor, RenderContext& context, int x,
                                              int y) const {
  RenderCounters counters;
  PrimaryBatch primary;
  primary.trace(scene, sensor, {x, y, x + 1, y + 1}, 0, 1, key_seed(context, sensor.sampler()),
                counters);
  if (settings_.options.hide_emitters) primary.pass_emitters(scene, counters);
  if (!primary.hit(0)) throw Error("there is no surface at the place to inspect");
  const SurfaceInteraction& si = primary.interaction(0);
  const std::vector<ClusterChooser> choosers = make_choosers(lights, scene, sensor, context);
  std::vector<Inspection> reports;
  for (size_t i = 0; i < choosers.size(); ++i) {
    const LightPoints& points = lights.sets[i].points;
    reports.push_back(choosers[i].inspect(points, si, primary.key(0), kPrimaryDimensions));
    for (InspectedSample& sample : reports.back().samples) {
      const bool distant = points.kind == LightPoints::Kind::kDistant;
      Ray shadow =
          distant ? si.shadow_ray(sample.position, kInfinity) : si.shadow_ray_to(sample.position);
      scene.occluded({&shadow, 1}, Coherence::kIncoherent, counters);
      sample.visible = !shadow.is_occluded();
    }
  }
  return reports;
}

}  // namespace kinome
