#include "kinome/scene.h"

#include <algorithm>
#include <functional>
#include <thread>
#include <unordered_set>

#include "kinome/error.h"
#include "scene/bounces.h"
#include "scene/scene_accelerator.h"
#include "scene/traceable.h"

namespace kinome {

namespace {

std::string describe(const Object& object, const char* kind, size_t index) {
  return object.id().empty() ? std::string(kind) + " " + std::to_string(index)
                             : std::string(kind) + " '" + object.id() + "'";
}

}  // namespace

Scene::Scene(Contents contents, unsigned threads, const Scene* before)
    : contents_(std::move(contents)) {
  replace_by_parts();
  std::vector<Emitter*> all;
  std::unordered_set<const Emitter*> known;
  const std::function<void(Emitter&, const std::string&)> add_emitter =
      [&](Emitter& emitter, const std::string& name) {
        if (!known.insert(&emitter).second) return;
        if (emitter.is_surface() && !emitter.shape()) {
          throw Error(name + " is a surface emitter: it must be part of a shape");
        }
        if (emitter.is_environment()) {
          if (environment_) {
            throw Error("a scene can have only one environment emitter, but " + name +
                        " is a second one");
          }
          environment_ = &emitter;
        }
        all.push_back(&emitter);
        for (const auto& child : emitter.children()) add_emitter(*child, "an emitter in " + name);
      };
  for (size_t i = 0; i < contents_.emitters.size(); ++i) {
    const std::string name = describe(*contents_.emitters[i], "emitter", i);
    add_emitter(*contents_.emitters[i], name);
  }
  for (size_t i = 0; i < contents_.shapes.size(); ++i) {
    const Shape& shape = *contents_.shapes[i];
    const std::string name = describe(shape, "shape", i);
    if (!shape.bsdf_pointer()) throw Error(name + " has no BSDF");
    const Aabb box = shape.bounds();
    const std::string fault = why_untraceable(box);
    if (!fault.empty()) throw Error(name + " " + fault);
    bounds_.expand(box);
    if (const auto emitter = shape.emitter_pointer()) {
      add_emitter(*emitter, name);
      has_surface_emitters_ = true;
    }
  }
  for (Emitter* emitter : all) {
    (emitter->is_indirect() ? indirect_emitters_ : emitters_).push_back(emitter);
  }
  check_bounces();
  list_media();
  if (before && before->contents_.shapes == contents_.shapes &&
      before->contents_.watertight == contents_.watertight) {
    accelerator_ = before->accelerator_;
  } else {
    if (threads == 0) threads = std::max(1u, std::thread::hardware_concurrency());
    accelerator_ = std::make_shared<const Accelerator>(contents_, placed_, threads);
  }
  // These calls come last, because objects may be shared with the previous scene: they must not
  // change if this constructor throws.
  for (const auto& sensor : contents_.sensors) sensor->set_scene_bounds(bounds_);
  for (Emitter* emitter : all) {
    if (!contents_.sensors.empty()) emitter->set_shutter(contents_.sensors.front()->shutter());
    emitter->prepare(bounds_);
  }
}

/// Replaces shapes by their parts, recursively: the parts of a merge may be instances. Meshes
/// without faces are left out.
void Scene::replace_by_parts() {
  std::vector<std::shared_ptr<Shape>> shapes;
  const std::function<void(const std::shared_ptr<Shape>&)> add = [&](const auto& shape) {
    if (has_no_surface(*shape)) return;
    const auto parts = shape->parts();
    if (const auto instance = std::dynamic_pointer_cast<const ShapeInstance>(shape)) {
      placed_.push_back({instance, static_cast<uint32_t>(shapes.size())});
      shapes.insert(shapes.end(), parts.begin(), parts.end());
    } else if (parts.empty()) {
      shapes.push_back(shape);
    } else {
      for (const auto& part : parts) add(part);
    }
  };
  for (const auto& shape : contents_.shapes) add(shape);
  contents_.shapes = std::move(shapes);
}

void Scene::list_media() {
  const auto add = [this](const Medium* medium) {
    if (medium && std::find(media_.begin(), media_.end(), medium) == media_.end()) {
      media_.push_back(medium);
    }
  };
  for (const auto& sensor : contents_.sensors) add(sensor->medium());
  for (const auto& shape : contents_.shapes) add(shape->interior()), add(shape->exterior());
}

/// Throws Error if two emitters represent the bounce of the same emitter.
void Scene::check_bounces() const {
  for (size_t i = 0; i < indirect_emitters_.size(); ++i) {
    for (size_t k = 0; k < i; ++k) {
      if (have_same_bounce(*indirect_emitters_[i], *indirect_emitters_[k])) {
        throw Error(Location{contents_.file}, kSameBounce);
      }
    }
  }
}

Scene::~Scene() = default;

namespace {

/// Returns false for rays with NaNs or with components beyond Accelerator::max_coordinate().
/// Embree supports coordinates up to 1.8e18 only, and terminates the program for other rays if it
/// is built with assertions, as Debian's package is.
bool can_be_traced(const Ray& ray, float max_coordinate) {
  const auto is_near = [&](float v) { return std::abs(v) <= max_coordinate; };
  return is_near(ray.o.x) && is_near(ray.o.y) && is_near(ray.o.z) && is_near(ray.d.x) &&
         is_near(ray.d.y) && is_near(ray.d.z) && !std::isnan(ray.tmin) && !std::isnan(ray.tmax);
}

Ray& ray_of(Ray& ray) {
  return ray;
}
Ray& ray_of(RayHit& ray) {
  return ray.ray;
}

/// Traces a batch except rays for which can_be_traced() is false. Those hit nothing and stay
/// unchanged, so that their NaNs propagate to the results.
template <class R, class Trace>
void trace_possible(std::span<R> rays, float max_coordinate, const Trace& trace) {
  std::vector<std::pair<size_t, R>> skipped;
  for (size_t i = 0; i < rays.size(); ++i) {
    if (can_be_traced(ray_of(rays[i]), max_coordinate)) continue;
    skipped.emplace_back(i, rays[i]);
    Ray& ray = ray_of(rays[i]);
    ray.o = Vec3(0.f);
    ray.d = Vec3(0, 0, 1);
    ray.tmin = 0;
    ray.tmax = -1;
  }
  trace();
  for (const auto& [i, ray] : skipped) rays[i] = ray;
}

/// Finds the lanes that are on and can be traced. Returns false if there are none.
bool find_valid(const Ray16& r, float max_coordinate, int (&valid)[16]) {
  int found = 0;
  for (size_t i = 0; i < 16; ++i) {
    // All comparisons fail for NaN. There are no branches, so that compilers vectorize the loop.
    const auto is_near = [&](float x) { return static_cast<int>(std::abs(x) <= max_coordinate); };
    const int is_on = is_near(r.ox[i]) & is_near(r.oy[i]) & is_near(r.oz[i]) & is_near(r.dx[i]) &
                      is_near(r.dy[i]) & is_near(r.dz[i]) &
                      static_cast<int>(r.tmin[i] <= r.tmax[i]);
    valid[i] = -is_on;
    found |= valid[i];
  }
  return found != 0;
}

/// Converts the index of a shape in its group to the index in the scene. The ray tracer's id of an
/// instance is the index of its first part.
void resolve_instances(RayHit16& rays) {
  for (size_t i = 0; i < 16; ++i) {
    const uint32_t is_in_group = static_cast<uint32_t>(rays.shape[i] != kNoHit) &
                                 static_cast<uint32_t>(rays.instance[i] != kNoHit);
    rays.shape[i] += rays.instance[i] & -is_in_group;
  }
}
void resolve_instances(std::span<RayHit> rays) {
  for (RayHit& ray : rays) {
    if (ray.hit.valid() && ray.hit.instance != kNoHit) ray.hit.shape += ray.hit.instance;
  }
}

}  // namespace

// These functions use the fastest calls as measured with AVX2 (Embree 3.13, a bumpy sphere with
// 130k triangles on a plane, one thread), in ns per ray:
//   camera rays, nearest:    stream, coherent 59; packets of 8, 59; of 16, 67; single 112
//   cosine bounces, nearest: single 210; packets of 8, 218; stream, incoherent 240
//   cosine bounces, any hit: stream, incoherent 107; packets of 8, 132; single 160
//   rays to a small light:   stream, coherent 79, incoherent 85; single 147
// The coherent flag costs as much for incoherent rays as it gains for coherent ones. Scenes with
// instances never use it, because some any-hit queries with coherent packets or streams of them
// never return (Embree 3.13.5, rtcOccluded16).
void Scene::intersect(std::span<RayHit> rays, Coherence coherence, RenderCounters& counters) const {
  const StageTimer timer(counters.embree_seconds);
  embree::Query query(coherence == Coherence::kCoherent && placed_.empty());
  trace_possible(rays, accelerator_->max_coordinate(), [&] {
    if (coherence == Coherence::kCoherent) {
      embree::intersect_stream(accelerator_->scene(), query, rays);
    } else {
      for (RayHit& ray : rays) embree::intersect1(accelerator_->scene(), query, ray);
    }
  });
  if (!placed_.empty()) resolve_instances(rays);
  rethrow_from_shapes();
}

void Scene::occluded(std::span<Ray> rays, Coherence coherence, RenderCounters& counters) const {
  const StageTimer timer(counters.embree_seconds);
  embree::Query query(coherence == Coherence::kCoherent && placed_.empty());
  trace_possible(rays, accelerator_->max_coordinate(),
                 [&] { embree::occluded_stream(accelerator_->scene(), query, rays); });
  rethrow_from_shapes();
}

void Scene::intersect(RayHit16* rays, size_t count, Coherence coherence,
                      RenderCounters& counters) const {
  const StageTimer timer(counters.embree_seconds);
  embree::Query query(coherence == Coherence::kCoherent && placed_.empty());
  const float max_coordinate = accelerator_->max_coordinate();
  alignas(64) int valid[16];
  for (size_t k = 0; k < count; ++k) {
    if (!find_valid(rays[k].ray, max_coordinate, valid)) continue;
    embree::intersect16(valid, accelerator_->scene(), query,
                        *reinterpret_cast<RTCRayHit16*>(&rays[k]));
    if (!placed_.empty()) resolve_instances(rays[k]);
  }
  rethrow_from_shapes();
}

void Scene::occluded(Ray16* rays, size_t count, Coherence coherence,
                     RenderCounters& counters) const {
  const StageTimer timer(counters.embree_seconds);
  embree::Query query(coherence == Coherence::kCoherent && placed_.empty());
  const float max_coordinate = accelerator_->max_coordinate();
  alignas(64) int valid[16];
  for (size_t k = 0; k < count; ++k) {
    if (!find_valid(rays[k], max_coordinate, valid)) continue;
    embree::occluded16(valid, accelerator_->scene(), query, *reinterpret_cast<RTCRay16*>(&rays[k]));
  }
  rethrow_from_shapes();
}

}  // namespace kinome
