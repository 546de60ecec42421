#pragma once

#include "panels/panel.h"
#include "panels/parameter_widgets.h"

namespace kinome::viewer {

/// Lamps: their parameters, and handles in the picture by which they are dragged, while the panel
/// is open.
class LampPanel final : public Panel {
 public:
  const char* title() const override { return "Lamps"; }
  void draw(Frame& frame) override;
  void draw_over_picture(Frame& frame) override;
  bool press(Frame& frame, const PictureClick& click) override;
  void drag(Frame& frame, const Vec2& film) override;

 private:
  struct Lamp {
    std::string object;  ///< path of the emitter
    std::string path;    ///< of the parameter that places it; "": it has no place
    Vec3 place{0.f};
    std::optional<Vec2> seen;  ///< on the film
  };
  void find_lamps(const SceneInfo& info);

  ParameterWidgets widgets_;
  std::shared_ptr<const SceneInfo> info_;
  uint64_t generation_ = 0;  ///< of the picture by which they were last looked for
  std::vector<Lamp> lamps_;
  bool has_handles_ = true;
  bool is_drawn_ = false;  ///< in this frame: the panel is open
  bool is_open_ = false;
  size_t dragged_ = 0;
  Vec3 grabbed_{0.f};  ///< where it was
};

}  // namespace kinome::viewer
