#include <iterator>

#include "panels/panel.h"
#include "picture/display.h"

namespace kinome::viewer {

std::vector<std::unique_ptr<Panel>> make_panels() {
  const auto display = std::make_shared<Display>();
  std::unique_ptr<Panel> all[] = {
      make_render_panel(),      make_camera_panel(),         make_material_panel(),
      make_tone_panel(display), make_compare_panel(display), make_inspector_panel(),
      make_environment_panel(), make_lamp_panel(),           make_light_panel(),
      make_medium_panel(),      make_parameter_panel(),      make_save_panel(),
      make_message_panel()};
  return {std::make_move_iterator(std::begin(all)), std::make_move_iterator(std::end(all))};
}

}  // namespace kinome::viewer
