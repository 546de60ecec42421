#pragma once

#include "panels/panel.h"

namespace kinome::viewer {

/// Saves the scene as XML, and the image as EXR or PNG.
class SavePanel final : public Panel {
 public:
  const char* title() const override { return "Save"; }
  void draw(Frame& frame) override;
  void draw_over_picture(Frame& frame) override;

 private:
  void set_names(const SceneInfo& info);

  std::string scene_, picture_;
};

}  // namespace kinome::viewer
