#pragma once

#include <string>

#include "kinome/timeline.h"

namespace kinome::app {

/// Formats a timeline in Chrome's trace format, which chrome://tracing and https://ui.perfetto.dev
/// show: one row per thread; each item is an event with the name of its stage, or "commit". The
/// category is "loop" or "serial", and `part` is the index of the loop or serial part.
std::string trace_json(const Timeline& timeline);

}  // namespace kinome::app
