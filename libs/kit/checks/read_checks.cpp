// Checks that the plugin reads each parameter of its table, alone or together with another one.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "kit/checks/read_checks.h"

namespace kinome::check {
namespace {

enum class Reading { kRead, kUnread, kRefused };

/// Returns XML elements for the parameter, the ones most likely to be accepted first.
std::vector<std::string> elements_of(const Parameter& parameter) {
  if (parameter.type == ParameterType::kObject) {
    std::vector<std::string> objects = {needed_xml(parameter)};
    if (parameter.category == Category::kSensor) {
      objects.emplace_back("<sensor type=\"irradiancemeter\"/>");
    }
    return objects;
  }
  std::vector<std::string> values = values_of(parameter.type).usual;
  if (parameter.default_value) values.insert(values.begin(), parameter.default_value);
  if (parameter.type == ParameterType::kString) {
    values.insert(values.end(), parameter.choices.begin(), parameter.choices.end());
  }
  std::vector<std::string> elements;
  for (const std::string& value : values) elements.push_back(parameter_xml(parameter, value));
  return elements;
}

/// Loads the plugin with the XML `element` of the parameter `name`, and with the elements `beside`.
Reading load_with(const Subject& subject, const std::string& name, const std::string& element,
                  const std::string& beside = "") {
  try {
    subject.load(subject.xml(beside, name, element));
    return Reading::kRead;
  } catch (const Error& error) {
    return is_unread(error) ? Reading::kUnread : Reading::kRefused;
  }
}

/// Returns whether the plugin reads the parameter; Reading::kRefused if it accepts none of the
/// values.
Reading reading_of(const Subject& subject, const Parameter& parameter) {
  Reading reading = Reading::kRefused;
  for (const std::string& element : elements_of(parameter)) {
    note_attempt(element);
    const Reading alone = load_with(subject, parameter.name, element);
    if (alone == Reading::kRead) return alone;
    if (is_read_beside_another(subject, parameter.name, element)) return Reading::kRead;
    if (alone == Reading::kUnread) reading = alone;
  }
  return reading;
}

ParameterUse use_of(const Subject& subject) {
  ParameterUse use;
  for (const Parameter& parameter : subject.plugin().parameters) {
    // The plugin couldn't be created without these parameters.
    const bool is_there = parameter.required || subject.is_given(parameter);
    const Reading reading = is_there ? Reading::kRead
                            : parameter.ignored ? Reading::kRefused
                                                : reading_of(subject, parameter);
    std::vector<std::string>& names = parameter.ignored            ? use.ignored
                                      : reading == Reading::kRead   ? use.read
                                      : reading == Reading::kUnread ? use.unread
                                                                    : use.unknown;
    names.emplace_back(parameter.name);
  }
  return use;
}

}  // namespace

bool is_unread(const Error& error) {
  return error.message().find("has unused parameters") != std::string::npos;
}

bool is_read_beside_another(const Subject& subject, const std::string& name,
                            const std::string& element) {
  for (const Parameter& other : subject.plugin().parameters) {
    if (other.name == name || other.required || other.ignored || subject.is_given(other)) continue;
    for (const std::string& beside : elements_of(other)) {
      if (load_with(subject, name, element, beside) == Reading::kRead) return true;
    }
  }
  return false;
}

void add_read_check(const Subject& subject, Plan& plan) {
  plan.add("reads", 0, [&subject](double) {
    Outcome outcome;
    const ParameterUse use = use_of(subject);
    for (const std::string& name : use.unread) {
      outcome.fail(
          fmt::format("'{}' is in the table but is never read, alone or together with "
                      "another parameter: read it, or declare it with ignored_row()",
                      name));
    }
    outcome.measured = fmt::format("{} parameters are read, {} ignored", use.read.size(),
                                   use.ignored.size());
    if (!use.unknown.empty()) {
      outcome.measured += fmt::format("; unknown for {}, for which -D must give values",
                                      fmt::join(use.unknown, ", "));
    }
    return outcome;
  });
}

ParameterUse parameter_use(const Request& request) {
  return use_of(Subject(request));
}

}  // namespace kinome::check
