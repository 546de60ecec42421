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

/// Where the samples of a pixel go, that is clicked on with Alt held (Åkerlund 2008, figure 5.6):
/// in the scene, on a sphere and on a map, for each importance function of `clustered`.
class InspectorPanel final : public Panel {
 public:
  const char* title() const override { return "Inspector"; }
  void draw(Frame& frame) override;
  void draw_over_picture(Frame& frame) override;
  bool click(Frame& frame, const PictureClick& click) override;

 private:
  /// What the session's thread finds; it may be done after the panel is gone.
  struct Findings {
    std::mutex mutex;
    std::shared_ptr<const InspectedPixel> latest;
    uint64_t edition = 0;  ///< of the scene that it is of
    uint64_t asked = 0;    ///< counts questions: only the last is of interest
  };

  void ask(Frame& frame);
  /// The findings that there are.
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
  uint64_t edition_ = 0;        ///< of the scene, that was asked about
  uint64_t shown_edition_ = 0;  ///< that shown_ is of
  bool follows_ = true;         ///< asks again where the scene has changed
  bool marks_scene_ = true;
  bool has_window_ = true;
  size_t set_ = 0;
  /// Of what is in the window: a sphere, or a map or picture of the scene.
  bool is_sphere_ = true;
  Orbit orbit_{0.6f, 0.5f};
  bool turns_ = false;  ///< toward the samples, once they are known
  ImageTexture map_, sphere_;
  const InspectedSet* map_of_ = nullptr;     ///< what map_ shows
  const InspectedSet* sphere_of_ = nullptr;  ///< and sphere_, from sphere_orbit_
  Orbit sphere_orbit_;
};

}  // namespace kinome::viewer
