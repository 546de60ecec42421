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
#include "clustered/points/thesis_method.h"
#include "clustered/product/product_sampling.h"
#include "kinome/log.h"
#include "kinome/plugin.h"

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

class Clustered final : public Integrator {
 public:
  explicit Clustered(const Properties& props) : settings_(read_point_light_parameters(props)) {
    thesis_.options = settings_.options;
    thesis_.cut_size = props.integer("cut_size", 1, 1 << 20);
    thesis_.emitter_samples = props.integer("emitter_samples", 1, 1 << 20);
    thesis_.brdf_samples = props.integer("brdf_samples", 0, 1 << 16);
    static constexpr const char* kImportances[] = {"joint", "luminance", "brdf", "product"};
    const int importance = props.choice("importance", kImportances);
    is_product_ = importance == 3;
    thesis_.importance = is_product_ ? Importance::kJoint : static_cast<Importance>(importance);
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
    thesis_.criterion = static_cast<CutCriterion>(props.choice("cut_criterion", kCriteria));
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
    ThesisMethod(thesis_).render(gather(settings_, scene, context), scene, sensor, context);
  }

  std::vector<Inspection> inspect(const Scene& scene, const Sensor& sensor, RenderContext& context,
                                  const Vec2& film_position) const override {
    if (settings_.options.max_depth < 2) {
      throw Error(settings_.where, "there is no light to choose where max_depth is less than 2");
    }
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
    return ThesisMethod(thesis_).inspect(gather(settings_, scene, context), scene, sensor, context,
                                         x, y);
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
    const uint32_t count =
        alone ? thesis_.cut_size : std::min(thesis_.cut_size, kMostCellsBesideOthers);
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

  PointLightSettings settings_;
  ThesisSettings thesis_;
  ProductSettings product_;
  bool is_product_ = false;
};

}  // namespace

KINOME_PLUGIN(Clustered, Category::kIntegrator, "clustered",
              "Direct light and one bounce by clustered importance sampling (Åkerlund 2008): a cut "
              "through a tree of light points, and an importance function over it for each "
              "shading point.",
              kParameters);
