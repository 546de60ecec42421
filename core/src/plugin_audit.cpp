#include "kinome/plugin_audit.h"

#include <cmath>
#include <map>

#include "kinome/color.h"
#include "kinome/primary_rays.h"
#include "kinome/texture.h"
#include "kinome/warp.h"

namespace kinome {
namespace {

constexpr const char* kValue = "a value that is not finite";
constexpr const char* kDensity = "a density that is negative or no number";
constexpr const char* kDirection = "a direction that is not finite";
constexpr const char* kThrew = "an exception";

/// Keeps these random numbers apart from those of renders.
constexpr uint64_t kAuditSeed = 0x6175646974;

/// Where plugins are asked.
struct Place {
  const SurfaceInteraction* si;  ///< nullptr: the ray left the scene
  Vec3 d;                        ///< of the ray
  uint64_t seed;
  float u(uint64_t i) const { return static_cast<float>(hash_words(seed, i) >> 40) * 0x1p-24f; }
  Vec2 u2(uint64_t i) const { return {u(i), u(i + 1)}; }
};

bool is_density(float pdf) {
  return pdf >= 0;
}

const char* fault_of(const Bsdf& bsdf, const Place& place) {
  const SurfaceInteraction& si = *place.si;
  const auto evaluate = [&](const Vec3& wo) -> const char* {
    const BsdfValue value = bsdf.eval_pdf(si, Lobe::kAll, wo);
    if (!is_finite(value.f)) return kValue;
    return is_density(value.pdf) ? nullptr : kDensity;
  };
  if (const auto sample = bsdf.sample(si, Lobe::kAll, place.u(0), place.u2(1))) {
    if (!is_finite(sample->wo)) return kDirection;
    if (!is_density(sample->pdf)) return kDensity;
    if (!is_finite(sample->weight)) return kValue;
    if (const char* const fault = evaluate(sample->wo)) return fault;
  }
  return evaluate(square_to_uniform_sphere(place.u2(3)));
}

const char* fault_of(const Emitter& emitter, const Place& place) {
  if (place.si) {
    if (emitter.is_indirect()) return nullptr;
    const auto sample = emitter.sample_direct(place.si->p, place.u2(0));
    if (sample && !is_density(sample->pdf)) return kDensity;
    if (sample && sample->pdf > 0 && !is_finite(sample->d)) return kDirection;
    if (sample && sample->pdf > 0 && !is_finite(sample->radiance)) return kValue;
  }
  if (emitter.is_environment()) {
    if (!is_finite(emitter.eval_environment(place.d))) return kValue;
    if (!is_density(emitter.pdf_environment(place.d))) return kDensity;
  }
  if (place.si && emitter.shape() && emitter.shape() == place.si->shape) {
    if (!is_finite(emitter.eval_surface(*place.si))) return kValue;
    const Vec3 from = place.si->p - place.d;
    if (!is_density(emitter.pdf_surface(from, *place.si))) return kDensity;
  }
  return nullptr;
}

const char* fault_of_any(const Object& object, const Place& place) {
  try {
    if (const auto* emitter = dynamic_cast<const Emitter*>(&object)) {
      return fault_of(*emitter, place);
    }
    if (!place.si) return nullptr;
    if (const auto* bsdf = dynamic_cast<const Bsdf*>(&object)) return fault_of(*bsdf, place);
    if (const auto* texture = dynamic_cast<const Texture*>(&object)) {
      return is_finite(texture->eval(place.si->uv)) ? nullptr : kValue;
    }
  } catch (...) {
    return kThrew;
  }
  return nullptr;
}

class Audit {
 public:
  /// Asks an object and, before it, all that are nested in it, each once at a place. Whether any
  /// has something to answer for.
  bool look_at(const Object& object, const Place& place) {
    // Where each refers twice to the next, there are 2^n ways to the nth.
    const auto [known, is_new] = answers_.try_emplace({place.seed, &object});
    if (!is_new) return known->second;
    bool is_at_fault = false;
    for (const auto& nested : object.nested()) is_at_fault = look_at(*nested, place) || is_at_fault;
    if (!is_at_fault) {
      ++looks_[&object];
      const char* const fault = fault_of_any(object, place);
      if (fault) ++faults_[{&object, fault}];
      is_at_fault = fault != nullptr;
    }
    return known->second = is_at_fault;
  }

  std::vector<PluginFault> faults() const {
    std::map<std::pair<std::string, std::string>, PluginFault> by_name;
    for (const auto& [who, count] : faults_) {
      const auto& [object, what] = who;
      const std::string name =
          object->plugin() + (object->id().empty() ? "" : " '" + object->id() + "'");
      PluginFault& fault = by_name[{name, what}];
      fault = {name, what, fault.count + count, fault.looks + looks_.at(object)};
    }
    std::vector<PluginFault> list;
    for (auto& [name, fault] : by_name) list.push_back(std::move(fault));
    return list;
  }

 private:
  std::map<std::pair<uint64_t, const Object*>, bool> answers_;  ///< by place
  std::map<const Object*, uint64_t> looks_;
  std::map<std::pair<const Object*, const char*>, uint64_t> faults_;
};

}  // namespace

std::vector<PluginFault> audit_plugins(const Scene& scene, const Sensor& sensor, uint64_t seed,
                                       uint32_t places) {
  Audit audit;
  PrimaryBatch primary;
  RenderCounters counters;
  const Rect& crop = sensor.film().crop();
  const auto& emitters = scene.emitters();
  for (uint32_t i = 0; i < places && crop.area() > 0; ++i) {
    Place place{nullptr, {}, hash_words(seed, kAuditSeed, i)};
    const int x = crop.x0 + static_cast<int>(hash_words(place.seed, 1000) % crop.width());
    const int y = crop.y0 + static_cast<int>(hash_words(place.seed, 1001) % crop.height());
    try {
      primary.trace(scene, sensor, {x, y, x + 1, y + 1}, i, 1, seed, counters);
    } catch (...) {
      continue;  // of sensor and shapes: what throws there ends a render before it gets here
    }
    place.d = primary.ray_hit(0).ray.d;
    if (primary.hit(0)) {
      const SurfaceInteraction& si = primary.interaction(0);
      place.si = &si;
      audit.look_at(si.shape->bsdf(), place);
      if (si.shape->emitter()) audit.look_at(*si.shape->emitter(), place);
    }
    if (!emitters.empty()) audit.look_at(*emitters[place.seed % emitters.size()], place);
  }
  return audit.faults();
}

}  // namespace kinome
