#include "kinome/plugin_audit.h"

#include <map>
#include <set>

#include "kinome/color.h"
#include "kinome/primary_rays.h"
#include "kinome/texture.h"
#include "plugin/audit_words.h"
#include "plugin/density_audit.h"
#include "plugin/object_audit.h"

namespace kinome {
namespace {

/// Keeps these random numbers apart from those of renders.
constexpr uint64_t kAuditSeed = 0x6175646974;

/// Contradictions take some fifty times as long to look for as nonsense: of more places, these.
constexpr uint32_t kThoroughPlaces = 256;

class Audit {
 public:
  /// Asks an object and, before it, all that are nested in it, each once at a place. Whether any
  /// has something to answer for.
  bool look_at(const Object& object, const AuditPlace& place, bool is_thorough) {
    // Where each refers twice to the next, there are 2^n ways to the nth.
    const auto [known, is_new] = answers_.try_emplace({place.seed, &object});
    if (!is_new) return known->second;
    bool is_at_fault = false;
    for (const auto& nested : object.nested()) {
      is_at_fault = look_at(*nested, place, is_thorough) || is_at_fault;
    }
    if (!is_at_fault) {
      ++looks_[&object];
      const char* const fault = fault_of(object, place, is_thorough);
      if (fault) ++faults_[{&object, fault}];
      is_at_fault = fault != nullptr;
    }
    return known->second = is_at_fault;
  }

  std::vector<PluginFault> faults() const {
    std::map<std::pair<std::string, std::string>, PluginFault> by_name;
    const auto add = [&](const Object& object, const char* what, uint64_t count) {
      const std::string name =
          object.plugin() + (object.id().empty() ? "" : " '" + object.id() + "'");
      PluginFault& fault = by_name[{name, what}];
      fault = {name, what, fault.count + count, fault.looks + looks_.at(&object)};
    };
    for (const auto& [who, count] : faults_) add(*who.first, who.second, count);
    for (const auto& [object, densities] : densities_) {
      if (densities.fails() && !has_fault(*object)) {
        add(*object, audit_words::kUnfollowed, looks_.at(object));
      }
    }
    std::vector<PluginFault> list;
    for (auto& [name, fault] : by_name) list.push_back(std::move(fault));
    return list;
  }

 private:
  const char* fault_of(const Object& object, const AuditPlace& place, bool is_thorough) {
    try {
      if (const auto* emitter = dynamic_cast<const Emitter*>(&object)) {
        const char* const fault = nonsense_of(*emitter, place);
        if (fault || !is_thorough) return fault;
        if (emitter->is_environment()) densities_[&object].look_at(*emitter, place);
        return contradiction_of(*emitter, place);
      }
      if (!place.si) return nullptr;
      if (const auto* bsdf = dynamic_cast<const Bsdf*>(&object)) {
        const char* const fault = nonsense_of(*bsdf, place);
        if (fault || !is_thorough) return fault;
        densities_[&object].look_at(*bsdf, place);
        return contradiction_of(*bsdf, place);
      }
      if (const auto* texture = dynamic_cast<const Texture*>(&object)) {
        return is_finite(texture->eval_at(*place.si)) ? nullptr : audit_words::kValue;
      }
    } catch (...) {
      return audit_words::kThrew;
    }
    return nullptr;
  }

  /// Found at places, of the object itself or of what is nested in it, or a density of the latter:
  /// what else is wrong with it may come of that.
  bool has_fault(const Object& object) const {
    std::set<const Object*> seen;
    return has_fault(object, seen);
  }
  /// Each object once: there may be 2^n ways to one.
  bool has_fault(const Object& object, std::set<const Object*>& seen) const {
    if (!seen.insert(&object).second) return false;
    const auto first = faults_.lower_bound({&object, nullptr});
    if (first != faults_.end() && first->first.first == &object) return true;
    for (const auto& nested : object.nested()) {
      const auto densities = densities_.find(nested.get());
      if (densities != densities_.end() && densities->second.fails()) return true;
      if (has_fault(*nested, seen)) return true;
    }
    return false;
  }

  std::map<std::pair<uint64_t, const Object*>, bool> answers_;  ///< by place
  std::map<const Object*, uint64_t> looks_;
  std::map<std::pair<const Object*, const char*>, uint64_t> faults_;
  std::map<const Object*, DensityAudit> densities_;
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
    AuditPlace place{scene, nullptr, {}, hash_words(seed, kAuditSeed, i)};
    const bool is_thorough = i < kThoroughPlaces;
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
      audit.look_at(si.shape->bsdf(), place, is_thorough);
      if (si.shape->emitter()) audit.look_at(*si.shape->emitter(), place, is_thorough);
    }
    if (scene.environment()) audit.look_at(*scene.environment(), place, is_thorough);
    if (!emitters.empty()) {
      audit.look_at(*emitters[place.seed % emitters.size()], place, is_thorough);
    }
  }
  return audit.faults();
}

}  // namespace kinome
