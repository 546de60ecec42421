#include "render/report.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "render/time_table.h"

namespace kinome::app {
namespace {

/// Returns the share of the render time spent in Embree, whose seconds are summed over threads.
double embree_share(const RenderStats& stats) {
  const double thread_seconds =
      stats.render_seconds * std::max(1u, stats.threads * stats.processes);
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

/// Formats the number of rays by kind, per second of the render and as a share of all rays.
std::string ray_table(const RenderStats& stats) {
  uint64_t all = 0;
  for (const uint64_t rays : stats.counters.rays) all += rays;
  std::string text;
  const auto line = [&](const std::string& name, uint64_t rays) {
    const auto count = static_cast<double>(rays);
    text += fmt::format("  {:<20} {:13} {:9.3f} M/s {:5.1f} %\n", name, rays,
                        1e-6 * count / std::max(stats.render_seconds, 1e-9),
                        100 * count / static_cast<double>(all));
  };
  int kinds = 0;
  for (int i = 0; i < kRayKindCount; ++i) {
    if (stats.counters.rays[i] == 0) continue;
    line(std::string(to_string(static_cast<RayKind>(i))) + " rays", stats.counters.rays[i]);
    ++kinds;
  }
  if (kinds > 1) line("all rays", all);
  return text;
}

/// Formats the traffic between processes; "" for a single process.
std::string traffic_table(const RenderStats& stats) {
  std::string text;
  for (const auto& [what, traffic] : stats.traffic) {
    text += fmt::format("  {:<20} {:9} messages {:11.3f} MB {:9.3f} s in all processes\n",
                        "sent: " + what, traffic.messages, static_cast<double>(traffic.bytes) / 1e6,
                        traffic.seconds);
  }
  return text;
}

}  // namespace

std::string stats_text(const RenderStats& stats, const RenderSummary& summary) {
  std::string text = fmt::format(
      "{}: {}x{} pixels, {} samples each, {}, {} threads{}\n", summary.scene, summary.width,
      summary.height, summary.samples, summary.integrator,
      stats.processes > 1 ? fmt::format("{} processes, {}", stats.processes, stats.threads)
                          : std::to_string(stats.threads),
      stats.complete ? "" : ", incomplete");
  text += time_table(stats);
  text += fmt::format("  {:<20} {:9.3f} s           after the program's start\n", "first tile",
                      stats.first_tile_seconds);
  text +=
      fmt::format("  {:<20} {:9.3f} s           per thread: {:.0f} % of the render\n", "in Embree",
                  stats.counters.embree_seconds / std::max(1u, stats.threads * stats.processes),
                  100 * embree_share(stats));
  text += ray_table(stats);
  text += traffic_table(stats);
  if (stats.rel_mse >= 0) {
    text +=
        fmt::format("  {:<20} {:9.3g}    as estimated by the render\n", "relMSE", stats.rel_mse);
  }
  text += fmt::format("  {:<20} {:9.1f} MB\n", "peak memory",
                      static_cast<double>(stats.peak_memory_bytes) / 1e6);
  text += fmt::format("  {:<20} {}\n", "instruction set", stats.instruction_set);
  text += fmt::format("  {:<20} {}\n", "plugins", fmt::join(stats.plugins, " "));
  for (const Skipped& s : all_skipped(stats)) {
    text += fmt::format("  {:<20} {}: {}\n", "skipped", s.what, s.why);
  }
  if (stats.non_finite_samples > 0) {
    text += fmt::format("  {:<20} {}\n", "non-finite samples", stats.non_finite_samples);
  }
  for (const PluginFault& fault : stats.faults) {
    text += fmt::format("  {:<20} {}: {}, at {} of {} positions\n", "fault", fault.plugin,
                        fault.what, fault.count, fault.looks);
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
  json traffic = json::object();
  for (const auto& [what, sent] : stats.traffic) {
    traffic[what] = {{"messages", sent.messages}, {"bytes", sent.bytes}, {"seconds", sent.seconds}};
  }
  const json report = {
      {"scene", summary.scene},
      {"output", summary.output},
      {"integrator", summary.integrator},
      {"width", summary.width},
      {"height", summary.height},
      {"samples", summary.samples},
      {"seed", summary.seed},
      {"processes", stats.processes},
      {"threads", stats.threads},
      {"traffic", traffic},
      {"complete", stats.complete},
      {"filled", stats.filled},
      {"missing", stats.missing},
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
      {"isa", stats.instruction_set},
      {"non_finite_samples", stats.non_finite_samples},
      {"faults", faults},
      {"peak_memory_bytes", stats.peak_memory_bytes},
  };
  // File names may be invalid UTF-8, which JSON must not contain.
  return report.dump(-1, ' ', false, json::error_handler_t::replace) + "\n";
}

}  // namespace kinome::app
