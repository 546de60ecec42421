#pragma once

#include <map>

#include "panels/panel.h"
#include "panels/parameter_widgets.h"

namespace kinome::viewer {

/// The environment emitter: its rotation and parameters.
class EnvironmentPanel final : public Panel {
 public:
  const char* title() const override { return "Environment"; }
  void draw(Frame& frame) override;

 private:
  void draw_turn(Frame& frame, const std::string& object);

  ParameterWidgets widgets_;
  /// Rotation of an object.
  struct Turn {
    Transform base;  ///< at 0 degrees
    Transform now;
    float degrees = 0;
  };
  std::map<std::string, Turn> turns_;
};

}  // namespace kinome::viewer
