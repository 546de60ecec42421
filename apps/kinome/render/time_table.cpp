#include "render/time_table.h"

#include <algorithm>
#include <string_view>
#include <vector>

#include <fmt/format.h>

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

}  // namespace

std::string time_table(const RenderStats& stats) {
  std::string text;
  const Row all = all_of(stats);
  for (const Row& part : all.parts) print(part, all.seconds, 0, text);
  print({all.name, all.seconds, all.phrase, {}}, all.seconds, 0, text);
  return text;
}

}  // namespace kinome::app
