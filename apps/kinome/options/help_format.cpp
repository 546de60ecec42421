#include "options/help_format.h"

#include <algorithm>

#include <CLI/CLI.hpp>

#include "options/line_width.h"

namespace kinome::app {
namespace {

class HelpFormatter final : public CLI::Formatter {
 public:
  HelpFormatter() { label("Positionals", "Arguments"); }

  std::string make_usage(const CLI::App* app, std::string /*name*/) const override {
    std::string text = "\nUsage: " + app->get_name() + " [OPTION]...";
    for (const CLI::Option* argument : app->get_options()) {
      if (argument->get_positional()) text += " " + make_option_usage(argument);
    }
    return text + "\n";
  }
  std::string make_help(const CLI::App* app, std::string name,
                        CLI::AppFormatMode /*mode*/) const override {
    std::string text = make_description(app) + make_usage(app, name) + make_positionals(app);
    for (const std::string& group : app->get_groups()) {
      const auto options = app->get_options([&group](const CLI::Option* option) {
        return option->get_group() == group && option->nonpositional();
      });
      if (!options.empty()) text += make_group(group, false, options);
    }
    return text + "\n" + make_footer(app);
  }
  std::string make_option_name(const CLI::Option* option, bool is_positional) const override {
    if (is_positional) return option->get_name(true, false);
    std::string text;
    for (const std::string& name : names_of(*option)) text += (text.empty() ? "" : ", ") + name;
    return text + value_of(*option);
  }
  std::string make_option_opts(const CLI::Option* /*option*/) const override { return ""; }
  std::string make_option_desc(const CLI::Option* option) const override {
    constexpr size_t kMinWidth = 24;
    const size_t width = line_width(), names = get_column_width();
    const bool is_mandatory = option->get_required() && option->nonpositional();
    return wrapped(option->get_description() + (is_mandatory ? " (required)" : ""),
                   width == 0 ? 0 : std::max(width, names + kMinWidth) - names);
  }
};

}  // namespace

std::shared_ptr<CLI::FormatterBase> make_help_formatter() {
  return std::make_shared<HelpFormatter>();
}

std::vector<std::string> names_of(const CLI::Option& option) {
  std::vector<std::string> names;
  for (const std::string& name : option.get_snames()) names.push_back("-" + name);
  for (const std::string& name : option.get_lnames()) names.push_back("--" + name);
  return names;
}

bool takes_value(const CLI::Option& option) {
  return option.get_expected_min() > 0;
}

std::string value_of(const CLI::Option& option) {
  // The type of a flag with an optional value is "[=COUNT]".
  const std::string type = option.get_type_name();
  if (takes_value(option)) return " " + type;
  return type.starts_with("[=") ? type : "";
}

}  // namespace kinome::app
