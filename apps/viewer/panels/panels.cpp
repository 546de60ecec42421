#include "panels/camera_panel.h"
#include "panels/compare_panel.h"
#include "panels/environment_panel.h"
#include "panels/inspector_panel.h"
#include "panels/lamp_panel.h"
#include "panels/material_panel.h"
#include "panels/message_panel.h"
#include "panels/panel.h"
#include "panels/render_panel.h"
#include "panels/save_panel.h"
#include "panels/tone_panel.h"

namespace kinome::viewer {

std::vector<std::unique_ptr<Panel>> make_panels() {
  std::vector<std::unique_ptr<Panel>> panels;
  panels.push_back(std::make_unique<RenderPanel>());
  panels.push_back(std::make_unique<CameraPanel>());
  panels.push_back(std::make_unique<MaterialPanel>());
  const auto display = std::make_shared<Display>();
  panels.push_back(std::make_unique<TonePanel>(display));
  panels.push_back(std::make_unique<ComparePanel>(display));
  panels.push_back(std::make_unique<InspectorPanel>());
  panels.push_back(std::make_unique<EnvironmentPanel>());
  panels.push_back(std::make_unique<LampPanel>());
  panels.push_back(std::make_unique<ParameterPanel>());
  panels.push_back(std::make_unique<SavePanel>());
  panels.push_back(std::make_unique<MessagePanel>());
  return panels;
}

}  // namespace kinome::viewer
