#include "report.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace kinome::app {
namespace {

/// Wall-clock time inside Embree, as a share of the render: its seconds are summed over threads.
double embree_share(const RenderStats& stats) {
  const double thread_seconds = stats.render_seconds * std::max(1u, stats.threads);
  return thread_seconds > 0 ? stats.counters.embree_seconds / thread_seconds : 0;
}

std::vector<Skipped> all_skipped(const RenderStats& stats) {
  std::vector<Skipped> skipped = stats.skipped;
  if (stats.counters.skipped_shadow_rays > 0) {
    skipped.push_back({fmt::format("{} shadow rays", stats.counters.skipped_shadow_rays),
                       "their contribution was zero"});
  }
  return skipped;
}

}  // namespace

std::string stats_text(const RenderStats& stats, const RenderSummary& summary) {
  std::string text =
      fmt::format("{}: {}x{} pixels, {} samples each, {}, {} threads{}\n", summary.scene,
                  summary.width, summary.height, summary.samples, summary.integrator, stats.threads,
                  stats.complete ? "" : ", incomplete");
  const auto seconds = [&](const char* name, double value, const std::string& note = "") {
    text += fmt::format("  {:<20} {:9.3f} s  {}\n", name, value, note);
  };
  seconds("load", stats.load_seconds,
          fmt::format("of which plugins {:.4f} s", stats.plugin_seconds));
  seconds("build", stats.build_seconds);
  seconds("first tile", stats.first_tile_seconds, "after the program's start");
  seconds("render", stats.render_seconds);
  seconds("  Embree", stats.counters.embree_seconds,
          fmt::format("over all threads: {:.0f} % of the render", 100 * embree_share(stats)));
  for (const auto& [stage, value] : stats.counters.stage_seconds) {
    seconds(("  " + stage).c_str(), value, "over all threads");
  }
  seconds("write", stats.write_seconds);
  seconds("total", stats.total_seconds);
  for (int i = 0; i < kRayKindCount; ++i) {
    if (stats.counters.rays[i] == 0) continue;
    text +=
        fmt::format("  {:<20} {:13}\n", std::string(to_string(static_cast<RayKind>(i))) + " rays",
                    stats.counters.rays[i]);
  }
  if (stats.rel_mse >= 0) {
    text +=
        fmt::format("  {:<20} {:9.3g}    by the render's own estimate\n", "relMSE", stats.rel_mse);
  }
  text += fmt::format("  {:<20} {:9.1f} MB\n", "peak memory",
                      static_cast<double>(stats.peak_memory_bytes) / 1e6);
  text += fmt::format("  {:<20} {}\n", "plugins", fmt::join(stats.plugins, " "));
  for (const Skipped& s : all_skipped(stats)) {
    text += fmt::format("  {:<20} {}: {}\n", "skipped", s.what, s.why);
  }
  if (stats.non_finite_samples > 0) {
    text += fmt::format("  {:<20} {}\n", "non-finite samples", stats.non_finite_samples);
  }
  for (const PluginFault& fault : stats.faults) {
    text += fmt::format("  {:<20} {}: {}, at {} of {} places\n", "fault", fault.plugin, fault.what,
                        fault.count, fault.looks);
  }
  return text;
}

std::string stats_json(const RenderStats& stats, const RenderSummary& summary) {
  using nlohmann::json;
  json rays = json::object();
  for (int i = 0; i < kRayKindCount; ++i) {
    rays[to_string(static_cast<RayKind>(i))] = stats.counters.rays[i];
  }
  json skipped = json::array();
  for (const Skipped& s : all_skipped(stats)) {
    skipped.push_back({{"what", s.what}, {"why", s.why}});
  }
  json faults = json::array();
  for (const PluginFault& fault : stats.faults) {
    faults.push_back({{"plugin", fault.plugin},
                      {"what", fault.what},
                      {"count", fault.count},
                      {"places", fault.looks}});
  }
  const json report = {
      {"scene", summary.scene},
      {"output", summary.output},
      {"integrator", summary.integrator},
      {"width", summary.width},
      {"height", summary.height},
      {"samples", summary.samples},
      {"seed", summary.seed},
      {"threads", stats.threads},
      {"complete", stats.complete},
      {"relmse", stats.rel_mse >= 0 ? json(stats.rel_mse) : json()},
      {"seconds",
       {{"load", stats.load_seconds},
        {"plugins", stats.plugin_seconds},
        {"build", stats.build_seconds},
        {"first_tile", stats.first_tile_seconds},
        {"render", stats.render_seconds},
        {"write", stats.write_seconds},
        {"total", stats.total_seconds},
        {"embree", stats.counters.embree_seconds},
        {"stages", stats.counters.stage_seconds}}},
      {"embree_share", embree_share(stats)},
      {"rays", rays},
      {"skipped_shadow_rays", stats.counters.skipped_shadow_rays},
      {"skipped", skipped},
      {"plugins", stats.plugins},
      {"non_finite_samples", stats.non_finite_samples},
      {"faults", faults},
      {"peak_memory_bytes", stats.peak_memory_bytes},
  };
  // A file name need not be UTF-8; JSON must be.
  return report.dump(-1, ' ', false, json::error_handler_t::replace) + "\n";
}

}  // namespace kinome::app
