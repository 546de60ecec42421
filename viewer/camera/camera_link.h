#pragma once

#include "camera/camera_controls.h"
#include "session/render_session.h"

namespace kinome::viewer {

/// Keeps camera controls and the sensor of a session together: each follows the other. Of the
/// window's thread.
class CameraLink {
 public:
  /// Once a frame: takes over what was set by others (undo, another sensor, a file that was loaded
  /// anew).
  void follow(const RenderSession& session, const std::shared_ptr<const SceneInfo>& info);
  /// Whether the target is what is seen in the middle of the picture, as far as that is known.
  bool is_aimed() const { return !aiming_; }
  /// Whether there is a camera that can be moved.
  bool can_move() const { return !path_.empty(); }
  bool is_orthographic() const { return is_orthographic_; }
  CameraControls& controls() { return controls_; }
  const CameraControls& controls() const { return controls_; }
  /// Sets the sensor's to_world as the controls have it; back where it was at first, it is what the
  /// scene's file says.
  void send(RenderSession& session);

 private:
  void take_aim();

  CameraControls controls_;
  std::string path_;  ///< of the sensor; "": it has none
  uint64_t edition_ = 0;
  Transform sent_;
  uint64_t sent_number_ = 0;  ///< RenderSession::set's
  bool is_orthographic_ = false;
  std::shared_ptr<const PickAnswer> aiming_;  ///< nullptr: it is done
  Transform home_;                            ///< as the controls have it
  bool is_home_written_ = false;              ///< it is what the scene's file says
};

}  // namespace kinome::viewer
