// `kinome plugins`: lists plugins, and prints the parameter table of one.

#include <algorithm>
#include <map>
#include <span>
#include <sstream>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "commands.h"
#include "crash.h"
#include "kinome/error.h"
#include "kinome/mitsuba_plugins.h"
#include "kinome/plugin_registry.h"
#include "options/line_width.h"

namespace kinome::app {
namespace {

std::string type_name(const Parameter& p) {
  if (p.type != ParameterType::kObject) return to_string(p.type);
  const std::string category = to_string(p.category);
  return p.max_count == 1 ? category : fmt::format("{} (up to {})", category, p.max_count);
}

std::string default_text(const Parameter& p) {
  if (p.required) return "required";
  if (p.ignored) return "ignored";
  return p.default_value ? p.default_value : "";
}

/// Joins the lines of a plugin's documentation.
std::string one_line(const char* doc) {
  std::string text(doc ? doc : "");
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text;
}

/// Prints `head` and then `text`, wrapped between words. Further lines are indented to the
/// beginning of `text`; if that leaves little room, the text begins on the line below `head`.
void print_wrapped(const std::string& head, const std::string& text, size_t width) {
  constexpr size_t kMinWidth = 24, kIndent = 6;
  const auto print_line = [](const std::string& line) {
    fmt::print("{}\n", line.substr(0, line.find_last_not_of(' ') + 1));
  };
  const bool is_below =
      width > 0 && width < head.size() + kMinWidth && head.size() + text.size() > width;
  if (is_below) print_line(head);
  const size_t indent = is_below ? kIndent : head.size();
  std::istringstream lines(wrapped(text, width > 0 ? std::max(width, indent + 1) - indent : 0));
  std::string line, before = is_below ? std::string(kIndent, ' ') : head;
  while (std::getline(lines, line)) {
    print_line(before + line);
    before.assign(indent, ' ');
  }
  if (text.empty()) print_line(before);
}

/// Returns the description of a parameter, with its choices unless the description names them all.
std::string meaning(const Parameter& p) {
  const std::string doc = one_line(p.doc);
  const bool says_all = std::all_of(p.choices.begin(), p.choices.end(), [&](const char* name) {
    return doc.find(name) != std::string::npos;
  });
  return says_all ? doc : fmt::format("{} (one of {})", doc, fmt::join(p.choices, ", "));
}

void print_plugin(Category category, const std::string& name, const PluginDescriptor& plugin,
                  const std::vector<InstructionSet>& sets) {
  fmt::print("{}/{}", to_string(category), name);
  if (name != plugin.name) fmt::print(" (another name for {})", plugin.name);
  fmt::print("\n");
  const size_t line = line_width();
  print_wrapped("  ", one_line(plugin.doc), line);
  if (sets.size() > 1) {
    std::vector<std::string> names;
    for (const InstructionSet set : sets) {
      const std::string usable = to_string(std::max(set, min_instruction_set()));
      if (names.empty() || names.back() != usable) names.push_back(usable);
    }
    print_wrapped("  ", fmt::format("built for {}", fmt::join(names, ", ")), line);
  }
  std::vector<std::vector<std::string>> rows = {{"parameter", "type", "default", "meaning"}};
  for (const Parameter& p : plugin.parameters) {
    rows.push_back({p.name, type_name(p), default_text(p), meaning(p)});
  }
  if (rows.size() == 1) {
    fmt::print("  no parameters\n");
    return;
  }
  size_t width[3] = {0, 0, 0};
  for (const auto& row : rows) {
    for (size_t i = 0; i < 3; ++i) width[i] = std::max(width[i], row[i].size());
  }
  for (const auto& row : rows) {
    print_wrapped(fmt::format("  {:<{}}  {:<{}}  {:<{}}  ", row[0], width[0], row[1], width[1],
                              row[2], width[2]),
                  row[3], line);
  }
}

/// Escapes bars, which would end a table's cell.
std::string cell(const std::string& text) {
  std::string escaped;
  for (const char c : text) escaped += c == '|' ? std::string("\\|") : std::string(1, c);
  return escaped;
}

/// Prints a page in Markdown about one plugin.
void print_page(Category category, const std::string& name, const PluginDescriptor& plugin) {
  fmt::print("# {}\n\n", name);
  if (name != plugin.name) fmt::print("Another name for `{}`. ", plugin.name);
  fmt::print("{}\n\n", one_line(plugin.doc));
  if (plugin.parameters.empty()) {
    fmt::print("This {} has no parameters.\n", to_string(category));
    return;
  }
  fmt::print("| parameter | type | default | meaning |\n|---|---|---|---|\n");
  for (const Parameter& p : plugin.parameters) {
    const std::string value = default_text(p);
    const char* const mark = p.type == ParameterType::kObject ? "*" : "`";
    fmt::print("| {}{}{} | {} | {} | {} |\n", mark, p.name, mark, type_name(p),
               p.required || p.ignored || value.empty() ? value : fmt::format("`{}`", value),
               cell(meaning(p)));
  }
}

std::string parameters_in_markdown(const PluginDescriptor& plugin) {
  std::string text;
  for (const Parameter& p : plugin.parameters) {
    if (!text.empty()) text += ", ";
    const bool is_by_category = p.type == ParameterType::kObject && !p.by_name;
    const char* const mark = p.type == ParameterType::kObject ? "*" : "`";
    text += fmt::format("{}{}{}", mark, is_by_category ? type_name(p) : p.name, mark);
    const std::string value = default_text(p);
    if (!value.empty()) text += fmt::format(" ({})", value);
  }
  return text;
}

void print_markdown(PluginRegistry& registry) {
  fmt::print("| category | plugin | what it is | parameters (default) |\n|---|---|---|---|\n");
  for (const Category category : kCategories) {
    // A plugin's aliases are files that load as the same library.
    std::map<const PluginDescriptor*, std::string> names;
    std::vector<const PluginDescriptor*> plugins;
    for (const std::string& name : registry.names(category)) {
      const PluginDescriptor& plugin = registry.find(category, name);
      std::string& all = names[&plugin];
      if (all.empty()) plugins.push_back(&plugin);
      all += fmt::format("{}`{}`", all.empty() ? "" : ", ", name);
    }
    for (const PluginDescriptor* plugin : plugins) {
      fmt::print("| {} | {} | {} | {} |\n", to_string(category), names[plugin],
                 one_line(plugin->doc), parameters_in_markdown(*plugin));
    }
  }
}

/// Prints the plugins of some categories. Continues after a library that can't be loaded, and
/// returns exit status 1 in that case.
int print_list(PluginRegistry& registry, std::span<const Category> categories) {
  int status = 0;
  for (const Category category : categories) {
    fmt::print("{}\n", to_string(category));
    for (const std::string& name : registry.names(category)) {
      std::string text;
      try {
        const PluginDescriptor& plugin = registry.find(category, name);
        text = name == plugin.name ? one_line(plugin.doc)
                                   : fmt::format("another name for {}", plugin.name);
      } catch (const Error& error) {
        text = std::string("can't be loaded: ") + error.what();
        status = 1;
      }
      print_wrapped(fmt::format("  {:<16} ", name), text, line_width());
    }
  }
  return status;
}

/// Prints a plugin, or the plugins of a category.
int print_named(PluginRegistry& registry, const std::string& wanted, bool markdown) {
  std::vector<std::string> known;
  bool found = false;
  for (const Category category : kCategories) {
    if (wanted == to_string(category)) return print_list(registry, {&category, 1});
    known.emplace_back(to_string(category));
  }
  for (const Category category : kCategories) {
    for (const std::string& name : registry.names(category)) {
      const std::string full = fmt::format("{}/{}", to_string(category), name);
      known.push_back(name);
      if (wanted != name && wanted != full) continue;
      if (found) fmt::print("\n");
      const PluginDescriptor& plugin = registry.find(category, name);
      if (markdown) {
        print_page(category, name, plugin);
      } else {
        print_plugin(category, name, plugin, registry.instruction_sets(category, name));
      }
      found = true;
    }
  }
  if (found) return 0;
  const std::string near = nearest_name(wanted, known);
  throw Error(fmt::format("unknown plugin '{}'{}", wanted,
                          near.empty() ? " (`kinome plugins` lists all)" : did_you_mean(near)));
}

enum class Support { kYes, kPartly, kNo };

/// Returns the support for one of Mitsuba's plugins; `names` has the registry's, by category.
Support support_of(const std::map<std::string, std::vector<std::string>>& names,
                   const MitsubaPlugin& plugin) {
  // Mitsuba's spectra are textures of a constant colour.
  const auto known =
      names.find(plugin.category == "spectrum" ? "texture" : std::string(plugin.category));
  if (known == names.end() ||
      std::find(known->second.begin(), known->second.end(), plugin.name) == known->second.end()) {
    return Support::kNo;
  }
  return plugin.lacks ? Support::kPartly : Support::kYes;
}

/// Prints the support for Mitsuba's plugins: one per line, or in Markdown a category per row.
void print_mitsuba(PluginRegistry& registry, bool markdown) {
  std::map<std::string, std::vector<std::string>> names;
  for (const Category category : kCategories) {
    names[to_string(category)] = registry.names(category);
  }
  int counts[3] = {};
  std::vector<std::string> categories;
  std::map<std::string, std::vector<std::string>> cells[3];
  for (const MitsubaPlugin& plugin : mitsuba_plugins()) {
    const Support support = support_of(names, plugin);
    ++counts[static_cast<int>(support)];
    if (categories.empty() || categories.back() != plugin.category) {
      categories.emplace_back(plugin.category);
    }
    cells[static_cast<int>(support)][categories.back()].push_back(
        support == Support::kPartly ? fmt::format("`{}` ({})", plugin.name, plugin.lacks)
                                    : fmt::format("`{}`", plugin.name));
    if (markdown) continue;
    const std::string text = support == Support::kYes      ? "yes"
                             : support == Support::kPartly ? fmt::format("partly: {}", plugin.lacks)
                                                           : "no";
    print_wrapped(fmt::format("{:<11} {:<20} ", plugin.category, plugin.name), text, line_width());
  }
  if (markdown) {
    fmt::print("| category | yes | partly | no |\n|---|---|---|---|\n");
    for (const std::string& category : categories) {
      fmt::print("| {} | {} | {} | {} |\n", category, fmt::join(cells[0][category], ", "),
                 fmt::join(cells[1][category], "; "), fmt::join(cells[2][category], ", "));
    }
  }
  fmt::print("{}of {} plugins of Mitsuba 3.9.1: {} supported, {} partly, {} unsupported\n",
             markdown ? "\n" : "", counts[0] + counts[1] + counts[2], counts[0], counts[1],
             counts[2]);
}

}  // namespace

int plugins_command(const Options& options) {
  set_activity("listing plugins");
  warn_of_missing_folders(options);
  PluginRegistry registry(PluginRegistry::default_folders(options.plugin_paths),
                          choose_instruction_set(options.isa));
  if (!options.plugin_name.empty()) {
    return print_named(registry, options.plugin_name, options.markdown);
  }
  if (options.mitsuba) {
    print_mitsuba(registry, options.markdown);
    return 0;
  }
  if (!options.markdown) return print_list(registry, kCategories);
  print_markdown(registry);
  return 0;
}

}  // namespace kinome::app
