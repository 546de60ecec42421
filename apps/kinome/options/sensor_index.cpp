#include "options/sensor_index.h"

#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "kinome/error.h"
#include "options/interpret_options.h"

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
  const size_t count = sensors.size();
  if (parse_in_range(wanted, size_t{0}, count - 1, index).empty()) return index;
  const std::string known = count == 1 ? "the scene has only one, 0"
                                       : fmt::format("the scene has {}, 0 to {}", count, count - 1);
  constexpr size_t kMaxListed = 5;
  const bool is_list = !ids.empty() && ids.size() <= kMaxListed;
  const std::string by_id = is_list ? fmt::format(" ('{}')", fmt::join(ids, "', '"))
                                    : did_you_mean(nearest_name(wanted, ids));
  throw Error(where, fmt::format("unknown sensor '{}': {}{}", wanted, known, by_id));
}

}  // namespace kinome::app
