#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>

namespace kinome {

struct Image;
class ProcessGroup;
class Timeline;

/// Called repeatedly during a render, by one thread at a time, with the fraction of tiles done.
using ProgressCallback = std::function<void(double fraction)>;

/// Stopping criteria of a progressive render, in place of the scene's sample count. They can be
/// combined; with a time and an error, the first one reached ends the render.
struct RenderBudget {
  /// Time of RenderOptions::clock [s] at which the caller must be done with the image; 0: no limit.
  /// The first pass, which has the fewest samples, is always completed.
  double seconds = 0;
  /// Target for the estimated relMSE: the mean of variance / (colour² + 0.01 mean²) over pixels and
  /// channels; 0: none. The render stops at kMaxSamples samples per pixel, or at the scene's sample
  /// count if that is larger.
  double rel_mse = 0;
  static constexpr double kMaxSamples = 16384;
  /// Number of film lanes (at least 2) for film_noise(); 0: no variance estimates.
  uint32_t lanes = 0;
  /// Estimates the seconds that the caller needs after the render for an image like `image`, for
  /// example to write it. They are part of `seconds`.
  std::function<double(const Image& image)> seconds_after = nullptr;
  bool any() const { return seconds > 0 || rel_mse > 0 || lanes > 0; }
};

/// Options with which a program creates a RenderContext.
struct RenderOptions {
  unsigned threads = 0;  ///< 0: one per core
  uint64_t seed = 0;
  const std::atomic<bool>* cancel = nullptr;  ///< set to true by the caller to end the render
  ProgressCallback progress = nullptr;
  /// Shuffles the order in which tiles are rendered; results don't depend on it.
  uint64_t tile_order_seed = 0;
  /// Start of the program, for RenderStats::first_tile_seconds and for `clock`.
  std::chrono::steady_clock::time_point start = std::chrono::steady_clock::now();
  RenderBudget budget = {};
  /// Returns the seconds since `start`; nullptr: the system's steady clock. Thread-safe.
  std::function<double()> clock = nullptr;
  /// Group of processes that render the same image with the same options, except for threads,
  /// progress and clock. nullptr: a single process. Must outlive the context.
  ProcessGroup* group = nullptr;
  /// Records the work of each thread of this process; nullptr: nothing is recorded. Must outlive
  /// the context.
  Timeline* timeline = nullptr;
};

}  // namespace kinome
