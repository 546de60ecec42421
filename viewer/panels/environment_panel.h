#pragma once

#include <map>

#include "panels/panel.h"
#include "panels/parameter_widgets.h"

namespace kinome::viewer {

/// The light from everywhere: turned, scaled, of another file.
class EnvironmentPanel final : public Panel {
 public:
  const char* title() const override { return "Environment"; }
  void draw(Frame& frame) override;

 private:
  void draw_turn(Frame& frame, const std::string& object);

  ParameterWidgets widgets_;
  /// What an angle of 0 stands for, of each object.
  struct Turn {
    Transform base, now;
    float degrees = 0;
  };
  std::map<std::string, Turn> turns_;
};

}  // namespace kinome::viewer
