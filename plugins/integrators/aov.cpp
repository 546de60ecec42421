/// Arbitrary output variables: what the first hit is, as further channels of the image, beside what
/// a nested integrator renders (without one, colour stays black). Channels are filtered as colour
/// is; rays that hit nothing count as 0. `aovs` lists name:type pairs; channels are named as
/// Mitsuba names them, NAME.T for a depth, NAME.X, .Y, .Z for a vector and so on.
///
///     <integrator type="aov">
///       <string name="aovs" value="depth:depth,n:sh_normal,albedo:albedo"/>
///       <integrator type="direct"/>
///     </integrator>

#include <algorithm>
#include <array>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "kinome/block_points.h"
#include "kinome/integrator.h"
#include "kinome/plugin.h"
#include "kinome/primary_rays.h"
#include "transport/blocks_of_tile.h"
#include "transport/camera.h"
#include "transport/film_samples.h"

namespace kinome {
namespace {

constexpr Parameter kTable[] = {
    {"aovs", ParameterType::kString, nullptr,
     "Comma-separated NAME:TYPE pairs; types: depth, position, uv, geo_normal, sh_normal, dp_du, "
     "dp_dv, prim_index, shape_index (from 1), albedo.",
     true},
    {"integrator", ParameterType::kObject, nullptr, "What renders the colour channels.", false,
     Category::kIntegrator},
};

struct SurfaceHit {
  SurfaceInteraction si;
  uint32_t shape;
  float depth;  ///< from the camera's near plane, as in Mitsuba
};

struct Type {
  const char* name;
  const char* suffixes;  ///< of the channels, one letter each
  Vec3 (*value)(const SurfaceHit&);
};

/// Shape indices count from 1, as Mitsuba's do: 0 is the background.
constexpr Type kTypes[] = {
    {"depth", "T", [](const SurfaceHit& hit) { return Vec3(hit.depth); }},
    {"position", "XYZ", [](const SurfaceHit& hit) { return hit.si.p; }},
    {"uv", "UV", [](const SurfaceHit& hit) { return Vec3(hit.si.uv, 0); }},
    {"geo_normal", "XYZ", [](const SurfaceHit& hit) { return hit.si.n; }},
    {"sh_normal", "XYZ", [](const SurfaceHit& hit) { return hit.si.frame.n; }},
    {"dp_du", "XYZ", [](const SurfaceHit& hit) { return hit.si.dp_du; }},
    {"dp_dv", "XYZ", [](const SurfaceHit& hit) { return hit.si.dp_dv; }},
    {"prim_index", "I", [](const SurfaceHit& hit) { return Vec3(float(hit.si.primitive)); }},
    {"shape_index", "I", [](const SurfaceHit& hit) { return Vec3(float(hit.shape + 1)); }},
    {"albedo", "RGB",
     [](const SurfaceHit& hit) {
       const LobeReflectance parts = hit.si.shape->bsdf().reflectance(hit.si);
       return parts.diffuse + parts.glossy;
     }},
};

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view kSpace = " \t\r\n";
  const size_t first = text.find_first_not_of(kSpace);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kSpace) - first + 1);
}

const Type& find_type(const Properties& props, const std::string& name) {
  std::vector<std::string> names;
  for (const Type& type : kTypes) {
    if (name == type.name) return type;
    names.emplace_back(type.name);
  }
  const std::string nearest = nearest_name(name, names);
  throw props.error("aovs", "has the unknown type '" + name + "'" +
                                (nearest.empty() ? "" : " (did you mean '" + nearest + "'?)"));
}

/// What one thread works with.
class AovWorker {
 public:
  AovWorker(const transport::SceneTable& scene, const Sensor& sensor,
            const std::vector<const Type*>& types, size_t channels)
      : types_(types),
        camera_(scene, sensor, transport::kBlockSamples, false),
        film_(sensor.film().filter(), static_cast<int>(channels), transport::kBlockSamples,
              true),
        arena_(transport::kBlockSamples + kBlockLanes) {
    for (size_t i = 0; i < channels; ++i) values_.push_back(arena_.floats());
  }

  void render(const PixelSamples& samples, Tile& tile) {
    const StageTimer timer(tile.counters.stage_seconds["aov"]);
    camera_.trace(samples, tile.counters);
    for (float* column : values_) std::fill_n(column, samples.count(), 0.f);
    for (const transport::Surfaces::Range& range : camera_.surfaces().ranges()) {
      for (size_t i = range.first; i < range.first + range.count; ++i) fill(i);
    }
    film_.add(samples, camera_.film_position(), values_, tile.film);
  }

 private:
  /// The values of a point's ray.
  void fill(size_t point) {
    const SurfaceBlock& points = camera_.surfaces().points();
    const uint32_t ray = points.ray[point];
    const SurfaceHit hit{interaction_of(points, point),
                         camera_.rays()[ray / kBlockLanes].shape[ray % kBlockLanes],
                         camera_.depth(ray)};
    size_t at = 0;
    for (const Type* type : types_) {
      const Vec3 value = type->value(hit);
      for (int c = 0; type->suffixes[c] != 0; ++c) values_[at++][ray] = value[c];
    }
  }

  const std::vector<const Type*>& types_;
  transport::Camera camera_;
  transport::FilmSamples film_;
  transport::Arena arena_;
  std::vector<float*> values_;
};

class AovIntegrator final : public Integrator {
 public:
  explicit AovIntegrator(const Properties& props) : nested_(props.object<Integrator>()) {
    if (nested_) layers_ = nested_->layers();
    std::set<std::string> taken;
    for (const auto& layer : layers_) taken.insert(layer.begin(), layer.end());
    if (layers_.empty()) layers_.emplace_back();  // the film's colour
    layer_ = static_cast<int>(layers_.size());
    layers_.emplace_back();
    parse(props, taken);
  }

  std::vector<std::vector<std::string>> layers() const override { return layers_; }

  std::vector<Stage> stages() const override {
    std::vector<Stage> stages;
    if (nested_) stages = nested_->stages();
    stages.push_back({"aov", "reads off the first hits"});
    return stages;
  }

  const char* default_indirect_emitter() const override {
    return nested_ ? nested_->default_indirect_emitter() : nullptr;
  }
  std::vector<Inspection> inspect(const Scene& scene, const Sensor& sensor, RenderContext& context,
                                  const Vec2& film_position) const override {
    return nested_ ? nested_->inspect(scene, sensor, context, film_position)
                   : Integrator::inspect(scene, sensor, context, film_position);
  }
  void warn_of_light_left_out(const Scene& scene, const Sensor& sensor,
                              RenderContext& context) const override {
    if (nested_) nested_->warn_of_light_left_out(scene, sensor, context);
  }
  void render(const Scene& scene, const Sensor& sensor, RenderContext& context) const override {
    if (nested_) nested_->render(scene, sensor, context);
    const transport::SceneTable table(scene);
    transport::render_tiles<AovWorker>(
        sensor, context, layer_,
        [&] { return std::make_unique<AovWorker>(table, sensor, types_, layers_.back().size()); },
        [](AovWorker& worker, const PixelSamples& samples, Tile& tile) {
          worker.render(samples, tile);
        });
  }

 private:
  void parse(const Properties& props, std::set<std::string>& taken) {
    const std::string list = props.string("aovs");
    std::string_view rest = list;
    while (true) {
      const size_t comma = rest.find(',');
      const std::string_view item = trimmed(rest.substr(0, comma));
      const size_t colon = item.find(':');
      const std::string name(trimmed(item.substr(0, colon)));
      if (colon == std::string_view::npos || name.empty()) {
        throw props.error("aovs", "must be NAME:TYPE pairs with commas between them, got '" +
                                      std::string(item) + "'");
      }
      const Type& type = find_type(props, std::string(trimmed(item.substr(colon + 1))));
      types_.push_back(&type);
      for (const char suffix : std::string_view(type.suffixes)) {
        layers_.back().push_back(name + "." + suffix);
        if (!taken.insert(layers_.back().back()).second) {
          throw props.error("aovs", "names two channels '" + layers_.back().back() + "'");
        }
      }
      if (comma == std::string_view::npos) return;
      rest.remove_prefix(comma + 1);
    }
  }

  std::shared_ptr<Integrator> nested_;
  std::vector<const Type*> types_;
  std::vector<std::vector<std::string>> layers_;
  int layer_;
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::AovIntegrator, kinome::Category::kIntegrator, "aov",
              "What the first hit is (depth, normals, albedo, …), as channels of their own.",
              kinome::kTable);
