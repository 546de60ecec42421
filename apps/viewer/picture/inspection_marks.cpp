#include "picture/inspection_marks.h"

#include <algorithm>
#include <cmath>

namespace kinome::viewer {
namespace {

constexpr size_t kMaxBoxes = 200;

std::optional<Vec2> find(const Sensor& sensor, const Vec3& position) {
  const auto connection = sensor.connect(position, Vec2(0.5f));
  if (!connection) return std::nullopt;
  return connection->film_position;
}

/// Divides a line into `parts` equal parts, and calls add(from, to) for each visible one.
template <class Add>
void add_parts(const Sensor& sensor, const Vec3& from, const Vec3& to, int parts, const Add& add) {
  std::optional<Vec2> last = find(sensor, from);
  for (int i = 1; i <= parts; ++i) {
    const auto next =
        find(sensor, glm::mix(from, to, static_cast<float>(i) / static_cast<float>(parts)));
    if (last && next) add(*last, *next);
    last = next;
  }
}

void add_box(const Sensor& sensor, const Aabb& box, float share, InspectionMarks& marks) {
  const auto corner = [&](int i) {
    return Vec3(i & 1 ? box.hi.x : box.lo.x, i & 2 ? box.hi.y : box.lo.y,
                i & 4 ? box.hi.z : box.lo.z);
  };
  for (int i = 0; i < 8; ++i) {
    for (const int bit : {1, 2, 4}) {
      if (i & bit) continue;
      add_parts(sensor, corner(i), corner(i | bit), 6, [&](const Vec2& a, const Vec2& b) {
        marks.edges.push_back({a, b, share});
      });
    }
  }
}

}  // namespace

void InspectionMarks::move(const Vec2& offset) {
  if (point) *point += offset;
  for (Line& line : lines) line.from += offset, line.to += offset;
  for (Edge& edge : edges) edge.from += offset, edge.to += offset;
}

InspectionMarks marks_of(const Inspection& report, const Sensor& sensor) {
  InspectionMarks marks;
  marks.point = find(sensor, report.position);
  const bool distant = report.is_distant;
  float length = 0;
  if (distant) {
    const auto connection = sensor.connect(report.position, Vec2(0.5f));
    if (connection) length = connection->distance / 7;
  }
  for (const InspectedSample& sample : report.samples) {
    const Vec3 to = distant ? report.position + length * sample.position : sample.position;
    add_parts(sensor, report.position, to, distant ? 4 : 16, [&](const Vec2& a, const Vec2& b) {
      marks.lines.push_back({a, b, sample.visible});
    });
  }
  if (distant) return marks;
  std::vector<const InspectedCluster*> chosen;
  for (const InspectedCluster& cluster : report.clusters) {
    if (cluster.probability > 0) chosen.push_back(&cluster);
  }
  std::sort(chosen.begin(), chosen.end(),
            [](auto* a, auto* b) { return a->probability > b->probability; });
  chosen.resize(std::min(chosen.size(), kMaxBoxes));
  for (const InspectedCluster* cluster : chosen) {
    add_box(sensor, cluster->box,
            static_cast<float>(cluster->probability / chosen.front()->probability), marks);
  }
  return marks;
}

}  // namespace kinome::viewer
