#include "kinome/stats.h"

#include <sys/resource.h>

#include <fstream>
#include <string>

namespace kinome {

const char* to_string(RayKind kind) {
  constexpr const char* kKindNames[kRayKindCount] = {"camera", "shadow", "bsdf", "lobe", "light"};
  return kKindNames[static_cast<size_t>(kind)];
}

void RenderCounters::add(const RenderCounters& other) {
  for (int i = 0; i < kRayKindCount; ++i) rays[i] += other.rays[i];
  embree_seconds += other.embree_seconds;
  skipped_shadow_rays += other.skipped_shadow_rays;
  for (const auto& [stage, seconds] : other.stage_seconds) stage_seconds[stage] += seconds;
}

uint64_t peak_memory_bytes() {
#if defined(__linux__)
  // The peak of getrusage() includes the memory of the program that started this one.
  std::ifstream status("/proc/self/status");
  for (std::string name; status >> name; std::getline(status, name)) {
    uint64_t kilobytes = 0;
    if (name == "VmHWM:" && status >> kilobytes) return kilobytes * 1024;
  }
#endif
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  // The unit is kilobytes on Linux and bytes on macOS.
#if defined(__APPLE__)
  return static_cast<uint64_t>(usage.ru_maxrss);
#else
  return static_cast<uint64_t>(usage.ru_maxrss) * 1024;
#endif
}

}  // namespace kinome
