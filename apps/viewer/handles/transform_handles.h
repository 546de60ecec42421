#pragma once

#include <array>
#include <optional>
#include <string>

#include "handles/handle_drag.h"
#include "panels/panel.h"
#include "panels/parameters/parameter_widgets.h"

namespace kinome::viewer {

/// Parameter that places an object in the scene.
struct Placement {
  std::string path;      ///< of a position or a transform
  EditedValue value;     ///< a Vec3 or a Transform
  Vec3 position{0.f};    ///< position of the object
  bool can_turn = true;  ///< false for a position
};

/// Returns the parameter that places an object: "center" or "position" if its to_world is the
/// identity, and otherwise "to_world". Returns nullopt if it has none of them.
std::optional<Placement> placement_of(const SceneInfo& info, const ParameterWidgets& widgets,
                                      const std::string& object);

/// Handles over the image that move and turn an object: arrows, squares and rings along the axes of
/// the world. For the window's thread only.
class TransformHandles {
 public:
  /// Draws the handles at a position. Hides them if the image doesn't show it. Must be called once
  /// per frame while they should be visible.
  void draw(Frame& frame, const Vec3& position, bool can_turn);
  void hide() { screen_.reset(); }
  /// Grabs the handle at a position on the film. Returns false if there is none.
  bool press(Frame& frame, const Vec2& film, const Placement& placement);
  /// Grabs a handle at this position on the film, wherever it is drawn.
  void grab(Frame& frame, Handle handle, const Vec2& film, const Placement& placement);
  /// Moves the grabbed object by setting its parameter.
  void drag(Frame& frame, const Vec2& film, ParameterWidgets& widgets);
  void release() { grabbed_.reset(); }

 private:
  /// Handles on the window, in an affine approximation around their centre.
  struct Screen {
    Vec2 centre{0.f};
    std::array<Vec2, 3> axes;    ///< images of the axes, which are as long as the arrows
    std::array<float, 3> depth;  ///< cosines between the axes and the viewing direction
    bool can_turn = true;
    bool shows(Handle handle) const;
    Vec2 on_ring(int axis, float angle) const;
    /// Depth on the ring, relative to the centre: positive behind it.
    float ring_depth(int axis, float angle) const;
    std::array<Vec2, 4> square(int axis) const;
  };
  struct Grabbed {
    Handle handle;
    Placement placement;
    Vec3 forward;
    Ray from;
  };
  static std::optional<Screen> on_screen(const Frame& frame, const Vec3& position, bool can_turn);
  std::optional<Handle> handle_at(const Vec2& window) const;

  std::optional<Screen> screen_;
  std::optional<Grabbed> grabbed_;
};

}  // namespace kinome::viewer
