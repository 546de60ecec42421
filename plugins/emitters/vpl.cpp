/// One bounce of other emitters' light as virtual point lights (Keller 1997; Åkerlund 2008, 3.4.2).
/// These are illuminated points of the scene's surfaces, from which the integrators `clustered` and
/// `groundtruth` render. Other integrators trace the bounce themselves; for them, only the nested
/// emitters matter, which are ordinary emitters of the scene.
///
/// Surfaces reflect by their diffuse and glossy lobes. Light that arrives via a mirror makes no
/// points.
///
///     <emitter type="vpl">
///       <string name="placement" value="traced"/>
///       <emitter type="spot"> ... </emitter>
///     </emitter>

#include <algorithm>
#include <string>
#include <vector>

#include "kinome/clustered_light.h"
#include "kinome/log.h"
#include "kinome/wide/owen.h"
#include "kinome/plugin.h"
#include "kinome/render_context.h"
#include "kinome/scene.h"

namespace kinome {
namespace {

constexpr int kMaxChildren = 1 << 20;

constexpr const char* kPlacements[] = {"surface", "traced"};

constexpr Parameter kTable[] = {
    {"emitter", ParameterType::kObject, nullptr,
     "Emitters whose bounce is computed; default: all emitters of the scene.", false,
     Category::kEmitter, kMaxChildren},
    choice_of(
        "placement", kPlacements, "surface",
        "'surface': uniform over all surfaces; 'traced': where light traced from the emitters "
        "hits surfaces."),
    {"light_samples", ParameterType::kInteger, "0",
     "Number of candidates: positions on surfaces ('surface') or light rays ('traced'). "
     "Those that receive and reflect light become points. 0: the integrator's light_samples."},
};

/// Number of candidates that one thread processes together.
constexpr uint32_t kChunk = 1024;
/// Maximum number of emitters that illuminate a position. If there are more, as many are chosen at
/// random.
constexpr size_t kMaxEmittersPerPosition = 8;

/// Light that arrives at a surface point, for reflection in any direction.
struct Reflection {
  SurfaceInteraction si;
  Vec3 to_light;      ///< in the shading frame
  Rgb incident{0.f};  ///< radiance x solid angle x area of the point
  bool lambertian;    ///< if true, `radiance` describes the reflection completely
  Rgb radiance{0.f};  ///< reflected radiance x area
};

class SurfacePoints final : public PointEmission {
 public:
  explicit SurfacePoints(std::vector<Reflection> points) : points_(std::move(points)) {}
  Rgb intensity(uint32_t id, const Vec3& d) const override {
    const Reflection& point = points_[id];
    const float cosine = std::abs(glm::dot(point.si.n, d));
    if (point.lambertian) return point.radiance * cosine;
    SurfaceInteraction si = point.si;
    si.wi = si.frame.to_local(d);
    const BsdfValue value =
        si.shape->bsdf().eval_pdf(si, Lobe::kDiffuse | Lobe::kGlossy, point.to_light);
    return value.f * point.incident * cosine;
  }
  Vec3 origin(uint32_t id, const Vec3& d) const override { return points_[id].si.ray_origin(d); }

 private:
  std::vector<Reflection> points_;
};

/// Light points, and the reflections of those that aren't Lambertian on a flat surface.
struct Points {
  uint64_t tries = 0;  ///< number of candidates
  LightPoints lights;
  std::vector<Reflection> reflections;
  RenderCounters counters;

  /// Adds a point with light from the direction `d`; `incident` is radiance x solid angle x area.
  void add(const SurfaceInteraction& si, const Vec3& d, const Rgb& incident, float area) {
    Reflection point{si, si.frame.to_local(d), incident, si.shape->bsdf().is_lambertian(), {}};
    const float side = point.to_light.z >= 0 ? 1.f : -1.f;
    // The reflectance is evaluated for a viewer on the light's side.
    point.si.wi = Vec3(0, 0, side);
    const Bsdf& bsdf = si.shape->bsdf();
    if (point.lambertian) {
      point.radiance = bsdf.eval_pdf(point.si, Lobe::kDiffuse, point.to_light).f * incident;
    } else {
      const LobeReflectance part = bsdf.reflectance(point.si);
      point.radiance =
          (part.diffuse + part.glossy) * kInvPi * std::abs(point.to_light.z) * incident;
    }
    if (is_black(point.radiance)) return;
    // Offset from the surface, because grazing rays would otherwise hit it just before their end.
    lights.position.push_back(si.ray_origin(d));
    // The shading normal, because that of reflection_frame may depend on the viewer.
    lights.normal.push_back(si.frame.n * side);
    lights.power.push_back(point.radiance);
    lights.extent.push_back(area);
    const bool flat = std::abs(glm::dot(si.n, si.frame.n)) > 1 - 1e-6f;
    const bool simple = point.lambertian && flat;
    lights.emission_id.push_back(simple ? LightPoints::kLambertian
                                        : static_cast<uint32_t>(reflections.size()));
    if (!simple) reflections.push_back(point);
  }
};

/// Joins the points in the order of the chunks, independent of threads.
LightPoints join(std::vector<Points>& chunks, RenderCounters& counters) {
  LightPoints all;
  all.kind = LightPoints::Kind::kLocal;
  std::vector<Reflection> reflections;
  for (Points& chunk : chunks) {
    const auto first = static_cast<uint32_t>(reflections.size());
    for (uint32_t& id : chunk.lights.emission_id) {
      if (id != LightPoints::kLambertian) id += first;
    }
    all.append(chunk.lights);
    reflections.insert(reflections.end(), chunk.reflections.begin(), chunk.reflections.end());
    counters.add(chunk.counters);
    chunk = {};
  }
  if (reflections.empty()) {
    all.emission_id.clear();
  } else {
    all.emission = std::make_shared<SurfacePoints>(std::move(reflections));
  }
  return all;
}

/// Random numbers of candidate i for a `purpose`: Owen-scrambled Sobol points.
Vec2 random_numbers(uint64_t seed, uint32_t purpose, uint64_t stream, uint32_t i) {
  const uint64_t key = hash_words(seed, purpose, stream, 0x76706cu);
  // Each purpose has its own order. Otherwise all purposes would use the same point of the
  // sequence, and each position would always see the same part of an emitter.
  return owen_sobol_point(owen_scramble(i, hash_words(key, 2)), key, hash_words(key, 1));
}
enum Purpose : uint32_t { kShapeChoice, kPosition, kLight, kEmitterChoice, kOrigin, kDirection };

/// Illuminates positions that are uniform over the surfaces.
class SurfacePlacement {
 public:
  SurfacePlacement(const Scene& scene, const std::vector<const Emitter*>& emitters, uint32_t count,
                   uint64_t seed)
      : scene_(scene), emitters_(emitters), count_(count), seed_(seed) {
    double area = 0;
    for (const auto& shape : scene.shapes()) {
      if (!any(shape->bsdf().lobes() & (Lobe::kDiffuse | Lobe::kGlossy))) continue;
      shapes_.push_back(shape.get());
      first_.push_back(area);
      area += shape->area();
    }
    area_ = area;
    // Systematic sampling, which spreads positions over the shapes as evenly as possible.
    offset_ = random_numbers(seed, kShapeChoice, 0, 0).x;
  }
  bool empty() const { return !(area_ > 0); }

  void light(uint32_t begin, uint32_t end, Points& out) const {
    std::vector<Ray> rays;
    std::vector<Arrival> arrivals;
    for (uint32_t i = begin; i < end; ++i) {
      const SurfaceInteraction si = position(i);
      const size_t used = std::min(emitters_.size(), kMaxEmittersPerPosition);
      const float weight = static_cast<float>(emitters_.size()) / static_cast<float>(used);
      out.tries += used;
      for (size_t k = 0; k < used; ++k) {
        const size_t e = used == emitters_.size() ? k : random_emitter(i, k);
        const auto light = emitters_[e]->sample_direct(si.p, random_numbers(seed_, kLight, e, i));
        if (!light || is_black(light->radiance)) continue;
        const bool is_own = emitters_[e]->shape() == si.shape;
        if (is_own && !si.resolves(light->d, light->distance)) continue;
        const float point_area = static_cast<float>(area_ / count_);
        rays.push_back(si.shadow_ray(light->d, light->distance));
        arrivals.push_back(
            {si, light->d, light->radiance * (weight * point_area / light->pdf), point_area});
      }
    }
    scene_.occluded(rays, Coherence::kIncoherent, out.counters);
    out.counters[RayKind::kLight] += rays.size();
    for (size_t k = 0; k < rays.size(); ++k) {
      const Arrival& a = arrivals[k];
      if (!rays[k].is_occluded()) out.add(a.si, a.d, a.incident, a.area);
    }
  }

 private:
  struct Arrival {
    SurfaceInteraction si;
    Vec3 d;
    Rgb incident;
    float area;
  };

  SurfaceInteraction position(uint32_t i) const {
    const double at = (i + offset_) / count_ * area_;
    const auto after = std::upper_bound(first_.begin(), first_.end(), at);
    const auto s = static_cast<size_t>(after - first_.begin()) - 1;
    SurfaceInteraction si = shapes_[s]->sample_surface(random_numbers(seed_, kPosition, s, i));
    si.shape = shapes_[s];
    return si;
  }
  size_t random_emitter(uint32_t i, size_t k) const {
    const float u = random_numbers(seed_, kEmitterChoice, k, i).x;
    const float share = (static_cast<float>(k) + u) / kMaxEmittersPerPosition;
    return std::min(static_cast<size_t>(share * static_cast<float>(emitters_.size())),
                    emitters_.size() - 1);
  }

  const Scene& scene_;
  const std::vector<const Emitter*>& emitters_;
  const uint32_t count_;
  const uint64_t seed_;
  std::vector<const Shape*> shapes_;
  std::vector<double> first_;  ///< total area of the shapes before each
  double area_ = 0;
  double offset_ = 0;
};

/// Illuminates positions where rays from the emitters hit surfaces.
class TracedPlacement {
 public:
  TracedPlacement(const Scene& scene, const std::vector<const Emitter*>& emitters, uint32_t count,
                  uint64_t seed)
      : scene_(scene), emitters_(emitters), count_(count), seed_(seed) {}

  void light(uint32_t begin, uint32_t end, Points& out) const {
    std::vector<EmissionSample> samples;
    std::vector<RayHit> rays;
    const auto emitters = static_cast<uint32_t>(emitters_.size());
    out.tries = end - begin;
    for (uint32_t i = begin; i < end; ++i) {
      // Each emitter in turn. The last round may omit some, with the same probability for all.
      const uint32_t e = (i + shift()) % emitters;
      const auto sample =
          emitters_[e]->sample_emission(random_numbers(seed_, kOrigin, e, i / emitters),
                                        random_numbers(seed_, kDirection, e, i / emitters));
      if (!sample || is_black(sample->power)) continue;
      rays.push_back({sample->ray(), Hit{}});
      samples.push_back(*sample);
    }
    scene_.intersect(rays, Coherence::kIncoherent, out.counters);
    out.counters[RayKind::kLight] += rays.size();
    for (size_t k = 0; k < rays.size(); ++k) {
      if (rays[k].hit.valid()) add_hit(samples[k], rays[k], out);
    }
  }

 private:
  uint32_t shift() const { return static_cast<uint32_t>(hash_words(seed_, kEmitterChoice)) >> 8; }

  void add_hit(const EmissionSample& sample, const RayHit& ray, Points& out) const {
    const SurfaceInteraction si = scene_.interaction(ray);
    const float cosine = std::abs(glm::dot(si.n, sample.d));
    if (!(cosine > 0)) return;
    const float share = static_cast<float>(emitters_.size()) / static_cast<float>(count_);
    const float distance2 = sqr(ray.ray.tmax);
    // The point represents an area that is the inverse of the density of rays.
    const float density =
        sample.pdf_position > 0 ? sample.pdf_position : sample.pdf_direction / distance2;
    const float area = share / (density * cosine);
    if (!(area > 0) || !std::isfinite(area)) return;
    // Flux is radiance x cosine x solid angle x area.
    out.add(si, -sample.d, sample.power * (share / cosine), area);
  }

  const Scene& scene_;
  const std::vector<const Emitter*>& emitters_;
  const uint32_t count_;
  const uint64_t seed_;
};

class VirtualPointLights final : public Emitter, public ClusteredLight {
 public:
  explicit VirtualPointLights(const Properties& props)
      : where_(props.where()), children_(props.objects<Emitter>()) {
    for (const auto& child : children_) {
      if (child->is_indirect()) throw props.error("emitter", "must not be another 'vpl'");
    }
    traced_ = props.choice("placement") == 1;
    count_ = props.integer("light_samples", 0, 1 << 24);
  }

  bool is_indirect() const override { return true; }
  std::vector<std::shared_ptr<Emitter>> children() const override { return children_; }
  std::optional<DirectSample> sample_direct(const Vec3& /*p*/, const Vec2& /*u*/) const override {
    return std::nullopt;
  }

  std::optional<LightPoints> light_points(const Scene& scene, RenderContext& context,
                                          uint32_t requested) const override {
    std::vector<const Emitter*> emitters;
    for (const auto& child : children_) emitters.push_back(child.get());
    if (emitters.empty()) emitters = scene.emitters();
    if (emitters.empty()) {
      context.job.skip("indirect light", "the scene has no emitters");
      return std::nullopt;
    }
    const uint32_t count = count_ > 0 ? count_ : requested;
    LightPoints points;
    if (traced_) {
      points =
          light_all(TracedPlacement(scene, emitters, count, context.job.seed()), count, context);
    } else {
      const SurfacePlacement placement(scene, emitters, count, context.job.seed());
      if (placement.empty()) {
        return warn_no_points("no surface has a diffuse or glossy lobe", context);
      }
      points = light_all(placement, count, context);
    }
    if (points.size() == 0) {
      return warn_no_points("no light was found that arrives at a reflecting surface", context);
    }
    return points;
  }

 private:
  /// The warning describes the image, because integrators add this emitter without the user's
  /// doing.
  std::optional<LightPoints> warn_no_points(const std::string& why, RenderContext& context) const {
    log_warn(Error(where_, why + ": the image shows direct light only").what());
    context.job.skip("indirect light", why);
    return std::nullopt;
  }

  template <class Placement>
  LightPoints light_all(const Placement& placement, uint32_t count, RenderContext& context) const {
    std::vector<Points> chunks((count + kChunk - 1) / kChunk);
    context.scheduler.parallel_for(chunks.size(), [&](size_t c) {
      const auto begin = static_cast<uint32_t>(c) * kChunk;
      placement.light(begin, std::min(begin + kChunk, count), chunks[c]);
    });
    uint64_t tries = 0;
    for (const Points& chunk : chunks) tries += chunk.tries;
    LightPoints points = join(chunks, context.job.stats().counters);
    if (points.size() < tries) {
      context.job.skip("unlit light points",
                       std::to_string(tries - points.size()) + " of " + std::to_string(tries));
    }
    return points;
  }

  Location where_;
  std::vector<std::shared_ptr<Emitter>> children_;
  bool traced_ = false;
  uint32_t count_ = 0;
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(
    kinome::VirtualPointLights, kinome::Category::kEmitter, "vpl",
    "One bounce of other emitters' light as virtual point lights. 'clustered' and 'groundtruth' "
    "with a max_depth of at least 3 add one if the scene has none.",
    kinome::kTable);
