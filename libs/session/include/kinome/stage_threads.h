#pragma once

#include <string>
#include <vector>

#include "kinome/export.h"
#include "kinome/timeline.h"

namespace kinome {

/// Work of the threads in a stage. Stages of this kind follow each other in time, and include
/// serial work (see Timeline).
struct StageThreads {
  std::string stage;
  double seconds = 0;              ///< wall-clock time of the stage
  double partly_idle = 0;          ///< part of it in which fewer than all threads worked on items
  std::vector<double> busy;        ///< per thread: time on items
  std::vector<double> committing;  ///< per thread: time of commits to the film, with waiting
};

/// Returns the work of `threads` threads in each stage, in the order of execution.
KINOME_EXPORT std::vector<StageThreads> stage_threads(const Timeline& timeline, unsigned threads);

}  // namespace kinome
