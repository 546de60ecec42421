#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "panels/panel.h"
#include "panels/widgets.h"
#include "picture/inspector.h"
#include "picture/sphere.h"
#include "session/preview_sensor.h"
#include "window/image_texture.h"

namespace kinome::viewer {
namespace {

/// Resolution of the sphere's image, in pixels. It is scaled to the window.
constexpr int kSphereSide = 420;
/// Radians for each pixel of a drag.
constexpr float kSphereSpeed = 0.008f;
constexpr ImU32 kLit = IM_COL32(255, 50, 30, 150), kShadowed = IM_COL32(70, 130, 255, 110);

/// Samples of a pixel, which the user selects with Alt and a click (Åkerlund 2008, figure 5.6).
/// Shows them in the scene, on a sphere and on a map, for each importance function of `clustered`.
class InspectorPanel final : public Panel {
 public:
  const char* title() const override { return "Inspector"; }

  void draw(Frame& frame) override {
    draw_choices(frame);
    if (!pixel_) return ImGui::TextDisabled("Alt-click a pixel of the picture");
    if (!shown_) return ImGui::TextDisabled("inspecting");
    if (!shown_->fault.empty()) return draw_error(shown_->fault);
    ImGui::Text("pixel %.0f, %.0f by %s", static_cast<double>(shown_->pixel.x),
                static_cast<double>(shown_->pixel.y), shown_->importance.c_str());
    draw_sets();
    draw_numbers(*set_shown());
  }

  void draw_over_picture(Frame& frame) override {
    take();
    const uint64_t edition = frame.info ? frame.info->edition : 0;
    // An inspection would delay previews, so it waits for an image that isn't a preview.
    const bool is_at_rest =
        frame.picture && !frame.picture->is_preview && frame.picture->edition == edition;
    if (follows_ && pixel_ && edition != edition_ && is_at_rest) ask(frame);
    const InspectedSet* const set = set_shown();
    if (set && marks_scene_ && shown_edition_ == edition) draw_marks(frame, set->marks);
    if (shown_ && has_window_) draw_window(frame);
  }

  bool click(Frame& frame, const PictureClick& click) override {
    if (!click.alt || click.button != 0) return false;
    pixel_ = glm::floor(click.film);
    has_window_ = turns_ = true;
    ask(frame);
    return true;
  }

 private:
  /// Results of the session's thread, which may arrive after the panel is destroyed.
  struct Findings {
    std::mutex mutex;
    std::shared_ptr<const InspectedPixel> latest;
    uint64_t edition = 0;  ///< edition of the scene that `latest` shows
    uint64_t asked = 0;    ///< number of requests; older ones are skipped
  };

  /// Requests an inspection of pixel_.
  void ask(Frame& frame) {
    if (!pixel_) return;
    edition_ = frame.info ? frame.info->edition : 0;
    uint64_t question = 0;
    {
      const std::lock_guard lock(findings_->mutex);
      question = ++findings_->asked;
    }
    frame.session.run([findings = findings_, pixel = *pixel_, importance = importance_, question,
                       edition = edition_](const RenderSession::Access& access) {
      {
        const std::lock_guard lock(findings->mutex);
        if (findings->asked != question) return;
      }
      const Film& film = access.sensor.film();
      // Uses the same number of samples, so that the result is that of `kinome --inspect`.
      const auto sensor = with_own_film(access.sensor, film.crop().width(), film.crop().height(),
                                        access.sensor.sampler().sample_count());
      // The new film starts at the corner of the crop window.
      const Vec2 corner(film.crop().x0, film.crop().y0);
      auto found = std::make_shared<InspectedPixel>(
          inspect_pixel(access.editor, *sensor, access.threads, pixel - corner, importance));
      found->pixel = pixel;
      for (InspectedSet& set : found->sets) set.marks.move(corner);
      const std::lock_guard lock(findings->mutex);
      findings->latest = std::move(found);
      findings->edition = edition;
    });
  }

  /// Takes a new result, if there is one.
  void take() {
    {
      const std::lock_guard lock(findings_->mutex);
      if (findings_->latest == shown_) return;
      shown_ = findings_->latest;
      shown_edition_ = findings_->edition;
    }
    map_of_ = sphere_of_ = nullptr;
    if (turns_) turn_to_samples();
  }

  void draw_choices(Frame& frame) {
    draw_importances(frame);
    ImGui::Checkbox("in the scene", &marks_scene_);
    ImGui::SameLine();
    ImGui::Checkbox("in a window", &has_window_);
    ImGui::SameLine();
    ImGui::Checkbox("live", &follows_);
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("Inspect anew when the scene has changed");
  }

  void draw_numbers(const InspectedSet& set) const {
    const Inspection& report = set.report;
    size_t visible = 0, chosen = 0;
    for (const InspectedSample& sample : report.samples) visible += sample.visible;
    double unseen = 0;
    for (const InspectedCluster& cluster : report.clusters) {
      chosen += cluster.samples > 0;
      unseen += cluster.visibility < 0.05;
    }
    ImGui::Text("%s among %s, %zu of them chosen",
                counted(static_cast<double>(report.samples.size()), "sample").c_str(),
                counted(static_cast<double>(report.clusters.size()), "cluster").c_str(), chosen);
    ImGui::Text("light arrives at %s (%.0f %%)",
                counted(static_cast<double>(visible), "sample").c_str(),
                report.samples.empty() ? 0.
                                       : 100. * static_cast<double>(visible) /
                                             static_cast<double>(report.samples.size()));
    if (report.is_learned) {
      ImGui::Text("%.0f %% of the clusters are known to be hidden",
                  100 * unseen / static_cast<double>(std::max<size_t>(1, report.clusters.size())));
    }
  }

  /// Turns the sphere toward the samples of distant light. Their set is the first, if there is one.
  void turn_to_samples() {
    if (shown_->sets.empty()) return;
    const Inspection& report = shown_->sets.front().report;
    Vec3 sum(0.f);
    for (const InspectedSample& sample : report.samples) {
      sum += static_cast<float>(sample.weight) * sample.position;
    }
    if (!report.is_distant || sum == Vec3(0.f)) return;
    const Vec3 d = glm::normalize(sum);
    // The view stays away from the poles, where the up direction is not visible.
    orbit_ = {std::atan2(d.x, d.z), std::clamp(std::asin(std::clamp(d.y, -1.f, 1.f)), -1.f, 1.f)};
    turns_ = false;
  }

  void draw_importances(Frame& frame) {
    static const std::vector<std::string> names = {"product", "joint", "luminance", "brdf"};
    if (const auto chosen = choose("importance", importance_, names)) {
      importance_ = names[*chosen];
      ask(frame);
    }
  }

  void draw_sets() {
    if (shown_->sets.size() < 2) return;
    for (size_t i = 0; i < shown_->sets.size(); ++i) {
      if (i > 0) ImGui::SameLine();
      const bool distant = shown_->sets[i].report.is_distant;
      if (ImGui::RadioButton(distant ? "light of the sky" : "light of surfaces", set_ == i)) {
        set_ = i;
      }
    }
  }

  /// Draws the panel's own window, over the image.
  void draw_window(Frame& frame) {
    const float unit = display_scale();
    const float height = 490 * unit;
    ImGui::SetNextWindowPos({12, std::max(12.f, ImGui::GetIO().DisplaySize.y - height - 12)},
                            ImGuiCond_FirstUseEver);
    ImGui::SetNextWindowSize({420 * unit, height}, ImGuiCond_FirstUseEver);
    if (!ImGui::Begin("Inspector", &has_window_)) return ImGui::End();
    ImGui::SetNextItemWidth(120 * unit);
    draw_importances(frame);
    if (!shown_->fault.empty()) {
      draw_error(shown_->fault);
      return ImGui::End();
    }
    draw_sets();
    const InspectedSet& set = *set_shown();
    const bool distant = set.report.is_distant;
    if (distant) {
      if (ImGui::RadioButton("sphere", is_sphere_)) is_sphere_ = true;
      ImGui::SameLine();
      if (ImGui::RadioButton("map", !is_sphere_)) is_sphere_ = false;
      ImGui::SameLine();
      ImGui::TextDisabled("red: light arrives, blue: hidden");
    } else {
      ImGui::TextDisabled("red: light arrives, blue: hidden, green: the point");
    }
    const ImVec2 space = ImGui::GetContentRegionAvail();
    if (distant && is_sphere_) {
      draw_sphere(set, std::min(space.x, space.y));
    } else {
      if (map_of_ != &set) map_.set(set.picture);
      map_of_ = &set;
      const float scale = std::min(space.x / static_cast<float>(map_.width()),
                                   space.y / static_cast<float>(map_.height()));
      ImGui::Image(map_.id(), {scale * static_cast<float>(map_.width()),
                               scale * static_cast<float>(map_.height())});
    }
    ImGui::End();
  }

  void draw_sphere(const InspectedSet& set, float side) {
    const bool has_turned = sphere_orbit_.yaw != orbit_.yaw || sphere_orbit_.pitch != orbit_.pitch;
    if (sphere_of_ != &set || has_turned) {
      sphere_.set(sphere_picture(set.picture, orbit_, kSphereSide, 0.004f));
      sphere_of_ = &set;
      sphere_orbit_ = orbit_;
    }
    const ImVec2 corner = ImGui::GetCursorScreenPos();
    ImGui::InvisibleButton("sphere", {std::max(side, 1.f), std::max(side, 1.f)});
    if (ImGui::IsItemActive()) {
      const ImVec2 moved = ImGui::GetIO().MouseDelta;
      orbit_.yaw -= kSphereSpeed * moved.x;
      orbit_.pitch = std::clamp(orbit_.pitch + kSphereSpeed * moved.y, -kPi / 2, kPi / 2);
    }
    ImGui::GetWindowDrawList()->AddImage(sphere_.id(), corner, {corner.x + side, corner.y + side});
  }

  void draw_marks(const Frame& frame, const InspectionMarks& marks) const {
    const PictureArea& area = frame.view.area();
    const auto at = [&](const Vec2& film) {
      const Vec2 window = area.to_window(film);
      return ImVec2(window.x, window.y);
    };
    ImDrawList* const list = ImGui::GetWindowDrawList();
    list->PushClipRect({area.low.x, area.low.y}, {area.high.x, area.high.y}, true);
    for (const InspectionMarks::Edge& edge : marks.edges) {
      const int alpha = 40 + static_cast<int>(150 * std::sqrt(std::clamp(edge.share, 0.f, 1.f)));
      list->AddLine(at(edge.from), at(edge.to), IM_COL32(240, 205, 30, alpha));
    }
    // Draws lines to visible samples last, on top of the others.
    for (const bool is_lit : {false, true}) {
      for (const InspectionMarks::Line& line : marks.lines) {
        if (line.is_lit != is_lit) continue;
        list->AddLine(at(line.from), at(line.to), is_lit ? kLit : kShadowed, is_lit ? 1.5f : 1);
      }
    }
    if (marks.point) {
      list->AddCircleFilled(at(*marks.point), 4, IM_COL32(50, 255, 80, 255));
      list->AddCircle(at(*marks.point), 5, IM_COL32(0, 0, 0, 255));
    }
    list->PopClipRect();
  }

  const InspectedSet* set_shown() const {
    if (!shown_ || shown_->sets.empty()) return nullptr;
    return &shown_->sets[std::min(set_, shown_->sets.size() - 1)];
  }

  std::shared_ptr<Findings> findings_ = std::make_shared<Findings>();
  std::shared_ptr<const InspectedPixel> shown_;
  std::optional<Vec2> pixel_;
  std::string importance_ = "product";
  uint64_t edition_ = 0;        ///< edition of the scene at the last request
  uint64_t shown_edition_ = 0;  ///< edition of the scene that shown_ is of
  bool follows_ = true;         ///< inspects again when the scene has changed
  bool marks_scene_ = true;
  bool has_window_ = true;
  size_t set_ = 0;
  bool is_sphere_ = true;  ///< the window shows a sphere instead of a map, for distant light
  Orbit orbit_{0.6f, 0.5f};
  bool turns_ = false;  ///< turns the sphere toward the samples when they arrive
  ImageTexture map_, sphere_;
  const InspectedSet* map_of_ = nullptr;     ///< set that map_ shows
  const InspectedSet* sphere_of_ = nullptr;  ///< set that sphere_ shows from sphere_orbit_
  Orbit sphere_orbit_;
};

}  // namespace

std::unique_ptr<Panel> make_inspector_panel() {
  return std::make_unique<InspectorPanel>();
}

}  // namespace kinome::viewer
