#include "render/trace_file.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace kinome::app {

std::string trace_json(const Timeline& timeline) {
  using nlohmann::json;
  constexpr double kMicroseconds = 1e6;
  json events = json::array();
  for (size_t thread = 0; thread < timeline.events().size(); ++thread) {
    const json place = {{"pid", 1}, {"tid", thread}};
    json name = {{"name", "thread_name"},
                 {"ph", "M"},
                 {"args", {{"name", fmt::format("thread {}", thread)}}}};
    name.update(place);
    events.push_back(std::move(name));
    for (const Timeline::Event& event : timeline.events()[thread]) {
      const Timeline::Part& part = timeline.parts()[event.part];
      const std::string stage = part.stage.empty() ? "other" : part.stage;
      json one = {{"name", event.is_commit ? "commit" : stage},
                  {"cat", part.is_loop ? "loop" : "serial"},
                  {"ph", "X"},
                  {"ts", kMicroseconds * event.begin},
                  {"dur", kMicroseconds * (event.end - event.begin)},
                  {"args", {{"stage", stage}, {"part", event.part}, {"item", event.item}}}};
      one.update(place);
      events.push_back(std::move(one));
    }
  }
  return json{{"displayTimeUnit", "ms"}, {"traceEvents", std::move(events)}}.dump() + "\n";
}

}  // namespace kinome::app
