#pragma once

#include "panels/panel.h"
#include "panels/parameter_widgets.h"

namespace kinome::viewer {

/// The material of the surface that was clicked on, its shape and its light: all of their
/// parameters.
class MaterialPanel final : public Panel {
 public:
  const char* title() const override { return "Selected surface"; }
  bool is_open_at_first() const override { return true; }
  void draw(Frame& frame) override;

 private:
  ParameterWidgets widgets_;
};

/// Every parameter of the scene, to be looked for by its path.
class ParameterPanel final : public Panel {
 public:
  const char* title() const override { return "All parameters"; }
  void draw(Frame& frame) override;

 private:
  ParameterWidgets widgets_;
  std::string wanted_;
};

}  // namespace kinome::viewer
