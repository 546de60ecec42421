#include "time_table.h"

#include <algorithm>
#include <span>
#include <string_view>
#include <vector>

#include <fmt/format.h>

namespace kinome::app {
namespace {

/// A stage of an integrator, as people know it. Integrators may have others: those are shown by
/// their names.
struct Stage {
  std::string_view name;
  std::string_view phrase;
  /// While it runs nothing else does: its seconds are on the clock. Those of others are summed over
  /// threads.
  bool is_alone = false;
  std::string_view within = {};  ///< the stage that it is part of, where there is that one
};

/// In the order in which they run.
constexpr Stage kStages[] = {
    {"light left out", "finds out how much light is left out", true},
    {"light points", "places points on all that shines", true},
    {"tree", "builds the tree of lights", true},
    {"cells", "divides the light into cells", true},
    {"points", "draws points in each cell", true},
    {"pilot", "looks at all of the picture by a few rays"},
    {"plan", "learns what is visible from where, and where rays are needed"},
    {"allocate", "deals out rays to pixels", true},
    {"main", "renders by what was learned"},
    {"primary", "traces rays from the camera", false, "main"},
    {"aov", "reads off the first hits"},
    {"emit", "sends light from the lamps"},
    {"importance", "weighs clusters for each point"},
    {"choose", "picks points of light by that"},
    {"evaluate", "computes the light of each point"},
    {"bounce", "traces rays on from surfaces"},
    {"shade", "draws directions and computes light"},
    {"strata", "sorts what light arrives from where", false, "main"},
    {"candidates", "tries light without shadows", false, "main"},
    {"comb", "picks among the candidates", false, "main"},
    {"eye rays", "follows mirrors", false, "main"},
    {"shadow", "finds out what hides the light", false, "main"},
    {"film", "adds up the picture", false, "main"},
    {"caustics", "follows light from lamps to mirrors", false, "film"},
};

struct Row {
  std::string name;
  double seconds = 0;
  std::string phrase;
  std::vector<Row> parts;
};

/// What the parts leave, if that is more than rounding.
void add_rest(Row& row, const std::string& phrase) {
  if (row.parts.empty()) return;
  double rest = row.seconds;
  for (const Row& part : row.parts) rest -= part.seconds;
  if (rest > 1e-3 * row.seconds) row.parts.push_back({"other", rest, phrase, {}});
}

/// The integrator's stages that are part of `within`, with parts of their own.
std::vector<Row> stages_within(const RenderStats& stats, std::string_view within) {
  const auto& seconds = stats.counters.stage_seconds;
  const double threads = std::max(1u, stats.threads);
  std::vector<Row> rows;
  for (const Stage& stage : kStages) {
    const auto found = seconds.find(std::string(stage.name));
    if (found == seconds.end() || found->second == 0) continue;
    const bool is_nested = seconds.count(std::string(stage.within)) > 0;
    if ((is_nested ? stage.within : std::string_view()) != within) continue;
    Row row{std::string(stage.name), found->second / (stage.is_alone ? 1 : threads),
            std::string(stage.phrase), stages_within(stats, stage.name)};
    add_rest(row, "");
    rows.push_back(std::move(row));
  }
  if (!within.empty()) return rows;
  for (const auto& [name, value] : seconds) {
    const auto has_name = [&name = name](const Stage& stage) { return stage.name == name; };
    if (std::any_of(std::begin(kStages), std::end(kStages), has_name) || value == 0) continue;
    rows.push_back({name, value / threads, "", {}});
  }
  return rows;
}

Row all_of(const RenderStats& stats) {
  Row render{"render", stats.render_seconds, "", stages_within(stats, {})};
  add_rest(render, "set-up, and threads that wait for others");
  Row load{"load", stats.load_seconds, "reads the scene and its files", {}};
  if (stats.plugin_seconds > 0) {
    load.parts.push_back({"plugins", stats.plugin_seconds, "opens their libraries", {}});
    add_rest(load, "the scene, its meshes and pictures");
  }
  Row all{"total", stats.total_seconds, "from the program's start", {}};
  all.parts = {std::move(load),
               {"build", stats.build_seconds, "makes the structure that rays are traced in", {}},
               std::move(render),
               {"write", stats.write_seconds, "writes the picture", {}}};
  add_rest(all, "starts up, checks plugins");
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
