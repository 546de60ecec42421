#include "check/given_parameters.h"

#include <algorithm>

#include <fmt/format.h>

namespace kinome::check {
namespace {

void make(const Subject& subject) {
  load_object_from_string(subject.xml(), Subject::kFile, {}, subject.registry());
}

bool works_without_parameters(const Subject& subject) {
  Request request = subject.request();
  request.parameters.clear();
  try {
    make(Subject(request));
    return true;
  } catch (const Error&) {
    return false;
  }
}

/// The line of check.xml where it arose, or where the file is named in which it did; 0: there is none.
int line_in_xml(const Error& error) {
  if (error.where().file == Subject::kFile) return error.where().line;
  for (const Location& asker : error.askers()) {
    if (asker.file == Subject::kFile) return asker.line;
  }
  return 0;
}

/// What the command line does wrong by this error; "": nothing, the plugin does.
std::string mistake_of(const Subject& subject, const Error& error) {
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
  // Such as two values that don't go together.
  if (next > 2 && works_without_parameters(subject)) return "-D: " + text;
  return "";
}

}  // namespace

bool can_be_made(const Subject& subject) {
  const Outcome made = run_apart([&] {
    Outcome outcome;
    try {
      make(subject);
    } catch (const Error& error) {
      outcome.measured = mistake_of(subject, error);
      if (outcome.measured.empty()) outcome.fail(error.what());
    }
    return outcome;
  });
  if (made.passed && !made.measured.empty()) throw Error(made.measured);
  return made.passed;
}

}  // namespace kinome::check
