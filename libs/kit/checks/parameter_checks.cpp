// Checks that a plugin either accepts each value of a parameter, or refuses it with one Error that
// has a location.

#include <cmath>

#include <fmt/format.h>

#include "kinome/error.h"
#include "kinome/plugin_audit.h"
#include "kit/checks/read_checks.h"
#include "kit/subject.h"

namespace kinome::check {
namespace {

/// Returns what is wrong with an error, or nullptr.
const char* fault_of(const Error& error) {
  if (error.message().empty()) return "an error without a message";
  if (std::string(error.what()).find('\n') != std::string::npos) {
    return "an error with several lines";
  }
  if (is_foreign_exception(error)) return "an exception that is not a kinome::Error";
  const bool has_location = error.where().line > 0 || !error.requesters().empty();
  return has_location ? nullptr : "an error without a location";
}

/// Returns a fault if the object returns invalid values at some points of a scene, otherwise "".
std::string find_invalid_result(const Subject& subject, const std::string& xml) {
  const std::string elements = surroundings(subject, xml);
  if (elements.empty()) {
    subject.load(xml);
    return "";
  }
  const auto scene = subject.scene(elements);
  constexpr uint32_t kPoints = 32;
  for (const PluginFault& fault :
       audit_plugins(*scene, *scene->sensors()[0], subject.request().seed, kPoints)) {
    // Ignore other faults: with extreme parameters, functions may differ by more than the usual
    // rounding error.
    if (fault.what.find("not finite") != std::string::npos ||
        fault.what.find("negative") != std::string::npos || fault.what == "an exception") {
      return fault.plugin + " gives " + fault.what;
    }
  }
  return "";
}

struct Counts {
  int accepted = 0, refused = 0;
};

void try_value(const Subject& subject, const Parameter& parameter, const std::string& value,
               bool may_be_accepted, Counts& counts, Outcome& outcome) {
  const std::string title = fmt::format("{} = \"{}\"", parameter.name, value);
  note_attempt(title);
  try {
    const std::string fault = find_invalid_result(
        subject, subject.xml("", parameter.name, parameter_xml(parameter, value)));
    ++counts.accepted;
    if (!may_be_accepted) outcome.fail(title + " is invalid, but is accepted");
    if (!fault.empty()) outcome.fail(title + " is accepted, but then " + fault);
  } catch (const Error& error) {
    ++counts.refused;
    if (const char* const fault = fault_of(error)) {
      outcome.fail(fmt::format("{}: {} ({})", title, fault, error.what()));
    }
  } catch (const std::bad_alloc&) {
    outcome.fail(title + " uses all memory");
  }
}

/// Writes each default value into a scene, which must accept it like any other value.
void check_table(const Subject& subject, Outcome& outcome) {
  for (const Parameter& parameter : subject.plugin().parameters) {
    if (!parameter.default_value || parameter.type == ParameterType::kObject) continue;
    note_attempt(fmt::format("{} = \"{}\", its default", parameter.name, parameter.default_value));
    const std::string written = parameter.default_value;
    const std::string element = parameter_xml(parameter, written);
    try {
      subject.load(subject.xml("", parameter.name, element));
    } catch (const Error& error) {
      if (is_unread(error) && is_read_beside_another(subject, parameter.name, element)) continue;
      outcome.fail(fmt::format("the default of '{}', \"{}\", can't be written in a scene: {}",
                               parameter.name, written, error.what()));
    }
  }
}

}  // namespace

void add_parameter_checks(const Subject& subject, Plan& plan) {
  plan.add("defaults", 0, [&subject](double) {
    Outcome outcome;
    subject.load(subject.xml());
    check_table(subject, outcome);
    outcome.measured = fmt::format("{} parameters", subject.plugin().parameters.size());
    return outcome;
  });
  plan.add("parameters", 0, [&subject](double) {
    Outcome outcome;
    Counts counts;
    for (const Parameter& parameter : subject.plugin().parameters) {
      if (parameter.ignored) continue;
      const TypeValues values = values_of(parameter.type);
      for (const std::string& value : values.extreme) {
        try_value(subject, parameter, value, true, counts, outcome);
      }
      for (const std::string& value : values.invalid) {
        try_value(subject, parameter, value, false, counts, outcome);
      }
    }
    outcome.measured = fmt::format("extreme and invalid values: {} accepted, {} refused",
                                   counts.accepted, counts.refused);
    return outcome;
  });
}

}  // namespace kinome::check
