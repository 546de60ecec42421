#include "kit/subject.h"

#include <algorithm>

#include <fmt/format.h>

namespace kinome::check {
namespace {

bool works_without_parameters(const Subject& subject) {
  Request request = subject.request();
  request.parameters.clear();
  try {
    const Subject without(request);
    without.load(without.xml());
    return true;
  } catch (const Error&) {
    return false;
  }
}

/// Returns the line of check.xml at which the error occurred, or which names the file in which it
/// occurred; 0 if there is none.
int line_in_xml(const Error& error) {
  if (error.where().file == Subject::kFile) return error.where().line;
  for (const Location& requester : error.requesters()) {
    if (requester.file == Subject::kFile) return requester.line;
  }
  return 0;
}

/// Returns the message for an error of the command line, or "" if the plugin is at fault.
std::string command_line_error(const Subject& subject, const Error& error) {
  if (is_foreign_exception(error)) return "";
  std::string text = error.message();
  if (error.where().line > 0 && error.where().file != Subject::kFile) {
    text = to_string(error.where()) + ": " + text;
  }
  int next = 2;  // Subject::xml() begins a line with each parameter
  for (const auto& [name, value] : subject.request().parameters) {
    const int first = next;
    next += 1 + static_cast<int>(std::count(value.begin(), value.end(), '\n'));
    const int line = line_in_xml(error);
    if (line >= first && line < next) return fmt::format("-D {}={}: {}", name, value, text);
  }
  // For example, two values that can't be combined.
  if (next > 2 && works_without_parameters(subject)) return "-D: " + text;
  return "";
}

}  // namespace

bool can_be_created(const Subject& subject) {
  const Outcome made = run_in_process([&] {
    Outcome outcome;
    try {
      subject.load(subject.xml());
    } catch (const Error& error) {
      outcome.measured = command_line_error(subject, error);
      if (outcome.measured.empty()) outcome.fail(error.what());
    }
    return outcome;
  });
  if (made.passed && !made.measured.empty()) throw Error(made.measured);
  return made.passed;
}

}  // namespace kinome::check
