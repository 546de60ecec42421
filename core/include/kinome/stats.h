#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "kinome/export.h"

namespace kinome {

enum class RayKind { kCamera, kShadow, kBsdf, kLobe, kLight };
inline constexpr int kRayKindCount = 5;
KINOME_EXPORT const char* to_string(RayKind kind);

/// Counters of one thread (or the sum of all).
struct KINOME_EXPORT RenderCounters {
  std::array<uint64_t, kRayKindCount> rays{};
  double embree_seconds = 0;                    ///< inside Embree's calls, summed over threads
  std::map<std::string, double> stage_seconds;  ///< integrator's stages, summed over threads
  uint64_t skipped_shadow_rays = 0;             ///< contribution was zero: no ray
  void add(const RenderCounters& other);
  uint64_t& operator[](RayKind kind) { return rays[static_cast<int>(kind)]; }
};

/// How a stage whose time is in RenderCounters::stage_seconds is described to users. Texts are
/// literals.
struct Stage {
  const char* name;
  const char* phrase;  ///< what it does: "traces rays from the camera"
  /// While it runs nothing else does: its seconds are on the clock. Those of others are summed over
  /// threads.
  bool is_alone = false;
  const char* within = "";  ///< the stage that it is part of, where there is that one
};

/// Adds the time until its end to a stage. Costs about 50 ns: for batches, not for rays.
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

/// What a render skipped, and why: {"light tree", "no emitter offers light points"}.
struct Skipped {
  std::string what;
  std::string why;
};

/// What processes that render together have sent each other.
struct GroupTraffic {
  uint64_t messages = 0;
  uint64_t bytes = 0;  ///< each as often as there is a process that gets it
  double seconds = 0;  ///< until all was there, summed over processes: waiting for others counts
};

/// Something impossible that a plugin returned at `count` of the `looks` places where it was asked
/// after the render.
struct PluginFault {
  std::string plugin;  ///< "bsdf/ward", and the object's id
  std::string what;
  uint64_t count = 0;
  uint64_t looks = 0;
};

/// What `--stats` reports. Wall-clock seconds, except where said.
struct KINOME_EXPORT RenderStats {
  double load_seconds = 0;    ///< XML, plugins, assets
  double plugin_seconds = 0;  ///< part of load: opening plugin libraries
  double build_seconds = 0;   ///< acceleration structure
  double render_seconds = 0;
  double first_tile_seconds = 0;  ///< from the program's start to the first tile
  double write_seconds = 0;
  double total_seconds = 0;
  RenderCounters counters;
  std::vector<Skipped> skipped;
  /// Of a scene that was loaded leniently: what of Mitsuba's isn't in the picture, with places.
  std::vector<std::string> left_out;
  std::vector<Stage> stages;  ///< those that the integrator tells of, as they run
  std::vector<std::string> plugins;
  std::string instruction_set;  ///< the best that plugins may use, see to_string(InstructionSet)
  unsigned threads = 0;    ///< of each process
  unsigned processes = 1;  ///< that made the picture together
  std::map<std::string, GroupTraffic> traffic;  ///< of all of them, by what it was about
  uint64_t peak_memory_bytes = 0;
  uint64_t non_finite_samples = 0;
  std::vector<PluginFault> faults;
  bool complete = true;
  /// Of the pixels of a picture that isn't complete: the share that got a single sample once the
  /// render was interrupted, and that which has none.
  double filled = 0, missing = 0;
  double samples = 0;   ///< a pixel, as of Sampler::sample_count, or what costs as much
  double rel_mse = -1;  ///< as the render itself estimates it; negative: it doesn't
  /// Where the picture has variances (see FilmNoise): what they come from; 0: it has none.
  uint32_t renders = 0;
  std::vector<double> variance_of_mean;
};

/// Peak resident memory of this process.
KINOME_EXPORT uint64_t peak_memory_bytes();

}  // namespace kinome
