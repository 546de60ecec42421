#include "handles/transform_handles.h"

#include <imgui.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <variant>

#include "panels/widgets.h"

namespace kinome::viewer {
namespace {

/// Length of an arrow, and parts of it: start of the arrow's line, the square's near and far sides,
/// and the radius of the rings.
constexpr float kArrowLength = 92, kArrowStart = 0.16f, kSquareNear = 0.26f, kSquareFar = 0.42f,
                kRingRadius = 0.72f;
constexpr float kCentreRadius = 7;
/// Maximum distance of the mouse from a line [pixels of the window].
constexpr float kReach = 6;
/// Arrows that are shorter on the screen are hidden, because they point at the user. Squares and
/// rings that are seen from the side are hidden: kMinFacing is the minimum cosine between their
/// axis and the viewing direction.
constexpr float kMinArrow = 0.2f, kMinFacing = 0.12f;
constexpr int kRingSteps = 48;
/// Depth from which a part of a ring is behind its centre, as a fraction of the radius. A ring that
/// faces the user is drawn completely.
constexpr float kMinDepthBehind = 0.25f;
/// Distance over which the image of an axis is measured, as a fraction of the camera's distance.
constexpr float kProbe = 0.01f;
constexpr ImU32 kAxisColors[] = {IM_COL32(235, 77, 75, 255), IM_COL32(106, 190, 48, 255),
                                 IM_COL32(72, 140, 255, 255)};
constexpr ImU32 kHotColor = IM_COL32(255, 225, 90, 255);
constexpr ImU32 kEdgeColor = IM_COL32(0, 0, 0, 140);
constexpr ImU32 kCentreColor = IM_COL32(235, 235, 235, 255);

ImVec2 im(const Vec2& v) {
  return {v.x, v.y};
}

ImU32 with_alpha(ImU32 color, int alpha) {
  return (color & ~IM_COL32_A_MASK) | (static_cast<ImU32>(alpha) << IM_COL32_A_SHIFT);
}

float distance_to_line(const Vec2& p, const Vec2& a, const Vec2& b) {
  const Vec2 way = b - a;
  const float length2 = glm::dot(way, way);
  const float t = length2 > 0 ? std::clamp(glm::dot(p - a, way) / length2, 0.f, 1.f) : 0.f;
  return glm::length(p - a - t * way);
}

float cross_of(const Vec2& a, const Vec2& b) {
  return a.x * b.y - a.y * b.x;
}

/// Returns true if p is in a convex quadrilateral.
bool is_in(const std::array<Vec2, 4>& corners, const Vec2& p) {
  int left = 0;
  for (size_t i = 0; i < 4; ++i) {
    left += cross_of(corners[(i + 1) % 4] - corners[i], p - corners[i]) > 0;
  }
  return left == 0 || left == 4;
}

Handle handle_of(int first, int axis) {
  return static_cast<Handle>(first + axis);
}
constexpr int kMoves = static_cast<int>(Handle::kMoveX),
              kPlanes = static_cast<int>(Handle::kMoveYZ),
              kTurns = static_cast<int>(Handle::kTurnX);

}  // namespace

std::optional<Placement> placement_of(const SceneInfo& info, const ParameterWidgets& widgets,
                                      const std::string& object) {
  if (object.empty()) return std::nullopt;
  const auto find = [&](const char* name) -> std::optional<Placement> {
    const SceneParameter* const parameter = info.find(object + name);
    auto value = parameter ? widgets.value(*parameter) : std::nullopt;
    if (!value) return std::nullopt;
    return Placement{parameter->path, std::move(*value)};
  };
  auto moved = find(".to_world");
  const auto* const transform = moved ? std::get_if<Transform>(&moved->value) : nullptr;
  if (!transform || transform->is_identity()) {
    // If to_world is missing or the identity, edits the position, which is simpler.
    for (const char* const name : {".center", ".position"}) {
      auto placed = find(name);
      const auto* const point = placed ? std::get_if<Vec3>(&placed->value) : nullptr;
      if (!point) continue;
      placed->position = *point;
      placed->can_turn = false;
      return placed;
    }
  }
  if (!transform) return std::nullopt;
  moved->position = Vec3(transform->matrix()[3]);
  return moved;
}

std::optional<TransformHandles::Screen> TransformHandles::on_screen(const Frame& frame,
                                                                    const Vec3& position,
                                                                    bool can_turn) {
  if (!frame.picture) return std::nullopt;
  const PictureArea& area = frame.view.area();
  const auto seen = place_on_film(*frame.picture, position);
  if (!seen) return std::nullopt;
  const CameraControls& camera = frame.camera.controls();
  const float step = kProbe * std::max(1e-6f, glm::length(position - camera.origin()));
  Screen screen;
  screen.centre = area.to_window(*seen);
  screen.can_turn = can_turn;
  float sum = 0;
  for (int i = 0; i < 3; ++i) {
    Vec3 axis(0.f);
    axis[i] = 1;
    // Near the edge of the image, only one of the two points is visible.
    auto end = place_on_film(*frame.picture, position + step * axis);
    float sign = 1;
    if (!end) {
      end = place_on_film(*frame.picture, position - step * axis);
      sign = -1;
    }
    if (!end) return std::nullopt;
    screen.axes[i] = sign * (area.to_window(*end) - screen.centre);
    screen.depth[i] = camera.forward()[i];
    sum += glm::dot(screen.axes[i], screen.axes[i]);
  }
  // In a parallel projection, the images of three orthogonal unit vectors have a mean square of
  // 2/3.
  const float length = std::sqrt(0.5f * sum);
  if (!(length > 0)) return std::nullopt;
  for (Vec2& axis : screen.axes) axis *= kArrowLength * display_scale() / length;
  return screen;
}

Vec2 TransformHandles::Screen::on_ring(int axis, float angle) const {
  return centre + kRingRadius * (std::cos(angle) * axes[(axis + 1) % 3] +
                                 std::sin(angle) * axes[(axis + 2) % 3]);
}

float TransformHandles::Screen::ring_depth(int axis, float angle) const {
  return std::cos(angle) * depth[(axis + 1) % 3] + std::sin(angle) * depth[(axis + 2) % 3];
}

std::array<Vec2, 4> TransformHandles::Screen::square(int axis) const {
  const Vec2 a = axes[(axis + 1) % 3], b = axes[(axis + 2) % 3];
  return {centre + kSquareNear * (a + b), centre + kSquareFar * a + kSquareNear * b,
          centre + kSquareFar * (a + b), centre + kSquareNear * a + kSquareFar * b};
}

bool TransformHandles::Screen::shows(Handle handle) const {
  const int axis = axis_of(handle);
  if (axis < 0) return true;
  const float facing = std::abs(depth[axis]);
  if (handle <= Handle::kMoveZ) return std::sqrt(std::max(0.f, 1 - facing * facing)) > kMinArrow;
  return facing > kMinFacing && (handle < Handle::kTurnX || can_turn);
}

/// Returns the handle nearest to a position on the window, within reach.
std::optional<Handle> TransformHandles::handle_at(const Vec2& window) const {
  if (!screen_) return std::nullopt;
  const Screen& s = *screen_;
  if (glm::length(window - s.centre) <= kCentreRadius) return Handle::kMoveInView;
  for (int i = 0; i < 3; ++i) {
    const Handle plane = handle_of(kPlanes, i);
    if (s.shows(plane) && is_in(s.square(i), window)) return plane;
  }
  float nearest = kReach;
  std::optional<Handle> found;
  const auto try_line = [&](Handle handle, const Vec2& a, const Vec2& b) {
    const float distance = distance_to_line(window, a, b);
    if (distance > nearest) return;
    nearest = distance;
    found = handle;
  };
  for (int i = 0; i < 3; ++i) {
    const Handle move = handle_of(kMoves, i), turn = handle_of(kTurns, i);
    if (s.shows(move)) try_line(move, s.centre + kArrowStart * s.axes[i], s.centre + s.axes[i]);
    for (int k = 0; k < kRingSteps && s.shows(turn); ++k) {
      const float a = 2 * kPi * static_cast<float>(k) / kRingSteps, b = a + 2 * kPi / kRingSteps;
      if (s.ring_depth(i, a) <= kMinDepthBehind) try_line(turn, s.on_ring(i, a), s.on_ring(i, b));
    }
  }
  return found;
}

void TransformHandles::draw(Frame& frame, const Vec3& position, bool can_turn) {
  screen_ = on_screen(frame, position, can_turn);
  if (!screen_) return;
  const Screen& s = *screen_;
  const ImVec2 mouse = ImGui::GetIO().MousePos;
  const auto hot = grabbed_ ? std::optional(grabbed_->handle) : handle_at({mouse.x, mouse.y});
  const auto color_of = [&](Handle handle) {
    return hot == handle ? kHotColor : kAxisColors[axis_of(handle)];
  };
  const PictureArea& area = frame.view.area();
  ImDrawList* const list = ImGui::GetWindowDrawList();
  list->PushClipRect(im(area.low), im(area.high), true);
  // Lines have a dark edge, so that they are visible on any background.
  const auto draw_line = [&](const Vec2& a, const Vec2& b, ImU32 color, float width) {
    list->AddLine(im(a), im(b), kEdgeColor, width + 2);
    list->AddLine(im(a), im(b), color, width);
  };
  for (const bool is_edge : {true, false}) {
    for (int i = 0; i < 3; ++i) {
      const Handle turn = handle_of(kTurns, i);
      for (int k = 0; k < kRingSteps && s.shows(turn); ++k) {
        const float a = 2 * kPi * static_cast<float>(k) / kRingSteps, b = a + 2 * kPi / kRingSteps;
        const bool is_behind = s.ring_depth(i, 0.5f * (a + b)) > kMinDepthBehind;
        const ImU32 color = is_edge     ? kEdgeColor
                            : is_behind ? with_alpha(color_of(turn), 90)
                                        : color_of(turn);
        const float width = is_behind ? 1.f : 2.f;
        if (is_edge && is_behind) continue;
        list->AddLine(im(s.on_ring(i, a)), im(s.on_ring(i, b)), color, is_edge ? width + 2 : width);
      }
    }
  }
  for (int i = 0; i < 3; ++i) {
    const Handle plane = handle_of(kPlanes, i);
    if (!s.shows(plane)) continue;
    const auto corners = s.square(i);
    list->AddQuadFilled(im(corners[0]), im(corners[1]), im(corners[2]), im(corners[3]),
                        with_alpha(color_of(plane), 110));
    list->AddQuad(im(corners[0]), im(corners[1]), im(corners[2]), im(corners[3]), color_of(plane),
                  1.5f);
  }
  for (int i = 0; i < 3; ++i) {
    const Handle move = handle_of(kMoves, i);
    if (!s.shows(move)) continue;
    const Vec2 end = s.centre + s.axes[i], way = glm::normalize(s.axes[i]);
    const Vec2 side(-way.y, way.x);
    draw_line(s.centre + kArrowStart * s.axes[i], end, color_of(move), 3);
    const ImVec2 head[] = {im(end + 13.f * way), im(end + 6.f * side), im(end - 6.f * side)};
    list->AddTriangle(head[0], head[1], head[2], kEdgeColor, 2.5f);
    list->AddTriangleFilled(head[0], head[1], head[2], color_of(move));
  }
  const bool is_centre_hot = hot == Handle::kMoveInView;
  list->AddCircleFilled(im(s.centre), kCentreRadius - 2,
                        is_centre_hot ? kHotColor : with_alpha(kCentreColor, 200));
  list->AddCircle(im(s.centre), kCentreRadius - 2, IM_COL32(0, 0, 0, 160), 0, 1);
  list->PopClipRect();
}

bool TransformHandles::press(Frame& frame, const Vec2& film, const Placement& placement) {
  const auto handle = handle_at(frame.view.area().to_window(film));
  if (handle) grab(frame, *handle, film, placement);
  return handle.has_value();
}

void TransformHandles::grab(Frame& frame, Handle handle, const Vec2& film,
                            const Placement& placement) {
  grabbed_.reset();
  const auto ray = frame.picture ? ray_through(*frame.picture, film) : std::nullopt;
  if (ray) grabbed_ = Grabbed{handle, placement, frame.camera.controls().forward(), *ray};
}

void TransformHandles::drag(Frame& frame, const Vec2& film, ParameterWidgets& widgets) {
  const auto ray = grabbed_ && frame.picture ? ray_through(*frame.picture, film) : std::nullopt;
  if (!ray) return;
  const Placement& start = grabbed_->placement;
  const auto move =
      dragged(grabbed_->handle, start.position, grabbed_->forward, grabbed_->from, *ray);
  if (!move) return;
  EditedValue value;
  if (const auto* const transform = std::get_if<Transform>(&start.value)) {
    value = Placed{Transform(*move * transform->matrix())};
  } else {
    value = Vec3(*move * glm::vec4(start.position, 1.f));
  }
  widgets.set(frame.session, start.path, std::move(value), true);
}

}  // namespace kinome::viewer
