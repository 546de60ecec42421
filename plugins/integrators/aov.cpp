/// Arbitrary output variables: properties of the first hit, as additional channels of the image.
/// Each nested integrator adds the channels NAME.R, .G, .B and .A, unless there are light groups
/// alone. The first one also renders the film's colour, which is black without nested integrators.
/// Channels are filtered like colour; rays that hit nothing count as 0. `aovs` lists name:type
/// pairs. Channels have Mitsuba's names: NAME.T for a depth, NAME.X, .Y, .Z for a vector and so on.
/// The names variance, tile_variance, noisy, denoised, lights and those that begin with Crypto are
/// reserved for other channels.
/// The pairs crypto:object and crypto:material add the layers CryptoObject and CryptoMaterial:
/// mattes in the format Cryptomatte, with the ids of the scene file as names. The guides for
/// denoisers, which Mitsuba doesn't have, describe what mirrors and glass show: see
/// transport/camera/guides.h. If all channels are guides, they have at most 8 samples per pixel and
/// pass. `light_groups` divides the colour of the first nested integrator by emitters: see
/// docs/light-groups.md.
///
///     <integrator type="aov">
///       <string name="aovs" value="depth:depth,n:sh_normal,albedo:albedo"/>
///       <integrator type="direct"/>
///     </integrator>

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "cryptomatte.h"
#include "ignored_parameters.h"
#include "kinome/block_points.h"
#include "kinome/primary_rays.h"
#include "nesting.h"
#include "reserved_names.h"
#include "transport/blocks/blocks_of_tile.h"
#include "transport/camera/camera.h"
#include "transport/camera/film_samples.h"
#include "transport/camera/guides.h"
#include "transport/camera/next_rays.h"

namespace kinome {
namespace {

constexpr Parameter kTable[] = {
    kIgnoredHideEmitters,
    {"aovs", ParameterType::kString, nullptr,
     "NAME:TYPE pairs, separated by commas or spaces; types: albedo, depth, position, uv, "
     "geo_normal, sh_normal, dp_du, dp_dv, duv_dx, duv_dy, prim_index, shape_index (from 1); "
     "guide_albedo, guide_normal: of the first rough surface behind mirrors and smooth glass, for "
     "denoisers. crypto:object and crypto:material add layers of Cryptomatte. Required unless "
     "there are light_groups."},
    {"light_groups", ParameterType::kString, nullptr,
     "Groups of emitters, as 'NAME: ID ID; NAME: ID', by ids of emitters or of their shapes; or "
     "'all' for a group of each emitter that has an id. Light of each group adds the channels "
     "lights.NAME.R, .G and .B. All other emitters are the group 'rest', so that the groups add up "
     "to the image. The first nested integrator must be clustered, path, direct, volpath or "
     "volpathmis."},
    {"crypto_depth", ParameterType::kInteger, "6", "ids per pixel of Cryptomatte layers, even"},
    {"crypto_samples", ParameterType::kInteger, nullptr,
     "camera rays per pixel for Cryptomatte layers, fewer if they take half of a time limit; "
     "default: as many as the image has samples, between 4 and 16; with a time limit, at most 16 "
     "in a tenth of the time"},
    {"integrator", ParameterType::kObject, nullptr,
     "Integrators that render the colour channels; each gets channels of its own.", false,
     Category::kIntegrator, 16},
};

/// Maximum number of samples per pixel and pass if there are guides only. Denoisers remove the
/// noise of guides, which is far below that of the colour.
constexpr uint32_t kMaxGuideSamples = 8;

struct SurfaceHit {
  SurfaceInteraction si;
  uint32_t shape;
  float depth;  ///< distance from the camera's near plane, as in Mitsuba
  Vec2 duv_dx;  ///< 0 unless needed, like duv_dy
  Vec2 duv_dy;
};

struct Type {
  const char* name;
  const char* suffixes;  ///< suffixes of the channels, one letter each
  Vec3 (*value)(const SurfaceHit&);  ///< nullptr for values of `guide`
  bool needs_next_rays = false;
  const Columns3& (transport::Guides::*guide)() const = nullptr;
};

/// Shape indices start at 1, as in Mitsuba: 0 is the background.
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
    {"duv_dx", "UV", [](const SurfaceHit& hit) { return Vec3(hit.duv_dx, 0); }, true},
    {"duv_dy", "UV", [](const SurfaceHit& hit) { return Vec3(hit.duv_dy, 0); }, true},
    {"albedo", "RGB", [](const SurfaceHit& hit) { return hit.si.shape->bsdf().albedo(hit.si); }},
    {"guide_albedo", "RGB", nullptr, false, &transport::Guides::albedo},
    {"guide_normal", "XYZ", nullptr, false, &transport::Guides::normal},
};

/// Returns the difference in uv between the point and the intersection of `ray` with its tangent
/// plane. Returns 0 if the surface has no parametrisation or the ray misses the plane.
Vec2 uv_offset(const SurfaceInteraction& si, const Ray& ray) {
  const float t = glm::dot(si.n, si.p - ray.o) / glm::dot(si.n, ray.d);
  const Vec3 offset = ray.o + t * ray.d - si.p;
  // Least squares, because the tangents needn't be perpendicular.
  const float uu = glm::dot(si.dp_du, si.dp_du), uv = glm::dot(si.dp_du, si.dp_dv),
              vv = glm::dot(si.dp_dv, si.dp_dv);
  const float u = glm::dot(si.dp_du, offset), v = glm::dot(si.dp_dv, offset);
  const Vec2 result = Vec2(vv * u - uv * v, uu * v - uv * u) / (uu * vv - uv * uv);
  return is_finite(Vec3(result, 0)) ? result : Vec2(0);
}

/// Splits a list at commas and white space.
std::vector<std::string_view> items_of(std::string_view list) {
  constexpr std::string_view kSeparators = ", \t\r\n";
  std::vector<std::string_view> items;
  for (size_t at = 0; (at = list.find_first_not_of(kSeparators, at)) != std::string_view::npos;) {
    const size_t end = std::min(list.find_first_of(kSeparators, at), list.size());
    items.push_back(list.substr(at, end - at));
    at = end;
  }
  return items;
}

const Type& find_type(const Properties& props, const std::string& name) {
  std::vector<std::string> names;
  for (const Type& type : kTypes) {
    if (name == type.name) return type;
    names.emplace_back(type.name);
  }
  throw props.error(
      "aovs", "has the unknown type '" + name + "'" + did_you_mean(nearest_name(name, names)));
}

/// Returns the kind of Cryptomatte that a pair names; nullopt for other pairs.
std::optional<CryptomatteKind> kind_of(std::string_view item) {
  if (item == "crypto:object") return CryptomatteKind::kObject;
  if (item == "crypto:material") return CryptomatteKind::kMaterial;
  return std::nullopt;
}

/// State of one thread.
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
    const bool needs_next_rays = std::any_of(types.begin(), types.end(), [](const Type* type) {
      return type->needs_next_rays;
    });
    if (needs_next_rays) {
      // Distance between a pixel's samples, as in Mitsuba.
      const float distance =
          1 / std::sqrt(static_cast<float>(std::max(1u, sensor.sampler().sample_count())));
      next_.emplace(sensor, distance, transport::kBlockSamples);
    }
    const bool needs_guides = std::any_of(types.begin(), types.end(),
                                          [](const Type* type) { return type->guide != nullptr; });
    if (needs_guides) guides_.emplace(scene, sensor, transport::kBlockSamples);
  }

  void render(const PixelSamples& samples, Tile& tile) {
    const StageTimer timer(tile.counters.stage_seconds["aov"]);
    camera_.trace(samples, tile.counters);
    if (next_) next_->find(camera_.film_position(), camera_.aperture(), samples.count());
    for (float* column : values_) std::fill_n(column, samples.count(), 0.f);
    for (const transport::Surfaces::Range& range : camera_.surfaces().ranges()) {
      for (size_t i = range.first; i < range.first + range.count; ++i) fill(i);
    }
    if (guides_) fill_guides(samples, tile.counters);
    film_.add(samples, camera_.film_position(), values_, tile.film);
  }

 private:
  /// Sets the values of the point's ray.
  void fill(size_t point) {
    const SurfaceBlock& points = camera_.surfaces().points();
    const uint32_t ray = points.ray[point];
    const RayHit16& rays = camera_.rays()[ray / kBlockLanes];
    SurfaceHit hit{interaction_of(points, point), rays.shape[ray % kBlockLanes],
                   camera_.depth(ray), Vec2(0), Vec2(0)};
    if (next_) {
      const Ray own = ray_of(&rays.ray, ray % kBlockLanes);
      hit.duv_dx = uv_offset(hit.si, next_->at(ray, own, 0));
      hit.duv_dy = uv_offset(hit.si, next_->at(ray, own, 1));
    }
    size_t at = 0;
    for (const Type* type : types_) {
      if (!type->value) {
        at += std::string_view(type->suffixes).size();
        continue;
      }
      const Vec3 value = type->value(hit);
      for (int c = 0; type->suffixes[c] != 0; ++c) values_[at++][ray] = value[c];
    }
  }

  /// Sets the values of all rays that come from the guides.
  void fill_guides(const PixelSamples& samples, RenderCounters& counters) {
    guides_->find(camera_, samples, counters);
    size_t at = 0;
    for (const Type* type : types_) {
      if (type->guide) {
        const Columns3& guide = ((*guides_).*type->guide)();
        const float* const columns[] = {guide.x, guide.y, guide.z};
        for (size_t c = 0; c < 3; ++c) std::copy_n(columns[c], samples.count(), values_[at + c]);
      }
      at += std::string_view(type->suffixes).size();
    }
  }

  const std::vector<const Type*>& types_;
  transport::Camera camera_;
  transport::FilmSamples film_;
  transport::Arena arena_;
  std::vector<float*> values_;
  std::optional<transport::NextRays> next_;
  std::optional<transport::Guides> guides_;
};

class AovIntegrator final : public NestingIntegrator {
 public:
  explicit AovIntegrator(const Properties& props)
      : NestingIntegrator(props),
        groups_(props, "light_groups"),
        has_copies_(groups_.is_empty() || props.has("aovs") || nested().size() > 1) {
    if (!groups_.is_empty()) grouping_ = &find_grouping(props);
    list();
    parse(props);
    constexpr int64_t kMaxLevels = 64, kMaxSamples = 4096;
    const int64_t samples =
        props.has("crypto_samples") ? props.integer("crypto_samples", 1, kMaxSamples) : 0;
    cryptomatte_ =
        Cryptomatte(kinds_, static_cast<int>(props.integer("crypto_depth", 1, kMaxLevels)),
                    static_cast<uint32_t>(samples));
    list();
    if (const auto twice = channel_named_twice()) {
      throw props.error("aovs", "names two channels '" + *twice + "'");
    }
  }

  void set_emitters(std::span<const Emitter* const> emitters) override {
    NestingIntegrator::set_emitters(emitters);
    if (groups_.is_empty()) return forget_groups();
    grouping_->check_light_groups(groups_, emitters);
    if (!groups_.set_emitters(emitters)) return;
    grouping_->set_light_groups(groups_);
    list();
    if (const auto twice = channel_named_twice()) {
      groups_.fail("adds the channel '" + *twice + "', which exists already");
    }
  }

  std::vector<Stage> stages() const override {
    std::vector<Stage> stages = NestingIntegrator::stages();
    if (layer_ >= 0) stages.push_back({"aov", "records properties of the first hits"});
    if (!cryptomatte_.is_empty()) stages.push_back({"cryptomatte", "finds the coverage of ids"});
    return stages;
  }

  void render(const Scene& scene, const Sensor& sensor, RenderContext& context) const override {
    NestingIntegrator::render(scene, sensor, context);
    render_own(scene, sensor, context);
  }

 protected:
  void render_own(const Scene& scene, const Sensor& all, RenderContext& context) const override {
    if (!cryptomatte_.is_empty()) {
      cryptomatte_.render(scene, all, context, cryptomatte_layer_);
    }
    if (layer_ < 0) return;
    const transport::SceneTable table(scene);
    const auto values = static_cast<size_t>(all.film().value_count(layer_));
    const bool has_guides_only = std::ranges::all_of(
        types_, [](const Type* type) { return type->guide != nullptr; });
    const bool takes_fewer = has_guides_only && all.sampler().sample_count() > kMaxGuideSamples;
    const auto fewer = takes_fewer ? all.with_sample_count(kMaxGuideSamples) : nullptr;
    const Sensor& sensor = fewer ? *fewer : all;
    transport::render_tiles<AovWorker>(
        sensor, context, layer_,
        [&] { return std::make_unique<AovWorker>(table, sensor, types_, values); },
        [](AovWorker& worker, const PixelSamples& samples, Tile& tile) {
          worker.render(samples, tile);
        });
  }

 private:
  void list_channels() override {
    for (const Nested& nested : this->nested()) {
      if (!has_copies_) break;
      add_color(nested, {{"R", FilmChannel::kR},
                         {"G", FilmChannel::kG},
                         {"B", FilmChannel::kB},
                         {"A", FilmChannel::kA}});
    }
    for (const Nested& nested : this->nested()) add_channels_of(nested);
    layer_ = add_channels(names_);
    cryptomatte_layer_ = add_channels(cryptomatte_.channels());
  }

  /// Returns the integrator that renders the film's colour. Throws Error if it can't divide light
  /// by group.
  GroupingIntegrator& find_grouping(const Properties& props) const {
    if (nested().empty()) throw props.error("light_groups", "requires a nested integrator");
    Integrator* const first = nested()[0].integrator.get();
    if (auto* const grouping = dynamic_cast<GroupingIntegrator*>(first)) return *grouping;
    throw props.error("light_groups", "requires 'clustered', 'path', 'direct', 'volpath' or "
                                      "'volpathmis' as the first nested integrator: '" +
                                          first->plugin() + "' renders no light groups");
  }

  /// Removes the light groups of the nested integrator. It has some if an edit of the scene removed
  /// them from this integrator.
  void forget_groups() {
    if (nested().empty()) return;
    auto* const first = dynamic_cast<GroupingIntegrator*>(nested()[0].integrator.get());
    if (!first || first->layers()[0].empty()) return;
    first->set_light_groups({});
    list();
  }

  std::optional<std::string> channel_named_twice() const {
    std::set<std::string> names;
    for (const FilmChannel& channel : channels()) {
      if (!names.insert(channel.name).second) return channel.name;
    }
    return std::nullopt;
  }

  /// Adds a layer with these channels. Returns its number, or -1 if `names` is empty.
  int add_channels(const std::vector<std::string>& names) {
    if (names.empty()) return -1;
    const int layer = add_layer(names);
    for (size_t i = 0; i < names.size(); ++i) add_channel({names[i], layer, static_cast<int>(i)});
    return layer;
  }

  /// Sets types_, kinds_ and names_.
  void parse(const Properties& props) {
    if (!groups_.is_empty() && !props.has("aovs")) return;
    const std::string list = props.string("aovs");
    for (const std::string_view item : items_of(list)) {
      const size_t colon = item.find(':');
      const std::string name(item.substr(0, colon));
      if (colon >= item.size() - 1 || name.empty()) {
        throw props.error("aovs", "must be NAME:TYPE pairs with commas between them, got '" +
                                      std::string(item) + "'");
      }
      if (const auto kind = kind_of(item)) {
        if (std::find(kinds_.begin(), kinds_.end(), *kind) != kinds_.end()) {
          throw props.error("aovs", "names '" + std::string(item) + "' twice");
        }
        kinds_.push_back(*kind);
        continue;
      }
      const Type& type = find_type(props, std::string(item.substr(colon + 1)));
      if (is_reserved(name)) {
        throw props.error("aovs", "must not use the name '" + name +
                                      "', which is reserved for other channels of the image");
      }
      types_.push_back(&type);
      for (const char suffix : std::string_view(type.suffixes)) {
        names_.push_back(name + "." + suffix);
      }
    }
    if (names_.empty() && kinds_.empty()) {
      throw props.error("aovs", "must be NAME:TYPE pairs, got none");
    }
  }

  LightGroups groups_;
  /// False if the image's channels show all colours, so that the nested integrators need no copies.
  bool has_copies_;
  GroupingIntegrator* grouping_ = nullptr;  ///< nullptr without groups
  std::vector<const Type*> types_;
  std::vector<std::string> names_;  ///< channels of types_
  int layer_ = -1;
  std::vector<CryptomatteKind> kinds_;
  Cryptomatte cryptomatte_{{}, 0, 0};
  int cryptomatte_layer_ = -1;
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::AovIntegrator, kinome::Category::kIntegrator, "aov",
              "Properties of the first hit (depth, normals, albedo, …) as separate channels.",
              kinome::kTable);
