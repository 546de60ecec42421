// Functions of a RenderSession that trace rays for the user interface.

#include "session/render_session.h"

#include <algorithm>
#include <set>

namespace kinome::viewer {
namespace {

void add_materials(const Object& object, const SceneEditor& editor,
                   std::vector<std::string>& paths) {
  const std::string path = editor.path_of(object);
  if (!path.empty() && std::find(paths.begin(), paths.end(), path) == paths.end()) {
    paths.push_back(path);
  }
  for (const auto& part : object.nested()) add_materials(*part, editor, paths);
}

/// Returns the shape at a path and its parts, of which rays hit the parts if there are any.
std::set<const Object*> hit_objects(const SceneEditor& editor, const std::string& path) {
  const auto found = editor.object_at(path);
  if (!found) return {};
  std::set<const Object*> objects{found->object};
  if (const auto* const shape = dynamic_cast<const Shape*>(found->object)) {
    for (const auto& part : shape->parts()) objects.insert(part.get());
  }
  return objects;
}

/// Number of rays after which the scene may be changed while an outline is traced.
constexpr int kRaysOfBand = 1 << 14;

/// Shapes of a scene, by their indices.
using ShapeSet = std::vector<bool>;

/// Traces `rows` rows of a grid, from `first` on. Appends for each cell whether a ray through its
/// centre hits one of the shapes first.
void trace_cells(const Scene& scene, const Sensor& sensor, const ShapeSet& shapes,
                 const CellGrid& grid, int first, int rows, std::vector<bool>& is_inside) {
  std::vector<RayHit> rays(static_cast<size_t>(grid.columns) * rows);
  for (int y = 0; y < rows; ++y) {
    for (int x = 0; x < grid.columns; ++x) {
      rays[static_cast<size_t>(y) * grid.columns + x].ray =
          sensor.sample_ray(grid.centre(x, first + y), Vec2(0.5f));
    }
  }
  RenderCounters counters;
  scene.intersect(rays, Coherence::kCoherent, counters);
  for (const RayHit& ray : rays) {
    is_inside.push_back(ray.hit.valid() && shapes[ray.hit.shape]);
  }
}

}  // namespace

std::shared_ptr<const PickAnswer> RenderSession::ask_pick(const Vec2& film_position) {
  auto answer = std::make_shared<PickAnswer>();
  const std::unique_lock lock(scene_mutex_, std::try_to_lock);
  if (lock) {
    answer->give(picked(film_position));
    return answer;
  }
  request(false, {Request::Kind::kOther, [=, this] { answer->give(pick(film_position)); },
                  [=] { answer->give(std::nullopt); }});
  return answer;
}

std::optional<Pick> RenderSession::pick(const Vec2& film_position) const {
  const std::lock_guard lock(scene_mutex_);
  return picked(film_position);
}

/// The caller must hold scene_mutex_.
std::optional<Pick> RenderSession::picked(const Vec2& film_position) const {
  if (!scene_ || scene_->sensors().empty()) return std::nullopt;
  RayHit hit;
  hit.ray = sensor().sample_ray(film_position, Vec2(0.5f));
  RenderCounters counters;
  scene_->intersect({&hit, 1}, Coherence::kIncoherent, counters);
  if (!hit.hit.valid()) return std::nullopt;
  const SurfaceInteraction si = scene_->interaction(hit);
  Pick pick;
  pick.origin = hit.ray.o;
  pick.direction = hit.ray.d;
  pick.point = si.p;
  pick.normal = si.frame.n;
  pick.distance = hit.ray.tmax;
  pick.shape = editor_->path_of(*si.shape);
  pick.bounds = si.shape->bounds();
  add_materials(si.shape->bsdf(), *editor_, pick.materials);
  if (si.shape->emitter()) pick.emitter = editor_->path_of(*si.shape->emitter());
  return pick;
}

std::optional<Outline> RenderSession::outline(const Picture& picture, const std::string& shape,
                                              float cell, bool may_wait) const {
  if (!picture.sensor || shape.empty()) return Outline{};
  std::shared_ptr<const Scene> scene;
  ShapeSet shapes;
  CellGrid grid;
  std::vector<bool> is_inside;
  int row = 0;
  do {
    std::unique_lock lock(scene_mutex_, std::defer_lock);
    may_wait ? lock.lock() : static_cast<void>(lock.try_lock());
    if (!lock || !scene_ || (scene && scene != scene_)) return std::nullopt;
    if (!scene) {
      scene = scene_;
      Aabb bounds;
      const std::set<const Object*> parts = hit_objects(*editor_, shape);
      for (const auto& other : scene->shapes()) {
        shapes.push_back(parts.count(other.get()) > 0);
        if (shapes.back()) bounds.expand(other->bounds());
      }
      if (bounds.empty()) return Outline{};
      grid = grid_around(bounds, *picture.sensor, picture.crop, cell);
      if (grid.columns == 0) break;
    }
    const int rows = std::min(std::max(1, kRaysOfBand / grid.columns), grid.rows - row);
    trace_cells(*scene, *picture.sensor, shapes, grid, row, rows, is_inside);
    row += rows;
  } while (row < grid.rows);
  return outline_of(is_inside, grid);
}

}  // namespace kinome::viewer
