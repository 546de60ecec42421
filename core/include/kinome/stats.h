#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "kinome/export.h"

namespace kinome {

/// Purpose of a ray, for counting.
enum class RayKind { kCamera, kShadow, kBsdf, kLobe, kLight };
inline constexpr int kRayKindCount = 5;
KINOME_EXPORT const char* to_string(RayKind kind);

/// Counters of one thread, or their sum over threads.
struct KINOME_EXPORT RenderCounters {
  std::array<uint64_t, kRayKindCount> rays{};
  double embree_seconds = 0;                    ///< time in Embree calls, summed over threads
  std::map<std::string, double> stage_seconds;  ///< time per stage, summed over threads
  uint64_t skipped_shadow_rays = 0;             ///< rays not traced because the contribution is 0
  void add(const RenderCounters& other);
  uint64_t& operator[](RayKind kind) { return rays[static_cast<int>(kind)]; }
};

/// Description of a stage of RenderCounters::stage_seconds, for users. The strings are literals.
struct Stage {
  const char* name;
  const char* phrase;  ///< its task: "traces rays from the camera"
  /// True if no other stage runs in parallel, so that its time is wall-clock time. Times of other
  /// stages are summed over threads.
  bool is_alone = false;
  const char* within = "";  ///< enclosing stage, or ""
};

/// Adds the time of its lifetime to a stage. Costs about 50 ns: use it for batches, not for rays.
class StageTimer {
 public:
  explicit StageTimer(double& seconds) : seconds_(seconds), start_(Clock::now()) {}
  StageTimer(const StageTimer&) = delete;
  StageTimer& operator=(const StageTimer&) = delete;
  ~StageTimer() { seconds_ += std::chrono::duration<double>(Clock::now() - start_).count(); }

 private:
  using Clock = std::chrono::steady_clock;
  double& seconds_;
  Clock::time_point start_;
};

/// Work that a render skipped, and the reason: {"light tree", "no emitter has light points"}.
struct Skipped {
  std::string what;
  std::string why;
};

/// Data exchanged by the processes of a group.
struct GroupTraffic {
  uint64_t messages = 0;
  uint64_t bytes = 0;  ///< counted once per receiving process
  double seconds = 0;  ///< time until all data arrived, including waiting; summed over processes
};

/// Invalid result that a plugin returned at `count` of `looks` audited points (see
/// audit_plugins()).
struct PluginFault {
  std::string plugin;  ///< "bsdf/ward", with the object's id
  std::string what;
  uint64_t count = 0;
  uint64_t looks = 0;
};

/// Statistics of a render, for `--stats`. Times are wall-clock seconds unless noted.
struct KINOME_EXPORT RenderStats {
  double load_seconds = 0;    ///< XML, plugins, assets
  double plugin_seconds = 0;  ///< part of loading: opening plugin libraries
  double build_seconds = 0;   ///< building the acceleration structure
  double render_seconds = 0;
  double first_tile_seconds = 0;  ///< from the program's start to the first tile
  double write_seconds = 0;
  double total_seconds = 0;
  RenderCounters counters;
  std::vector<Skipped> skipped;
  /// Method that the integrator chose, and why: "path (the render is short)". Empty if it has no
  /// choice.
  std::string method;
  /// Features of Mitsuba missing from the image of a leniently loaded scene, with locations.
  std::vector<std::string> left_out;
  std::vector<Stage> stages;  ///< stages that the integrator lists, in order of execution
  std::vector<std::string> plugins;
  std::string instruction_set;  ///< highest that plugins may use; see to_string(InstructionSet)
  unsigned threads = 0;         ///< per process
  unsigned processes = 1;       ///< number of processes that rendered the image
  std::map<std::string, GroupTraffic> traffic;  ///< traffic of all processes, by subject
  uint64_t peak_memory_bytes = 0;
  uint64_t non_finite_samples = 0;
  std::vector<PluginFault> faults;
  bool complete = true;
  /// For an incomplete image: the fraction of pixels that got a single sample after the
  /// interruption, and the fraction without samples.
  double filled = 0, missing = 0;
  double samples = 0;   ///< per pixel, as Sampler::sample_count(), or of equal cost
  double rel_mse = -1;  ///< estimated by the render; negative: no estimate
  /// Number of lanes behind the image's variances (see FilmNoise); 0: no variances.
  uint32_t renders = 0;
  std::vector<double> variance_of_mean;
};

/// Returns the peak resident memory of this process.
KINOME_EXPORT uint64_t peak_memory_bytes();

}  // namespace kinome
