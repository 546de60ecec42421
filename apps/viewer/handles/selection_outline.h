#pragma once

#include <future>
#include <memory>
#include <optional>

#include "panels/panel.h"
#include "picture/outline.h"

namespace kinome::viewer {

/// Draws the outline of the selected shape over the image. For the window's thread only.
class SelectionOutline {
 public:
  /// Must be called once per frame, while the image's ImGui window is current.
  void draw(Frame& frame);

 private:
  /// Input of an outline.
  struct Key {
    std::shared_ptr<const Pick> selection;
    uint64_t edition = 0;
    Rect crop;
    float cell = 0;
    bool operator==(const Key& other) const;
  };
  void update(Frame& frame);

  Key key_;                         ///< of the outline that was requested last
  std::optional<Outline> outline_;  ///< nullopt if there is none
  uint64_t generation_ = 0;         ///< latest preview whose outline was traced
  Key tracing_key_;
  std::future<std::optional<Outline>> tracing_;  ///< outline that another thread traces
};

}  // namespace kinome::viewer
