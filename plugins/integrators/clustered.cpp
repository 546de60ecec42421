// clustered: direct light by clustered importance sampling (Åkerlund 2008).
//
// Light is a set of points (3.4) in a complete binary tree (3.3). A cut through the tree (4.2.1)
// gives clusters; for each shading point an importance function over them combines their light, the
// BRDF and the form factor (3.1, 4.2.2; see LightCut::build). `emitter_samples` points are drawn,
// first a cluster (eq. 3.2), then one of its points, all alike (4.3.3); each gets a shadow ray.
//
// Unbiased with respect to the point set: the expectation is what `groundtruth` renders. The set
// itself approximates the emitters by `light_samples` points.
//
// Deviations beside those of LightCut: points drawn more than once share one shadow ray; any
// sampler may be used, not only pseudo-random numbers (4.2.3, 6.1.1).
//
//   <integrator type="clustered"> <string name="importance" value="joint"/> </integrator>
#include <memory>

#include "kinome/light_cut.h"
#include "kinome/plugin.h"
#include "kinome/point_lights.h"
#include "kinome/primary_rays.h"

namespace {

using namespace kinome;

constexpr Parameter kParameters[] = {
    {"importance", ParameterType::kString, "joint",
     "What clusters are chosen by: 'joint' (light, BRDF and form factor), 'luminance' or 'brdf'."},
    {"light_samples", ParameterType::kInteger, "32768", "Points that each emitter is made of."},
    {"cut_size", ParameterType::kInteger, "512", "Clusters in the cut."},
    {"cut_criterion", ParameterType::kString, "variance",
     "Which cell of the tree is split next: that of the highest 'variance' or 'luminance'."},
    {"emitter_samples", ParameterType::kInteger, "128",
     "Light points drawn for each camera ray; rounded up as the sampler needs."},
    {"brdf_samples", ParameterType::kInteger, "32",
     "Lobe rays that estimate the BRDF in each cluster; none are sent where nothing is glossy."},
    {"hide_emitters", ParameterType::kBoolean, "false", "Leave lights out of the camera's view."},
};

uint32_t count_parameter(const Properties& props, const char* name, int64_t low, int64_t high) {
  const int64_t value = props.integer(name);
  if (value < low || value > high) {
    throw props.error(name, "must be between " + std::to_string(low) + " and " +
                                std::to_string(high) + ", got " + std::to_string(value));
  }
  return static_cast<uint32_t>(value);
}

/// What a thread keeps from point to point.
struct Scratch {
  ClusterPmf pmf;
  std::vector<float> x, y, z;  ///< lobe directions
  std::vector<Vec2> u;         ///< numbers that choose light points
};

/// Chooses light points for shading points; shared by all threads.
class Chooser {
 public:
  Chooser(const LightCut& cut, Importance importance, std::shared_ptr<Sampler> light_sampler,
          std::shared_ptr<Sampler> lobe_sampler)
      : cut_(cut),
        importance_(importance),
        light_sampler_(std::move(light_sampler)),
        lobe_sampler_(std::move(lobe_sampler)) {
    if (importance == Importance::kLuminance) luminance_pmf_ = cut.luminance_pmf();
  }

  void operator()(const SurfaceInteraction& si, const SampleKey& key, RenderCounters& counters,
                  PointSelection& selection) const {
    thread_local Scratch scratch;
    const ClusterPmf* pmf = &luminance_pmf_;
    if (importance_ != Importance::kLuminance) {
      const StageTimer timer(counters.stage_seconds["importance"]);
      build_pmf(si, key, counters, scratch);
      pmf = &scratch.pmf;
    }
    const StageTimer timer(counters.stage_seconds["choose"]);
    if (!pmf->empty()) draw(*pmf, key, scratch, selection);
  }

 private:
  void build_pmf(const SurfaceInteraction& si, const SampleKey& key, RenderCounters& counters,
                 Scratch& scratch) const {
    const Bsdf& bsdf = si.shape->bsdf();
    const LobeReflectance reflectance = bsdf.reflectance(si);
    LightCut::Point point;
    point.normal = bsdf.reflection_frame(si).n;
    point.diffuse = luminance(reflectance.diffuse);
    point.glossy = luminance(reflectance.glossy);
    if (point.glossy > 0 && lobe_sampler_) {
      sample_lobe(si, key, scratch);
      counters[RayKind::kLobe] += scratch.x.size();
      point.lobe = {scratch.x.data(), scratch.y.data(), scratch.z.data(), scratch.x.size()};
    }
    cut_.build(importance_, point, scratch.pmf);
  }

  /// Directions of the glossy lobe, in world space; those below the horizon are left out, as their
  /// light is (4.2.2 covers the diffuse lobe by the horizon test instead).
  void sample_lobe(const SurfaceInteraction& si, const SampleKey& key, Scratch& scratch) const {
    scratch.x.clear();
    scratch.y.clear();
    scratch.z.clear();
    const uint32_t count = lobe_sampler_->sample_count();
    SampleKey lobe_key = key;
    for (uint32_t i = 0; i < count; ++i) {
      lobe_key.sample = key.sample * count + i;
      SampleStream stream(*lobe_sampler_, lobe_key, kChooseDimensions);
      const Vec2 direction = stream.next_2d();
      const auto sample = si.shape->bsdf().sample(si, Lobe::kGlossy, stream.next_1d(), direction);
      if (!sample) continue;
      const Vec3 d = si.frame.to_world(sample->wo);
      scratch.x.push_back(d.x);
      scratch.y.push_back(d.y);
      scratch.z.push_back(d.z);
    }
  }

  void draw(const ClusterPmf& pmf, const SampleKey& key, Scratch& scratch,
            PointSelection& selection) const {
    const uint32_t count = light_sampler_->sample_count();
    SampleKey first = key;
    first.sample = key.sample * count;
    scratch.u.resize(count);
    light_sampler_->fill_2d(first, kChooseDimensions + 4, count, scratch.u.data());
    cut_.sample_points(pmf, scratch.u, selection);
  }

  const LightCut& cut_;
  const Importance importance_;
  const std::shared_ptr<Sampler> light_sampler_;
  const std::shared_ptr<Sampler> lobe_sampler_;  ///< nullptr: no lobe rays
  ClusterPmf luminance_pmf_;
};

class Clustered final : public Integrator {
 public:
  explicit Clustered(const Properties& props)
      : light_samples_(count_parameter(props, "light_samples", 1, 1 << 24)),
        cut_size_(count_parameter(props, "cut_size", 1, 1 << 20)),
        emitter_samples_(count_parameter(props, "emitter_samples", 1, 1 << 20)),
        brdf_samples_(count_parameter(props, "brdf_samples", 0, 1 << 16)),
        hide_emitters_(props.boolean("hide_emitters")) {
    static constexpr const char* kImportances[] = {"joint", "luminance", "brdf"};
    importance_ = static_cast<Importance>(props.choice("importance", kImportances));
    static constexpr const char* kCriteria[] = {"variance", "luminance"};
    criterion_ = static_cast<CutCriterion>(props.choice("cut_criterion", kCriteria));
  }

  void render(const Scene& scene, const Sensor& sensor, RenderContext& context) const override {
    ScenePointLights lights = gather(scene, context);
    if (lights.points.size() == 0) {
      context.skip("light tree", "no emitter offers light points");
      render_point_lights(scene, sensor, context, lights, hide_emitters_, {});
      return;
    }
    std::unique_ptr<LightTree> tree;
    std::unique_ptr<LightCut> cut;
    {
      const StageTimer timer(context.stats().counters.stage_seconds["tree"]);
      tree = std::make_unique<LightTree>(std::move(lights.points));
      cut = std::make_unique<LightCut>(*tree, cut_size_, criterion_);
      lights.points = tree->points();
    }
    const Chooser chooser(*cut, importance_, sensor.sampler().with_sample_count(emitter_samples_),
                          lobe_sampler(scene, sensor, context));
    render_point_lights(scene, sensor, context, lights, hide_emitters_, std::ref(chooser));
  }

 private:
  ScenePointLights gather(const Scene& scene, RenderContext& context) const {
    const StageTimer timer(context.stats().counters.stage_seconds["light points"]);
    return gather_point_lights(scene, context, light_samples_);
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

  uint32_t light_samples_;
  uint32_t cut_size_;
  uint32_t emitter_samples_;
  uint32_t brdf_samples_;
  bool hide_emitters_;
  Importance importance_;
  CutCriterion criterion_;
};

}  // namespace

KINOME_PLUGIN(Clustered, Category::kIntegrator, "clustered",
              "Direct light by clustered importance sampling (Åkerlund 2008): a cut through a tree "
              "of light points, and an importance function over it for each shading point.",
              kParameters);
