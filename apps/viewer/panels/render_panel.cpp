#include <imgui.h>

#include <algorithm>
#include <chrono>
#include <deque>

#include "handles/region_tool.h"
#include "panels/panel.h"
#include "panels/parameters/parameter_widgets.h"
#include "panels/widgets.h"

namespace kinome::viewer {
namespace {

const char* label_of(Activity activity) {
  constexpr const char* kLabels[] = {
      "loading", "stopped by an error", "preview", "rendering", "paused", "finished"};
  return kLabels[static_cast<int>(activity)];
}

/// Progress of the render, choice of the integrator, pause, restart, a render with a given number
/// of samples, and the region to render.
class RenderPanel final : public Panel {
 public:
  const char* title() const override { return "Render"; }
  bool is_open_at_first() const override { return true; }

  void draw(Frame& frame) override {
    draw_numbers(frame);
    draw_integrators(frame);
    const bool is_paused = frame.status.is_paused;
    if (ImGui::Button(is_paused ? "Resume" : "Pause")) frame.session.set_paused(!is_paused);
    ImGui::SameLine();
    if (ImGui::Button("Restart")) frame.session.restart();
    ImGui::SameLine();
    if (ImGui::Button("Reload file")) frame.session.reload();
    bool is_denoising = frame.status.is_denoising;
    if (ImGui::Checkbox("Denoise previews", &is_denoising)) {
      frame.session.set_denoising(is_denoising);
    }
    if (ImGui::IsItemHovered()) {
      ImGui::SetTooltip("By Open Image Denoise, while the camera moves or parameters change");
    }
    ImGui::SetNextItemWidth(110 * display_scale());
    ImGui::InputInt("samples", &samples_, 16, 64);
    samples_ = std::clamp(samples_, 1, 1 << 20);
    ImGui::SameLine();
    if (ImGui::Button("Render##samples")) frame.session.render(static_cast<uint32_t>(samples_));
    if (ImGui::IsItemHovered()) {
      ImGui::SetTooltip("The picture that `kinome` renders with this number of samples per pixel");
    }
    if (frame.status.region) {
      const Rect& region = *frame.status.region;
      if (ImGui::Button("Whole picture")) frame.session.set_region(std::nullopt);
      ImGui::SameLine();
      ImGui::Text("region of %d x %d (Esc)", region.width(), region.height());
    }
    draw_parameters(frame);
  }

  void draw_over_picture(Frame& frame) override { region_.draw(frame); }
  bool press(Frame& frame, const PictureClick& click) override {
    return frame.tabs.is_live() && region_.press(click);
  }
  void drag(Frame& /*frame*/, const Vec2& film) override { region_.drag(film); }
  void release(Frame& frame) override { region_.release(frame); }

 private:
  void draw_numbers(const Frame& frame) {
    ImGui::Text("%s%s", label_of(frame.status.activity),
                frame.status.is_exact ? ", all samples at once" : "");
    ImGui::ProgressBar(static_cast<float>(frame.status.fraction), ImVec2(-1, 4), "");
    const PicturePointer& picture = frame.picture;
    if (!picture) return;
    const double rate = pictures_per_second(*picture);
    const Image& image = picture->image;
    if (picture->integrator.empty()) {
      return ImGui::Text("%d x %d, from a file", image.width, image.height);
    }
    if (picture->is_preview) {
      ImGui::Text("preview of %d x %d by %s", image.width, image.height,
                  picture->integrator.c_str());
    } else {
      ImGui::Text("%d x %d by %s", image.width, image.height, picture->integrator.c_str());
    }
    ImGui::Text("%s per pixel, %.2f s", counted(picture->samples, "sample").c_str(),
                picture->seconds);
    if (picture->rel_mse >= 0) {
      ImGui::Text("relMSE about %.2g", picture->rel_mse);
    } else {
      ImGui::TextDisabled("relMSE unknown");
    }
    ImGui::Text("%.2f million rays/s, %s/s", 1e-6 * picture->rays_per_second,
                counted(rate, "picture").c_str());
  }

  void draw_integrators(Frame& frame) {
    if (!frame.info) return;
    const std::string own = "the scene's own: " + frame.info->own_integrator;
    const std::string& chosen = frame.status.integrator;
    std::vector<std::string> names = {own};
    names.insert(names.end(), frame.info->integrators.begin(), frame.info->integrators.end());
    const auto wanted = choose("integrator", chosen.empty() ? own : chosen, names);
    if (wanted) frame.session.set_integrator(*wanted == 0 ? "" : names[*wanted]);
  }

  /// Draws the parameters of the scene's integrator, unless another one is selected.
  void draw_parameters(Frame& frame) {
    widgets_.begin(frame.info);
    if (!frame.info || !frame.status.integrator.empty()) return;
    const auto& objects = frame.info->objects;
    const auto integrator = std::find_if(objects.begin(), objects.end(), [](const auto& object) {
      return object.plugin.starts_with("integrator/");
    });
    if (integrator == objects.end() || !ImGui::TreeNode("parameters of the integrator")) return;
    widgets_.draw_all(frame.session, *frame.info, {integrator->path});
    ImGui::TreePop();
  }

  /// Returns the number of images in the last second.
  double pictures_per_second(const Picture& picture) {
    const auto now = std::chrono::steady_clock::now();
    if (picture.generation != seen_generation_) {
      seen_generation_ = picture.generation;
      seen_.push_back(now);
    }
    while (!seen_.empty() && now - seen_.front() > std::chrono::seconds(1)) seen_.pop_front();
    return static_cast<double>(seen_.size());
  }

  ParameterWidgets widgets_;
  RegionTool region_;
  int samples_ = 64;
  std::deque<std::chrono::steady_clock::time_point> seen_;
  uint64_t seen_generation_ = 0;
};

}  // namespace

std::unique_ptr<Panel> make_render_panel() {
  return std::make_unique<RenderPanel>();
}

}  // namespace kinome::viewer
