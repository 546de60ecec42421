#include "picture/inspector.h"

#include <algorithm>
#include <type_traits>

#include "drawing/inspection_image.h"
#include "kinome/object_description.h"
#include "kinome/render_context.h"

namespace kinome::viewer {
namespace {

/// Returns the scene's own settings of `clustered`, with this importance function.
ObjectDescription integrator_of(const SceneEditor& editor, const std::string& importance) {
  ObjectDescription description{
      .tag = "integrator", .type = "clustered", .where = {"the inspector"}};
  description.values.push_back({"importance", importance, description.where});
  for (const SceneParameter& parameter : editor.parameters()) {
    if (parameter.plugin != "integrator/clustered" || !parameter.is_set || !parameter.value)
      continue;
    const std::string name = parameter.path.substr(parameter.path.rfind('.') + 1);
    if (name == "importance") continue;
    std::visit(
        [&](const auto& value) {
          if constexpr (std::is_constructible_v<Properties::Value, decltype(value)>) {
            description.values.push_back({name, value, description.where});
          }
        },
        *parameter.value);
  }
  return description;
}

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

InspectedSet draw(Inspection report, const Scene& scene, const Sensor& sensor) {
  drawing::InspectionView view = drawing::inspection_view(report, scene, sensor);
  InspectionMarks marks = marks_of(report, sensor);
  return {std::move(report), std::move(view.canvas.image), std::move(marks)};
}

}  // namespace

void InspectionMarks::move(const Vec2& offset) {
  if (point) *point += offset;
  for (Line& line : lines) line.from += offset, line.to += offset;
  for (Edge& edge : edges) edge.from += offset, edge.to += offset;
}

InspectedPixel inspect_pixel(SceneEditor& editor, const Sensor& sensor, unsigned threads,
                             const Vec2& pixel, const std::string& importance) {
  InspectedPixel found{glm::floor(pixel), importance, {}, {}};
  try {
    const auto scene = editor.scene_with(integrator_of(editor, importance));
    RenderContext context({.threads = threads});
    for (Inspection& report :
         scene->integrator().inspect(*scene, sensor, context, found.pixel + 0.5f)) {
      found.sets.push_back(draw(std::move(report), *scene, sensor));
    }
    if (found.sets.empty()) found.fault = drawing::kNoLightPoints;
  } catch (const std::exception& fault) {
    found.sets.clear();
    found.fault = fault.what();
  }
  return found;
}

}  // namespace kinome::viewer
