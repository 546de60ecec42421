// Checks of consistency, by the audit of renders.

#include <fmt/format.h>

#include "kit/subject.h"
#include "kinome/plugin_audit.h"

namespace kinome::check {

Outcome audit(const Subject& subject, const std::function<bool(const std::string&)>& wanted) {
  Outcome outcome;
  const auto scene = subject.scene(surroundings(subject, subject.xml()));
  // Each round checks 256 other points, the number that audit_plugins() checks thoroughly.
  const int rounds = std::max(1, static_cast<int>(4 * subject.request().effort));
  constexpr uint32_t kPoints = 256;
  for (int i = 0; i < rounds; ++i) {
    const uint64_t seed = hash_words(subject.request().seed, static_cast<uint64_t>(i));
    for (const PluginFault& fault : audit_plugins(*scene, *scene->sensors()[0], seed, kPoints)) {
      if (!wanted(fault.what)) continue;
      outcome.fail(fmt::format("{} gives {}", fault.plugin, fault.what));
      outcome.measured = fmt::format("at {} of {} points", fault.count, fault.looks);
    }
    if (!outcome.passed) return outcome;
  }
  outcome.measured = fmt::format("no contradiction at {} points", rounds * kPoints);
  return outcome;
}

}  // namespace kinome::check
