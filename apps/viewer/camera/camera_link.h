#pragma once

#include "camera/camera_controls.h"
#include "session/render_session.h"

namespace kinome::viewer {

/// Synchronises the camera controls with the session's sensor, in both directions. For the window's
/// thread only.
class CameraLink {
 public:
  /// Copies changes of the sensor that were made elsewhere (undo, another sensor, a reloaded file)
  /// to the controls. Must be called once per frame.
  void follow(RenderSession& session, const std::shared_ptr<const SceneInfo>& info);
  /// Returns false while the target is still to be moved to the surface in the middle of the image.
  bool is_aimed() const { return !aiming_; }
  /// Returns true if the sensor has a to_world that can be edited.
  bool can_move() const { return !path_.empty(); }
  bool is_orthographic() const { return is_orthographic_; }
  CameraControls& controls() { return controls_; }
  const CameraControls& controls() const { return controls_; }
  /// Sets the sensor's to_world from the controls. At its home position, restores the value of the
  /// scene file.
  void send(RenderSession& session);

 private:
  void apply_pick();

  CameraControls controls_;
  std::string path_;  ///< of the sensor; "" if it can't be moved
  uint64_t edition_ = 0;
  Transform sent_;
  uint64_t sent_number_ = 0;  ///< returned by RenderSession::set()
  bool is_orthographic_ = false;
  std::shared_ptr<const PickAnswer> aiming_;  ///< nullptr once the target is set
  Transform home_;                            ///< the controls' to_world at the home position
  bool is_home_written_ = false;              ///< home_ is the value in the scene file
};

}  // namespace kinome::viewer
