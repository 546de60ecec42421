#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "kinome/scene_editor.h"
#include "session/picture.h"

namespace kinome::viewer {

/// Paths and new values of parameters of the scene, in the order in which they are set.
using Edits = std::vector<std::pair<std::string, EditedValue>>;

/// Description of a scene. Never changes once it is published.
struct SceneInfo {
  uint64_t edition = 0;  ///< number of the scene's version
  uint64_t served = 0;   ///< requests up to this number, as returned by set(), are included
  std::string file;
  std::vector<SceneParameter> parameters;
  std::vector<SceneParameter> textured;  ///< SceneEditor::textured_parameters()
  std::vector<SceneObject> objects;
  std::vector<std::string> sensors;      ///< ids; indices of sensors without an id
  std::vector<std::string> integrators;  ///< names of all integrator plugins
  std::string own_integrator;            ///< integrator of the scene
  size_t sensor = 0;                     ///< index of the sensor that is rendered
  std::string sensor_path;               ///< prefix of the sensor's parameters; "" if it has none
  std::string film_path;
  std::string environment;  ///< path of the environment emitter; "" if there is none, or no path
  Aabb bounds;              ///< of all shapes
  Rect crop;                ///< crop window of the sensor's film, in pixels
  bool can_undo = false;

  /// The find functions return nullptr if nothing has this path. find() searches `parameters`.
  const SceneParameter* find(const std::string& path) const;
  /// Searches `textured`, the parameters whose value is a texture.
  const SceneParameter* find_textured(const std::string& path) const;
  const SceneObject* find_object(const std::string& path) const;
};

/// The surface at a position of the image.
struct Pick {
  Vec3 origin{0.f};  ///< origin of the camera ray
  Vec3 direction{0, 0, 1};
  Vec3 point{0.f};  ///< intersection with the scene
  Vec3 normal{0, 0, 1};
  float distance = 0;
  std::string shape;                   ///< path of the shape; "" if it has none
  std::vector<std::string> materials;  ///< paths of the BSDF and of all objects nested in it
  std::string emitter;                 ///< path of the shape's emitter; "" if there is none
};

/// Result of ask_pick(), which may arrive later. One thread requests and reads it.
class PickAnswer {
 public:
  bool is_there() const { return is_there_; }
  /// Returns the surface; nullopt if there is none. Valid once is_there() is true.
  const std::optional<Pick>& pick() const { return pick_; }
  /// Sets the result. Called once, by the thread that answers.
  void give(std::optional<Pick> pick) {
    pick_ = std::move(pick);
    is_there_ = true;
  }

 private:
  std::optional<Pick> pick_;
  std::atomic<bool> is_there_ = false;
};

/// Current activity of the session.
enum class Activity { kLoading, kFailed, kPreview, kRendering, kPaused, kFinished };

struct Status {
  Activity activity = Activity::kLoading;
  double fraction = 0;     ///< finished part of the pass, or of the samples passed to render()
  bool is_exact = false;   ///< render() is running or finished
  bool is_paused = false;  ///< by set_paused(), independent of the activity
  std::string integrator;  ///< selected integrator; "" for the scene's own
};

/// An error, a warning or a note.
struct Message {
  bool is_error = false;
  std::string text;
  uint64_t number = 0;  ///< number of the message in the session, from 1
};

/// A scene that is rendered while it is edited. A thread of the session renders, and applies
/// changes between renders. Each change is followed by a preview with as many pixels as can be
/// rendered in a short time. Then the session renders all pixels, improving the image pass by pass
/// until the next change.
///
/// All functions can be called by any thread. None of them waits for a render; only pick(), wait()
/// and close() can block. Errors appear in messages() and leave the scene unchanged.
class RenderSession {
 public:
  struct Options {
    std::string scene;  ///< scene file
    LoadOptions load;
    std::vector<std::string> plugin_folders;  ///< in addition to the default folders
    std::string integrator;                   ///< "" for the scene's own
    std::string sensor = "0";                 ///< index or id
    int width = 0, height = 0;                ///< size of the film; 0 for that of the scene
    unsigned threads = 0;                     ///< 0 for one per core
    uint64_t seed = 0;
    /// Samples per pixel at which progressive rendering stops.
    double most_samples = 16384;
    /// Time for a preview, including the change that it shows [s].
    double preview_seconds = 0.07;
    /// Renders previews and passes automatically. If false, only render() renders.
    bool is_live = true;
    /// Called by the session's thread when a picture, message or status is new. Must not block.
    std::function<void()> on_change;
  };

  /// Starts to load the scene.
  explicit RenderSession(Options options);
  /// Calls close().
  ~RenderSession();
  RenderSession(const RenderSession&) = delete;
  RenderSession& operator=(const RenderSession&) = delete;

  /// Returns the latest image, or nullptr if there is none yet.
  PicturePointer picture() const;
  /// Returns nullptr until the scene is loaded. May be slightly older than the image.
  std::shared_ptr<const SceneInfo> info() const;
  Status status() const;
  /// Returns the messages, including warnings, with numbers greater than `known`. Only the latest
  /// 200 messages are kept.
  std::vector<Message> messages(uint64_t known = 0) const;
  void say(bool is_error, std::string text);

  /// Sets all of these parameters, or none if one of them can't be set. Replaces edits of the same
  /// path that haven't been applied yet. Set `is_moving` if more edits follow at once, for instance
  /// during a drag: then only previews are rendered. `is_undoable` makes undo() revert the edits.
  /// Returns the number of the request. It has been applied or refused once SceneInfo::served
  /// reaches this number.
  uint64_t set(Edits edits, bool is_moving = false, bool is_undoable = true);
  /// Undoes the last set(). Consecutive calls with the same paths are undone together.
  void undo();
  /// Selects an integrator by the name of its plugin; "" for the scene's own.
  void set_integrator(std::string name);
  void set_sensor(size_t index);
  void set_paused(bool is_paused);
  /// Restarts the image, even if it is the result of render().
  void restart();
  /// Renders the image that `kinome` renders with this number of samples per pixel,
  /// bit-identically, and keeps it until the next change.
  void render(uint32_t samples);
  /// Loads the file again and discards all edits.
  void reload();

  /// The scene at the time when a task runs.
  struct Access {
    SceneEditor& editor;
    const Scene& scene;    ///< with the selected integrator
    const Sensor& sensor;  ///< selected sensor; its film belongs to the image that is being
                           ///< rendered: see with_own_film()
    unsigned threads;
  };
  using Task = std::function<void(const Access&)>;
  /// Runs a task in the session's thread, between two passes and after all earlier changes. The
  /// image isn't restarted. Exceptions become messages. The task must not call pick(), wait() or
  /// close().
  void run(Task task);
  /// Saves the scene as XML, including all earlier changes: SceneEditor::save().
  void save(std::string path);
  /// Returns true while a save is pending.
  bool is_to_save() const;
  /// Cancels the current render, does the pending saves, and ends the session's thread. The
  /// functions that return results remain usable. Only one thread may call it.
  void close();
  /// Waits until all changes and tasks are done and the image of render() is finished.
  void wait() const;

  /// Returns the surface at a position on the sensor's film [pixels], or nullopt if there is none.
  /// Waits for a change or task that is running.
  std::optional<Pick> pick(const Vec2& film_position) const;
  /// Requests the same without waiting. The answer arrives after the current change or task, or at
  /// once if there is none.
  std::shared_ptr<const PickAnswer> ask_pick(const Vec2& film_position) const;

 private:
  class Worker;
  std::unique_ptr<Worker> worker_;
};

}  // namespace kinome::viewer
