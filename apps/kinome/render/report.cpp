#include "render/report.h"

#include <algorithm>
#include <numeric>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace kinome::app {
namespace {

struct Row {
  std::string name;
  double seconds = 0;
  std::string phrase;
  std::vector<Row> parts;
};

/// Adds a part "other" with the time that the parts don't account for, unless it is a rounding
/// error.
void add_rest(Row& row, const std::string& phrase) {
  if (row.parts.empty()) return;
  double rest = row.seconds;
  for (const Row& part : row.parts) rest -= part.seconds;
  if (rest > 1e-3 * row.seconds) row.parts.push_back({"other", rest, phrase, {}});
}

/// Returns the integrator's stages nested in `within` ("" for the top level), with their own parts.
std::vector<Row> stages_within(const RenderStats& stats, std::string_view within) {
  const auto& seconds = stats.counters.stage_seconds;
  const double threads = std::max(1u, stats.threads * stats.processes);
  std::vector<Row> rows;
  for (const Stage& stage : stats.stages) {
    const auto found = seconds.find(stage.name);
    if (found == seconds.end() || found->second == 0) continue;
    const bool is_nested = seconds.count(stage.within) > 0;
    if ((is_nested ? stage.within : std::string_view()) != within) continue;
    Row row{stage.name, found->second / (stage.is_alone ? 1 : threads), stage.phrase,
            stages_within(stats, stage.name)};
    add_rest(row, "");
    rows.push_back(std::move(row));
  }
  if (!within.empty()) return rows;
  for (const auto& [name, value] : seconds) {
    const auto has_name = [&name = name](const Stage& stage) { return stage.name == name; };
    if (std::any_of(stats.stages.begin(), stats.stages.end(), has_name) || value == 0) continue;
    rows.push_back({name, value / threads, "", {}});
  }
  return rows;
}

Row all_of(const RenderStats& stats) {
  Row render{"render", stats.render_seconds, "", stages_within(stats, {})};
  add_rest(render, "set-up, and threads waiting for others");
  Row load{"load", stats.load_seconds, "reads the scene and its files", {}};
  if (stats.plugin_seconds > 0) {
    load.parts.push_back({"plugins", stats.plugin_seconds, "opens plugin libraries", {}});
    add_rest(load, "parses the scene, reads meshes and textures");
  }
  Row all{"total", stats.total_seconds, "from the program's start", {}};
  all.parts = {std::move(load),
               {"build", stats.build_seconds, "builds the acceleration structure", {}},
               std::move(render),
               {"write", stats.write_seconds, "writes the image", {}}};
  add_rest(all, "start-up, checks of plugins");
  return all;
}

void print(const Row& row, double whole, int depth, std::string& text) {
  const std::string name = std::string(static_cast<size_t>(2 * depth), ' ') + row.name;
  std::string line = fmt::format("  {:<20} {:9.3f} s {:6.1f} %  {}", name, row.seconds,
                                 whole > 0 ? 100 * row.seconds / whole : 0, row.phrase);
  line.erase(line.find_last_not_of(' ') + 1);
  text += line + '\n';
  for (const Row& part : row.parts) print(part, whole, depth + 1, text);
}

/// Formats a table with a line per stage, in the order of execution: wall-clock seconds, share of
/// the total, and a description. Parts of a stage are indented and add up to it; a part "other" has
/// the time that no other part accounts for.
std::string time_table(const RenderStats& stats) {
  std::string text;
  const Row all = all_of(stats);
  for (const Row& part : all.parts) print(part, all.seconds, 0, text);
  print({all.name, all.seconds, all.phrase, {}}, all.seconds, 0, text);
  return text;
}

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

/// Formats the work of the threads in each stage; "" if it wasn't recorded.
std::string thread_table(const std::vector<StageThreads>& stages) {
  if (stages.empty()) return "";
  std::string text = fmt::format("  {:<20} {:>9} {:>13} {:>11}  {}\n", "threads", "whole [s]",
                                 "some idle [s]", "commits [s]", "busy [%], by thread");
  for (const StageThreads& stage : stages) {
    const double commits = std::accumulate(stage.committing.begin(), stage.committing.end(), 0.);
    text += fmt::format("    {:<18} {:9.3f} {:13.3f} {:11.3f} ", stage.stage, stage.seconds,
                        stage.partly_idle, commits);
    for (const double busy : stage.busy) {
      text += fmt::format(" {:.0f}", 100 * busy / std::max(stage.seconds, 1e-9));
    }
    text += '\n';
  }
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

/// Formats the size of the image and, if it is a part of the film, its position.
std::string size_text(const RenderSummary& summary) {
  std::string text = fmt::format("{}x{} pixels", summary.width, summary.height);
  if (summary.width != summary.full_width || summary.height != summary.full_height) {
    text += fmt::format(" at {},{} of {}x{}", summary.x, summary.y, summary.full_width,
                        summary.full_height);
  }
  return text;
}

}  // namespace

std::string stats_text(const RenderStats& stats, const RenderSummary& summary) {
  std::string text = fmt::format(
      "{}: {}, {} samples each, {}, {} threads{}\n", summary.scene, size_text(summary),
      summary.samples, summary.integrator,
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
  text += thread_table(summary.stage_threads);
  text += traffic_table(stats);
  if (stats.rel_mse >= 0) {
    text +=
        fmt::format("  {:<20} {:9.3g}    as estimated by the render\n", "relMSE", stats.rel_mse);
  }
  text += fmt::format("  {:<20} {:9.1f} MB\n", "peak memory",
                      static_cast<double>(stats.peak_memory_bytes) / 1e6);
  text += fmt::format("  {:<20} {}\n", "instruction set", stats.instruction_set);
  text += fmt::format("  {:<20} {}\n", "plugins", fmt::join(stats.plugins, " "));
  if (!stats.method.empty()) {
    text += fmt::format("  {:<20} {}\n", "method", stats.method);
  }
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

namespace {

using nlohmann::json;

json rays_json(const RenderStats& stats) {
  json rays = json::object();
  for (int i = 0; i < kRayKindCount; ++i) {
    rays[to_string(static_cast<RayKind>(i))] = stats.counters.rays[i];
  }
  return rays;
}

json skipped_json(const RenderStats& stats) {
  json skipped = json::array();
  for (const Skipped& s : all_skipped(stats)) {
    skipped.push_back({{"what", s.what}, {"why", s.why}});
  }
  return skipped;
}

json faults_json(const RenderStats& stats) {
  json faults = json::array();
  for (const PluginFault& fault : stats.faults) {
    faults.push_back({{"plugin", fault.plugin},
                      {"what", fault.what},
                      {"count", fault.count},
                      {"places", fault.looks}});
  }
  return faults;
}

json traffic_json(const RenderStats& stats) {
  json traffic = json::object();
  for (const auto& [what, sent] : stats.traffic) {
    traffic[what] = {{"messages", sent.messages}, {"bytes", sent.bytes}, {"seconds", sent.seconds}};
  }
  return traffic;
}

json stage_threads_json(const RenderSummary& summary) {
  json stage_threads = json::array();
  for (const StageThreads& stage : summary.stage_threads) {
    stage_threads.push_back({{"stage", stage.stage},
                             {"seconds", stage.seconds},
                             {"partly_idle", stage.partly_idle},
                             {"busy", stage.busy},
                             {"committing", stage.committing}});
  }
  return stage_threads;
}

json seconds_json(const RenderStats& stats) {
  return {{"load", stats.load_seconds},
          {"plugins", stats.plugin_seconds},
          {"build", stats.build_seconds},
          {"first_tile", stats.first_tile_seconds},
          {"render", stats.render_seconds},
          {"write", stats.write_seconds},
          {"total", stats.total_seconds},
          {"embree", stats.counters.embree_seconds},
          {"stages", stats.counters.stage_seconds}};
}

}  // namespace

std::string stats_json(const RenderStats& stats, const RenderSummary& summary) {
  const json report = {
      {"scene", summary.scene},
      {"output", summary.output},
      {"integrator", summary.integrator},
      {"width", summary.width},
      {"height", summary.height},
      {"x", summary.x},
      {"y", summary.y},
      {"film_width", summary.full_width},
      {"film_height", summary.full_height},
      {"samples", summary.samples},
      {"seed", summary.seed},
      {"processes", stats.processes},
      {"threads", stats.threads},
      {"stage_threads", stage_threads_json(summary)},
      {"traffic", traffic_json(stats)},
      {"complete", stats.complete},
      {"filled", stats.filled},
      {"missing", stats.missing},
      {"relmse", stats.rel_mse >= 0 ? json(stats.rel_mse) : json()},
      {"seconds", seconds_json(stats)},
      {"embree_share", embree_share(stats)},
      {"rays", rays_json(stats)},
      {"skipped_shadow_rays", stats.counters.skipped_shadow_rays},
      {"method", stats.method.empty() ? json() : json(stats.method)},
      {"skipped", skipped_json(stats)},
      {"plugins", stats.plugins},
      {"isa", stats.instruction_set},
      {"non_finite_samples", stats.non_finite_samples},
      {"faults", faults_json(stats)},
      {"peak_memory_bytes", stats.peak_memory_bytes},
  };
  // File names may be invalid UTF-8, which JSON must not contain.
  return report.dump(-1, ' ', false, json::error_handler_t::replace) + "\n";
}

}  // namespace kinome::app
