#include "kinome/plugin_audit.h"

#include <algorithm>
#include <map>
#include <set>
#include <vector>

#include "kinome/color.h"
#include "kinome/primary_rays.h"
#include "kinome/texture.h"
#include "audit/audit_words.h"
#include "audit/density_audit.h"
#include "audit/object_audit.h"

namespace kinome {
namespace {

/// Mixed into the seed, so that the random numbers differ from those of renders.
constexpr uint64_t kAuditSeed = 0x6175646974;

/// Number of points at which contradictions are searched for, which takes about 50 times as long as
/// finding invalid values.
constexpr uint32_t kThoroughPoints = 256;

/// Number of points that a thread checks at a time.
constexpr uint32_t kPointsOfPart = 16;

class Audit {
 public:
  /// Checks an object and all objects nested in it, each once per point, the innermost first.
  /// Returns true if any of them has a fault.
  bool check(const Object& object, const AuditPlace& place, bool is_thorough) {
    // Visit each object once: if each one refers twice to the next, there are 2^n paths to the nth.
    const auto [known, is_new] = results_.try_emplace({place.seed, &object});
    if (!is_new) return known->second;
    bool is_at_fault = false;
    for (const auto& nested : object.nested()) {
      is_at_fault = check(*nested, place, is_thorough) || is_at_fault;
    }
    if (!is_at_fault) {
      ++looks_[&object];
      const char* const fault = fault_of(object, place, is_thorough);
      if (fault) ++faults_[{&object, fault}];
      is_at_fault = fault != nullptr;
    }
    return known->second = is_at_fault;
  }

  /// Adds the results of an audit of other points.
  void add(const Audit& other) {
    for (const auto& [object, count] : other.looks_) looks_[object] += count;
    for (const auto& [key, count] : other.faults_) faults_[key] += count;
    for (const auto& [object, densities] : other.densities_) densities_[object].add(densities);
  }

  std::vector<PluginFault> faults() const {
    std::map<std::pair<std::string, std::string>, PluginFault> by_name;
    const auto add = [&](const Object& object, const char* what, uint64_t count) {
      const std::string name =
          object.plugin() + (object.id().empty() ? "" : " '" + object.id() + "'");
      PluginFault& fault = by_name[{name, what}];
      fault = {name, what, fault.count + count, fault.looks + looks_.at(&object)};
    };
    for (const auto& [key, count] : faults_) add(*key.first, key.second, count);
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
        const char* const fault = find_invalid_value(*emitter, place);
        if (fault || !is_thorough) return fault;
        if (emitter->is_environment()) densities_[&object].add_place(*emitter, place);
        return find_contradiction(*emitter, place);
      }
      if (!place.si) return nullptr;
      if (const auto* bsdf = dynamic_cast<const Bsdf*>(&object)) {
        const char* const fault = find_invalid_value(*bsdf, place);
        if (fault || !is_thorough) return fault;
        densities_[&object].add_place(*bsdf, place);
        return find_contradiction(*bsdf, place);
      }
      if (const auto* texture = dynamic_cast<const Texture*>(&object)) {
        return is_finite(texture->eval_at(*place.si)) ? nullptr : audit_words::kValue;
      }
    } catch (...) {
      return audit_words::kThrew;
    }
    return nullptr;
  }

  /// Returns true if a fault was found in the object or in a nested one, or if the density test of
  /// a nested one fails. Such a fault may also make the object's own density test fail.
  bool has_fault(const Object& object) const {
    std::set<const Object*> seen;
    return has_fault(object, seen);
  }
  /// `seen` makes it visit each object once: there may be 2^n paths to an object.
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

  std::map<std::pair<uint64_t, const Object*>, bool> results_;  ///< of check(), by point
  std::map<const Object*, uint64_t> looks_;
  std::map<std::pair<const Object*, const char*>, uint64_t> faults_;
  std::map<const Object*, DensityAudit> densities_;
};

/// Checks the plugins at points [first, end).
Audit audit_points(const Scene& scene, const Sensor& sensor, uint64_t seed, uint32_t first,
                   uint32_t end) {
  Audit audit;
  PrimaryBatch primary;
  RenderCounters counters;
  const Rect& crop = sensor.film().crop();
  const auto& emitters = scene.emitters();
  for (uint32_t i = first; i < end && crop.area() > 0; ++i) {
    AuditPlace place{scene, nullptr, {}, hash_words(seed, kAuditSeed, i)};
    const bool is_thorough = i < kThoroughPoints;
    const int x = crop.x0 + static_cast<int>(hash_words(place.seed, 1000) % crop.width());
    const int y = crop.y0 + static_cast<int>(hash_words(place.seed, 1001) % crop.height());
    try {
      primary.trace(scene, sensor, {x, y, x + 1, y + 1}, i, 1, seed, counters);
    } catch (...) {
      continue;  // sensors and shapes that throw have ended the render already
    }
    place.d = primary.ray_hit(0).ray.d;
    if (primary.hit(0)) {
      const SurfaceInteraction& si = primary.interaction(0);
      place.si = &si;
      audit.check(si.shape->bsdf(), place, is_thorough);
      if (si.shape->emitter()) audit.check(*si.shape->emitter(), place, is_thorough);
    }
    if (scene.environment()) audit.check(*scene.environment(), place, is_thorough);
    if (!emitters.empty()) {
      audit.check(*emitters[place.seed % emitters.size()], place, is_thorough);
    }
  }
  return audit;
}

}  // namespace

std::vector<PluginFault> audit_plugins(const Scene& scene, const Sensor& sensor, uint64_t seed,
                                       uint32_t places, const Scheduler* scheduler) {
  // The parts are the same on any number of threads, so that sums are added in the same order.
  std::vector<Audit> parts((places + kPointsOfPart - 1) / kPointsOfPart);
  const auto audit_part = [&](size_t part) {
    const auto first = static_cast<uint32_t>(part) * kPointsOfPart;
    parts[part] = audit_points(scene, sensor, seed, first, std::min(first + kPointsOfPart, places));
  };
  if (scheduler) {
    scheduler->parallel_for(parts.size(), audit_part);
  } else {
    for (size_t part = 0; part < parts.size(); ++part) audit_part(part);
  }
  Audit audit;
  for (const Audit& part : parts) audit.add(part);
  return audit.faults();
}

}  // namespace kinome
