// clustered: direct light, and one bounce of it, by clustered importance sampling (Åkerlund 2008).
//
// Light is a set of points (3.4), on the sphere of directions for an environment, on the scene's
// surfaces for light after a bounce (`max_depth` 3 and more), in a complete binary tree (3.3). A
// cut through the tree (4.2.1) gives clusters; for each shading point an importance function over
// them combines their light, the BRDF and the form factor (3.1, 4.2.2; see LightCut::build).
// `emitter_samples` points are drawn, first a cluster (eq. 3.2), then one of its points, all alike
// (4.3.3); each gets a shadow ray.
//
// Unbiased with respect to the point set: the expectation is what `groundtruth` renders. The set
// itself approximates the emitters by `light_samples` points. Lights that offer no points (lamps,
// as seen directly) get one light sample each.
//
// Deviations beside those of LightCut: points drawn more than once share one shadow ray; any
// sampler may be used, not only pseudo-random numbers (4.2.3, 6.1.1).
//
//   <integrator type="clustered"> <integer name="max_depth" value="3"/> </integrator>
#include <algorithm>
#include <cmath>
#include <memory>

#include "clustered/clustered_stages.h"
#include "clustered/point_light_parameters.h"
#include "clustered/points/light_cut.h"
#include "clustered/product/product_sampling.h"
#include "kinome/log.h"
#include "kinome/plugin.h"
#include "kinome/primary_rays.h"

namespace {

using namespace kinome;

constexpr Parameter kParameters[] = {
    {"importance", ParameterType::kString, "product",
     "What light is chosen by: 'product' (light x BRDF x learned visibility, of the environment "
     "itself), or as in the thesis, of light points, 'joint' (light, BRDF and form factor), "
     "'luminance' or 'brdf'. Where an emitter doesn't offer what 'product' needs, as all of "
     "Kinome's "
     "own do, or light points are asked for that are to be some emitters' alone or bounded "
     "(max_geometry_term), 'product' is 'joint'."},
    {"rays_per_pixel", ParameterType::kFloat, "0",
     "'product': rays of all kinds that a pixel gets on average; 0: three for each of the "
     "sampler's samples, which is what 'direct' takes."},
    {"diagnostics", ParameterType::kBoolean, "false",
     "'product': also channels samples (camera rays of a pixel), cost (its rays of all kinds) and "
     "visibility (what is learned of it)."},
    {"control_variate", ParameterType::kBoolean, "true",
     "'product': add what is known of visible light without rays."},
    {"learned_sigma", ParameterType::kBoolean, "true",
     "'product': send rays where visibility is uncertain."},
    {"adaptive", ParameterType::kBoolean, "true",
     "'product': give rays to the pixels that need them."},
    {"light_guide", ParameterType::kBoolean, "true",
     "'product': draw light points where what they light is seen."},
    KINOME_POINT_LIGHT_PARAMETERS,
    {"cut_size", ParameterType::kInteger, "512", "Clusters in the cut."},
    {"cut_criterion", ParameterType::kString, "variance",
     "Which cell of the tree is split next: that of the highest 'variance' or 'luminance'."},
    {"emitter_samples", ParameterType::kInteger, "128",
     "Light points drawn for each camera ray; rounded up as the sampler needs."},
    {"brdf_samples", ParameterType::kInteger, "32",
     "Lobe rays that estimate the BRDF in each cluster; none are sent where nothing is glossy."},
};

constexpr double kMostRays = 1e12;
/// Cells of an environment where there is local light, too: together they are no more than
/// kMaxCells.
constexpr uint32_t kMostCellsBesideOthers = 1u << 14;

/// What a thread keeps from point to point.
struct Scratch {
  ClusterPmf pmf;
  std::vector<float> x, y, z;  ///< lobe directions
  std::vector<Vec2> u;         ///< numbers that choose light points
};

/// Chooses light points for shading points; shared by all threads.
class Chooser {
 public:
  Chooser(std::shared_ptr<const LightCut> cut, Importance importance,
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

class Clustered final : public Integrator {
 public:
  explicit Clustered(const Properties& props)
      : settings_(read_point_light_parameters(props)),
        cut_size_(props.integer("cut_size", 1, 1 << 20)),
        emitter_samples_(props.integer("emitter_samples", 1, 1 << 20)),
        brdf_samples_(props.integer("brdf_samples", 0, 1 << 16)) {
    static constexpr const char* kImportances[] = {"joint", "luminance", "brdf", "product"};
    const int importance = props.choice("importance", kImportances);
    is_product_ = importance == 3;
    importance_ = is_product_ ? Importance::kJoint : static_cast<Importance>(importance);
    product_.rays_per_pixel = props.real("rays_per_pixel");
    if (!(product_.rays_per_pixel >= 0 && product_.rays_per_pixel <= kMostRays)) {
      throw props.error("rays_per_pixel",
                        "must be from 0 to 1e12, got " + std::to_string(product_.rays_per_pixel));
    }
    product_.diagnostics = props.boolean("diagnostics");
    if (product_.diagnostics && !is_product_) {
      throw props.error("diagnostics", "are those of importance 'product'");
    }
    product_.max_depth = settings_.options.local ? settings_.options.max_depth : 2;
    product_.hide_emitters = settings_.options.hide_emitters;
    product_.control_variate = props.boolean("control_variate");
    product_.learned_sigma = props.boolean("learned_sigma");
    product_.adaptive = props.boolean("adaptive");
    product_.light_guide = props.boolean("light_guide");
    static constexpr const char* kCriteria[] = {"variance", "luminance"};
    criterion_ = static_cast<CutCriterion>(props.choice("cut_criterion", kCriteria));
  }

  const char* default_indirect_emitter() const override { return indirect_emitter(settings_); }

  std::vector<Stage> stages() const override {
    return {std::begin(kClusteredStages), std::end(kClusteredStages)};
  }

  std::vector<std::vector<std::string>> layers() const override {
    if (!product_.diagnostics) return {{}};
    return {{}, {std::begin(kProductChannels), std::end(kProductChannels)}};
  }

  void warn_of_light_left_out(const Scene& scene, const Sensor& sensor,
                              RenderContext& context) const override {
    kinome::warn_of_light_left_out(settings_, scene, sensor, context);
  }

  std::unique_ptr<Passes> begin(const Scene& scene, const Sensor& sensor, RenderContext& context,
                                double seconds) const override {
    auto cells = product_cells(scene, context);
    if (!cells) return Integrator::begin(scene, sensor, context, seconds);
    return begin_product(scene, sensor, context, std::move(*cells), product_settings(sensor),
                         seconds);
  }

  void render(const Scene& scene, const Sensor& sensor, RenderContext& context) const override {
    if (auto cells = product_cells(scene, context)) {
      render_product(scene, sensor, context, std::move(*cells), product_settings(sensor));
      return;
    }
    if (product_.diagnostics) {
      context.skip("diagnostics", "the scene isn't one for importance 'product'");
    }
    if (render_without_surfaces(settings_, scene, sensor, context)) return;
    ScenePointLights lights = gather(settings_, scene, context);
    std::vector<Chooser> choosers = make_choosers(lights, scene, sensor, context);
    for (size_t i = 0; i < choosers.size(); ++i) lights.sets[i].choose = std::ref(choosers[i]);
    render_point_lights(scene, sensor, context, lights, settings_.options);
  }

  std::vector<Inspection> inspect(const Scene& scene, const Sensor& sensor, RenderContext& context,
                                  const Vec2& film_position) const override {
    if (settings_.options.max_depth < 2) {
      throw Error(settings_.where, "there is no light to choose where max_depth is less than 2");
    }
    RenderCounters counters;
    PrimaryBatch primary;
    const auto x = static_cast<int>(film_position.x), y = static_cast<int>(film_position.y);
    if (auto own = product_cells(scene, context)) {
      const auto cells = std::make_shared<const DistantCells>(std::move(*own));
      std::vector<Inspection> reports =
          inspect_product(scene, sensor, context, *cells, product_settings(sensor), x, y);
      // The reports keep the cells alive.
      for (Inspection& report : reports) {
        if (!report.cluster_at) continue;
        report.cluster_at = [cells, at = report.cluster_at](const Vec3& d) { return at(d); };
      }
      return reports;
    }
    primary.trace(scene, sensor, {x, y, x + 1, y + 1}, 0, 1, key_seed(context, sensor.sampler()),
                  counters);
    if (settings_.options.hide_emitters) primary.pass_emitters(scene, counters);
    if (!primary.hit(0)) throw Error("there is no surface at the place to inspect");
    const SurfaceInteraction& si = primary.interaction(0);
    ScenePointLights lights = gather(settings_, scene, context);
    const std::vector<Chooser> choosers = make_choosers(lights, scene, sensor, context);
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

 private:
  /// nullopt where the scene isn't one for `product`. No cells: it has no environment, or a black
  /// one.
  std::optional<DistantCells> product_cells(const Scene& scene, RenderContext& context) const {
    if (!is_product_ || settings_.options.max_depth < 2 || scene.emitters().empty()) {
      return std::nullopt;
    }
    if (!is_product_scene(scene, product_.max_depth)) {
      const bool is_bounce = product_.max_depth > 2 && is_product_scene(scene, 2);
      log_warn(std::string("an emitter doesn't offer what importance 'product' needs") +
               (is_bounce ? " for light after a bounce (emission_density; max_depth 2 needs none)"
                          : "") +
               ": light is chosen by 'joint', which takes longer");
      return std::nullopt;
    }
    if (product_.max_depth > 2) {
      // What only light points can do: the bounce of some emitters, and one that is bounded.
      const auto& indirect = scene.indirect_emitters();
      const bool chosen = std::any_of(indirect.begin(), indirect.end(),
                                      [](const Emitter* e) { return !e->children().empty(); });
      if (chosen || settings_.options.max_geometry_term > 0) return std::nullopt;
    }
    const StageTimer timer(context.stats().counters.stage_seconds["cells"]);
    if (!scene.environment()) return DistantCells();
    const bool alone = scene.emitters().size() == 1 && product_.max_depth == 2;
    const uint32_t count = alone ? cut_size_ : std::min(cut_size_, kMostCellsBesideOthers);
    DistantCells cells(*scene.environment(), *scene.environment()->cell_grid(), count, context);
    if (cells.size() == 0 && alone) return std::nullopt;
    return cells;
  }

  ProductSettings product_settings(const Sensor& sensor) const {
    ProductSettings settings = product_;
    if (!(settings.rays_per_pixel > 0)) {
      settings.rays_per_pixel = kRaysPerSample * sensor.sampler().sample_count();
    }
    return settings;
  }

  /// One for each set, whose points are put in the order of their tree.
  std::vector<Chooser> make_choosers(ScenePointLights& lights, const Scene& scene,
                                     const Sensor& sensor, RenderContext& context) const {
    std::vector<Chooser> choosers;
    if (lights.sets.empty()) {
      context.skip("light tree", "no emitter offers light points");
      return choosers;
    }
    const auto light_sampler = sensor.sampler().with_sample_count(emitter_samples_);
    const auto lobe = lobe_sampler(scene, sensor, context);
    for (PointLightSet& set : lights.sets) {
      choosers.emplace_back(make_cut(set.points, context), importance_, light_sampler, lobe);
    }
    return choosers;
  }

  /// Leaves `points` in the order of the tree.
  std::shared_ptr<const LightCut> make_cut(LightPoints& points, RenderContext& context) const {
    const StageTimer timer(context.stats().counters.stage_seconds["tree"]);
    const LightTree tree(std::move(points));
    points = tree.points();
    return std::make_shared<LightCut>(tree, cut_size_, criterion_);
  }

  /// The sampler of the lobe rays, or nullptr where nothing needs them.
  std::shared_ptr<Sampler> lobe_sampler(const Scene& scene, const Sensor& sensor,
                                        RenderContext& context) const {
    if (importance_ == Importance::kLuminance) {
      context.skip("lobe rays", "importance is luminance alone");
      return nullptr;
    }
    if (brdf_samples_ == 0) {
      context.skip("lobe rays", "brdf_samples is 0");
      return nullptr;
    }
    for (const auto& shape : scene.shapes()) {
      if (any(shape->bsdf().lobes() & Lobe::kGlossy)) {
        return sensor.sampler().with_sample_count(brdf_samples_);
      }
    }
    context.skip("lobe rays", "no surface has a glossy lobe");
    return nullptr;
  }

  PointLightSettings settings_;
  ProductSettings product_;
  bool is_product_ = false;
  uint32_t cut_size_;
  uint32_t emitter_samples_;
  uint32_t brdf_samples_;
  Importance importance_;
  CutCriterion criterion_;
};

}  // namespace

KINOME_PLUGIN(Clustered, Category::kIntegrator, "clustered",
              "Direct light and one bounce by clustered importance sampling (Åkerlund 2008): a cut "
              "through a tree of light points, and an importance function over it for each "
              "shading point.",
              kParameters);
