#include "sensor_index.h"

#include <charconv>
#include <vector>

#include <fmt/format.h>

#include "kinome/error.h"

namespace kinome::app {

size_t sensor_index(const Scene& scene, const std::string& wanted) {
  const auto& sensors = scene.sensors();
  const Location where{scene.file()};
  if (sensors.empty()) throw Error(where, "the scene has no sensor");
  std::vector<std::string> ids;
  for (size_t i = 0; i < sensors.size(); ++i) {
    const std::string& id = sensors[i]->id();
    if (id == wanted) return i;
    if (!id.empty()) ids.push_back(id);
  }
  size_t index = 0;
  const char* end = wanted.data() + wanted.size();
  const auto [rest, error] = std::from_chars(wanted.data(), end, index);
  if (error == std::errc{} && rest == end && index < sensors.size()) return index;
  const std::string near = nearest_name(wanted, ids);
  throw Error(where, fmt::format("no sensor '{}': expected an index from 0 to {}{}", wanted,
                                 sensors.size() - 1,
                                 near.empty() ? " or a sensor's id" : " or '" + near + "'"));
}

}  // namespace kinome::app
