#pragma once

#include "panels/panel.h"
#include "panels/parameter_widgets.h"

namespace kinome::viewer {

/// Emitters other than the environment: their parameters, and handles in the image with which the
/// user drags them. The handles are visible while the panel is open.
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
    std::string path;    ///< path of the parameter with its position; "" if it has none
    Vec3 place{0.f};
    std::optional<Vec2> seen;  ///< position on the film; nullopt if it isn't visible
  };
  void find_lamps(const SceneInfo& info);

  ParameterWidgets widgets_;
  std::shared_ptr<const SceneInfo> info_;
  uint64_t generation_ = 0;  ///< image from which lamps_ was last updated
  std::vector<Lamp> lamps_;
  bool has_handles_ = true;
  bool is_drawn_ = false;  ///< the side bar has drawn the panel since the last frame
  bool is_open_ = false;
  size_t dragged_ = 0;
  Vec3 grabbed_{0.f};  ///< its position at the start of the drag
};

}  // namespace kinome::viewer
