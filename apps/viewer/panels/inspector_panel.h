#pragma once

#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "panels/image_texture.h"
#include "panels/panel.h"
#include "picture/inspector.h"
#include "picture/sphere.h"

namespace kinome::viewer {

/// Samples of a pixel, which the user selects with Alt and a click (Åkerlund 2008, figure 5.6).
/// Shows them in the scene, on a sphere and on a map, for each importance function of `clustered`.
class InspectorPanel final : public Panel {
 public:
  const char* title() const override { return "Inspector"; }
  void draw(Frame& frame) override;
  void draw_over_picture(Frame& frame) override;
  bool click(Frame& frame, const PictureClick& click) override;

 private:
  /// Results of the session's thread, which may arrive after the panel is destroyed.
  struct Findings {
    std::mutex mutex;
    std::shared_ptr<const InspectedPixel> latest;
    uint64_t edition = 0;  ///< edition of the scene that `latest` shows
    uint64_t asked = 0;    ///< number of requests; older ones are skipped
  };

  /// Requests an inspection of pixel_.
  void ask(Frame& frame);
  /// Takes a new result, if there is one.
  void take();
  void draw_choices(Frame& frame);
  void draw_numbers(const InspectedSet& set) const;
  void turn_to_samples();
  void draw_importances(Frame& frame);
  void draw_fault() const;
  void draw_sets();
  void draw_window(Frame& frame);
  void draw_sphere(const InspectedSet& set, float side);
  void draw_marks(const Frame& frame, const InspectionMarks& marks) const;
  const InspectedSet* set_shown() const;

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

}  // namespace kinome::viewer
