#pragma once

#include "panels/panel.h"
#include "panels/parameter_widgets.h"

namespace kinome::viewer {

/// All parameters of the selected surface: of its material, shape and emitter.
class MaterialPanel final : public Panel {
 public:
  const char* title() const override { return "Selected surface"; }
  bool is_open_at_first() const override { return true; }
  void draw(Frame& frame) override;

 private:
  ParameterWidgets widgets_;
};

/// All parameters of the scene, with a search by path.
class ParameterPanel final : public Panel {
 public:
  const char* title() const override { return "All parameters"; }
  void draw(Frame& frame) override;

 private:
  ParameterWidgets widgets_;
  std::string wanted_;
};

}  // namespace kinome::viewer
