// clustered: light after any number of bounces by clustered importance sampling (Åkerlund 2008).
//
// The default `importance`, product, is described in PRODUCT.md. The following is about joint,
// luminance and brdf, which are the thesis's method: direct light, and one bounce of it.
//
// Light is a set of points (3.4) in a complete binary tree (3.3). The points of an environment are
// on the sphere of directions; those of light after a bounce (`max_depth` 3 and more) are on the
// scene's surfaces. A cut through the tree (4.2.1) gives clusters. For each shading point, an
// importance function over the clusters combines their light, the BRDF and the form factor (3.1,
// 4.2.2; see ClusterImportance). `emitter_samples` points are drawn: first a cluster (eq. 3.2),
// then one of its points, uniformly (4.3.3). Each drawn point gets a shadow ray.
//
// Unbiased with respect to the point set: the expectation is the image of `groundtruth`. The set
// itself approximates the emitters by `light_samples` points. Emitters without light points (lamps,
// as seen directly) get one emitter sample each.
//
// Deviations beside those of LightCut: points that are drawn more than once share one shadow ray;
// any sampler may be used, not only pseudo-random numbers (4.2.3, 6.1.1).
//
//   <integrator type="clustered"> <integer name="max_depth" value="3"/> </integrator>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "clustered/clustered_stages.h"
#include "clustered/media/media_method.h"
#include "clustered/path_method.h"
#include "clustered/points/thesis_method.h"
#include "clustered/product/method/product_method.h"
#include "kinome/log.h"
#include "kinome/plugin.h"
#include "transport/media/bodies/media_warnings.h"

namespace {

using namespace kinome;

constexpr const char* kImportances[] = {"joint", "luminance", "brdf", "product"};
/// Importance functions of the thesis, in the order of kImportances. 'product' is another method.
constexpr MakeClusterImportance* kThesisImportances[] = {
    make_joint_importance, make_luminance_importance, make_brdf_importance};
constexpr const char* kCriteria[] = {"variance", "luminance"};

constexpr Parameter kParameters[] = {
    choice_of("importance", kImportances, "product",
              "Criterion for choosing light: 'product' (light x BRDF x learned visibility), or "
              "criteria of the thesis, for light points: 'joint' (light, BRDF and form factor), "
              "'luminance' or 'brdf'. 'product' becomes 'joint' if an emitter lacks functions that "
              "'product' requires (Kinome's own have all), if indirect emitters are restricted to "
              "some emitters, or with max_geometry_term. 'product' renders media; the others "
              "ignore them."),
    {"rays_per_pixel", ParameterType::kFloat, "0",
     "'product': mean number of rays of all kinds per pixel; 0: three for each of the sampler's "
     "samples, as 'direct' takes."},
    {"diagnostics", ParameterType::kBoolean, "false",
     "'product': add the channels samples (camera rays of a pixel), cost (its rays of all kinds) "
     "and visibility (as learned)."},
    {"control_variate", ParameterType::kBoolean, "true",
     "'product': compute expected visible light without rays; shadow rays correct it."},
    {"learned_sigma", ParameterType::kBoolean, "true",
     "'product': trace rays where visibility is uncertain."},
    {"checked_sigma", ParameterType::kBoolean, "true",
     "'product': learn from the pilot how uncertain its predictions of visibility are."},
    {"adaptive", ParameterType::kBoolean, "true",
     "'product': assign more rays to pixels that need them."},
    {"smooth_plan", ParameterType::kBoolean, "true",
     "'product': also use the neighbours of a pixel for which the pilot has little data."},
    {"horizon_terms", ParameterType::kBoolean, "true",
     "'product': use the control variate also for light at the horizon of flat surfaces."},
    {"shared_candidates", ParameterType::kBoolean, "true",
     "'product': share candidates among pixels that reflect light similarly."},
    {"fewer_cells", ParameterType::kBoolean, "true",
     "'product': divide the environment into half as many cells (cut_size) below 40 rays per "
     "pixel, except in scenes of few primitives and with --time or --error."},
    {"light_guide", ParameterType::kBoolean, "true",
     "'product': draw light points where they contribute to the image."},
    {"trial", ParameterType::kBoolean, "true",
     "'product': render with 'path' (with media, 'volpath') if a trial on some tiles finds that it "
     "takes less work for the same error, or if the render is short (with media, and a max_depth "
     "above 3). 'product' always renders the image if 'path' can't find some of the light."},
    {"rr_depth", ParameterType::kInteger, "5",
     "'product': Russian roulette ends paths from the camera from this many surface points on."},
    KINOME_POINT_LIGHT_PARAMETERS,
    {"cut_size", ParameterType::kInteger, "512",
     "Number of clusters in the cut; for 'product', of cells of the environment."},
    choice_of("cut_criterion", kCriteria, "variance",
              "Criterion for splitting clusters: highest 'variance' or highest 'luminance' first."),
    {"emitter_samples", ParameterType::kInteger, "128",
     "Number of light points drawn for each camera ray; rounded up as the sampler requires."},
    {"brdf_samples", ParameterType::kInteger, "32",
     "Number of lobe rays that estimate the BRDF in each cluster; 0 if no surface is glossy."},
};

constexpr double kMaxRaysPerPixel = 1e12;

ThesisSettings read_thesis_settings(const Properties& props, MakeClusterImportance* importance) {
  ThesisSettings settings;
  settings.importance = importance;
  settings.cut_size = props.integer("cut_size", 1, 1 << 20);
  settings.emitter_samples = props.integer("emitter_samples", 1, 1 << 20);
  settings.brdf_samples = props.integer("brdf_samples", 0, 1 << 16);
  settings.criterion = static_cast<CutCriterion>(props.choice("cut_criterion"));
  return settings;
}

ProductMethod::Settings read_product_settings(const Properties& props,
                                              const PointLightOptions& options) {
  ProductMethod::Settings settings;
  settings.cells = props.integer("cut_size", 1, 1 << 20);
  settings.max_geometry_term = options.max_geometry_term;
  ProductSettings& sampling = settings.sampling;
  sampling.rays_per_pixel = props.real("rays_per_pixel");
  if (!(sampling.rays_per_pixel >= 0 && sampling.rays_per_pixel <= kMaxRaysPerPixel)) {
    throw props.error("rays_per_pixel",
                      "must be from 0 to 1e12, got " + format_number(props.real("rays_per_pixel")));
  }
  sampling.diagnostics = props.boolean("diagnostics");
  sampling.length = PathLength(props);
  if (!options.local) sampling.length.max_depth = std::min(sampling.length.max_depth, 2u);
  sampling.hide_emitters = options.hide_emitters;
  sampling.control_variate = props.boolean("control_variate");
  sampling.learned_sigma = props.boolean("learned_sigma");
  sampling.checked_sigma = props.boolean("checked_sigma");
  sampling.adaptive = props.boolean("adaptive");
  sampling.smooth_plan = props.boolean("smooth_plan");
  sampling.horizon_terms = props.boolean("horizon_terms");
  sampling.shared_candidates = props.boolean("shared_candidates");
  sampling.fewer_cells = props.boolean("fewer_cells");
  sampling.light_guide = props.boolean("light_guide");
  sampling.trial = props.boolean("trial");
  return settings;
}

class Clustered final : public GroupingIntegrator {
 public:
  explicit Clustered(const Properties& props) : points_(read_point_light_parameters(props)) {
    const auto importance = static_cast<size_t>(props.choice("importance"));
    const bool is_product = importance == std::size(kThesisImportances);
    thesis_ = read_thesis_settings(
        props, is_product ? make_joint_importance : kThesisImportances[importance]);
    const ProductMethod::Settings product = read_product_settings(props, points_.options);
    if (product.sampling.diagnostics && !is_product) {
      throw props.error("diagnostics", "requires importance 'product'");
    }
    if (is_product) product_ = product;
  }

  const char* default_indirect_emitter() const override { return indirect_emitter(points_); }

  std::vector<Stage> stages() const override {
    return {std::begin(kClusteredStages), std::end(kClusteredStages)};
  }

  std::vector<std::vector<std::string>> layers() const override {
    const std::vector<std::string> groups = light_groups().channels();
    if (!has_diagnostics()) return {groups};
    return {groups, {std::begin(kProductChannels), std::end(kProductChannels)}};
  }

  void check_light_groups(const LightGroups& groups,
                          std::span<const Emitter* const> emitters) const override {
    if (!product_) groups.fail("requires importance 'product' of 'clustered'");
    if (ProductMethod::is_for_light_points(*product_, emitters)) {
      groups.fail(
          "isn't supported by 'clustered' with max_geometry_term, or if indirect emitters are "
          "restricted to some emitters: both require light points");
    }
  }

  void set_light_groups(LightGroups groups) override {
    product_->sampling.groups = groups;
    GroupingIntegrator::set_light_groups(std::move(groups));
  }

  bool gives_samples() const override { return !product_; }
  bool traces_media() const override { return product_.has_value(); }

  void warn_of_ignored_light(const Scene& scene, const Sensor& sensor,
                             RenderContext& context) const override {
    if (has_media(scene)) return transport::warn_of_media(scene, sensor);
    // Renders by light points end after one bounce.
    const bool has_all =
        product_ && points_.options.local && ProductMethod::serves(*product_, scene);
    if (!has_all) kinome::warn_of_ignored_light(points_, scene, sensor, context);
  }

  std::unique_ptr<Passes> begin(const Scene& scene, const Sensor& sensor, RenderContext& context,
                                double seconds) const override {
    auto passes = method(scene, sensor, context, true)->begin(scene, sensor, context, seconds);
    return passes ? std::move(passes) : Integrator::begin(scene, sensor, context, seconds);
  }

  void render(const Scene& scene, const Sensor& sensor, RenderContext& context) const override {
    method(scene, sensor, context)->render(scene, sensor, context);
  }

  std::vector<Inspection> inspect(const Scene& scene, const Sensor& sensor, RenderContext& context,
                                  const Vec2& film_position) const override {
    if (points_.options.max_depth < 2) {
      throw Error(points_.where, "cannot inspect: max_depth must be at least 2, or -1");
    }
    return method(scene, sensor, context)
        ->inspect(scene, sensor, context, static_cast<int>(film_position.x),
                  static_cast<int>(film_position.y));
  }

 private:
  bool has_media(const Scene& scene) const { return product_ && !scene.media().empty(); }
  bool has_diagnostics() const { return product_ && product_->sampling.diagnostics; }

  std::unique_ptr<const ClusteredMethod> method(const Scene& scene, const Sensor& sensor,
                                                RenderContext& context,
                                                bool is_progressive = false) const {
    if (has_media(scene)) {
      return std::make_unique<MediaMethod>(
          PathSettings{product_->sampling.length, product_->sampling.hide_emitters},
          product_->sampling.trial, light_groups());
    }
    if (product_ && points_.options.max_depth >= 2) {
      auto product = ProductMethod::make(*product_, scene, sensor, context, is_progressive);
      if (product) return product;
    }
    if (!light_groups().is_empty()) return path_method(context);
    return std::make_unique<ThesisMethod>(points_, thesis_, has_diagnostics());
  }

  /// Returns the method for light groups of scenes that 'product' doesn't support.
  std::unique_ptr<const ClusteredMethod> path_method(RenderContext& context) const {
    const PathSettings paths{product_->sampling.length, product_->sampling.hide_emitters};
    report_method(context, "path",
                  "product sampling doesn't support the scene, and light points aren't divided by "
                  "light group");
    return std::make_unique<PathMethod>(paths, light_groups());
  }

  PointLightSettings points_;
  ThesisSettings thesis_;
  std::optional<ProductMethod::Settings> product_;  ///< nullopt unless importance is 'product'
};

}  // namespace

KINOME_PLUGIN(Clustered, Category::kIntegrator, "clustered",
              "Light after any number of bounces by clustered importance sampling (Åkerlund 2008): "
              "light in clusters, whose visibility is learned; or as in the thesis, after one "
              "bounce, by a cut through a tree of light points and an importance function over it "
              "for each shading point.",
              kParameters);
