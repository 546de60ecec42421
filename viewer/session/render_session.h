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

/// Parameters of the scene that are to be set, by their paths, in this order.
using Edits = std::vector<std::pair<std::string, EditedValue>>;

/// What there is to know of a scene besides its pictures. Never changed once it is published.
struct SceneInfo {
  uint64_t edition = 0;  ///< counts the changes that were made of it
  uint64_t served = 0;   ///< up to this number, what set() was given is part of it
  std::string file;
  std::vector<SceneParameter> parameters;
  std::vector<SceneParameter> textured;  ///< SceneEditor::textured_parameters()
  std::vector<SceneObject> objects;
  std::vector<std::string> sensors;      ///< ids, or indices where they have none
  std::vector<std::string> integrators;  ///< names of all plugins that there are
  std::string own_integrator;            ///< the scene's
  size_t sensor = 0;                     ///< the one that is rendered
  std::string sensor_path;               ///< as the paths of its parameters begin; "": it has none
  std::string film_path;
  std::string environment;  ///< path of the emitter that surrounds the scene; "": none, or no path
  Aabb bounds;              ///< of all shapes
  Rect crop;                ///< of the sensor's film: what a picture shows, in pixels
  bool can_undo = false;

  /// nullptr: there is none of this path.
  const SceneParameter* find(const std::string& path) const;
  /// Of those that textures stand for.
  const SceneParameter* find_textured(const std::string& path) const;
  const SceneObject* find_object(const std::string& path) const;
};

/// What is seen at a place of the picture.
struct Pick {
  Vec3 origin{0.f};  ///< of the ray: the camera
  Vec3 direction{0, 0, 1};
  Vec3 point{0.f};  ///< where it meets the scene
  Vec3 normal{0, 0, 1};
  float distance = 0;
  std::string shape;                   ///< its path; "": it has none
  std::vector<std::string> materials;  ///< paths of its BSDF, and of all that is nested in that
  std::string emitter;                 ///< path of its emitter; "": none
};

/// The answer to a question, which may come later: asked and read by one thread.
class PickAnswer {
 public:
  bool is_there() const { return is_there_; }
  /// Once it is there. nullopt: no surface.
  const std::optional<Pick>& pick() const { return pick_; }
  /// By whoever answers, once.
  void give(std::optional<Pick> pick) {
    pick_ = std::move(pick);
    is_there_ = true;
  }

 private:
  std::optional<Pick> pick_;
  std::atomic<bool> is_there_ = false;
};

/// What the session is at.
enum class Activity { kLoading, kFailed, kPreview, kRendering, kPaused, kFinished };

struct Status {
  Activity activity = Activity::kLoading;
  double fraction = 0;     ///< of the pass, or of all samples that render() was asked for
  bool is_exact = false;   ///< render() is at work, or its picture is there
  bool is_paused = false;  ///< by set_paused(), whatever it is at
  std::string integrator;  ///< the one that is chosen; "": the scene's own
};

/// Of an error or of something to know.
struct Message {
  bool is_error = false;
  std::string text;
  uint64_t number = 0;  ///< counts them from 1, in the order in which they came up
};

/// A scene that is rendered again and again while it is edited: a thread of its own renders, and
/// makes all changes between renders. Each change is followed by a preview, of as many pixels as
/// can be rendered in a short time, then by pictures of all pixels that get better pass by pass,
/// until the next change.
///
/// All of its functions may be called by any thread. None of them waits for a render, and none but
/// pick(), wait() and close() for anything that takes its time. What goes wrong is told by
/// messages(), and leaves the scene as it was.
class RenderSession {
 public:
  struct Options {
    std::string scene;  ///< its file
    LoadOptions load;
    std::vector<std::string> plugin_folders;  ///< in addition to the usual ones
    std::string integrator;                   ///< "": the scene's own
    std::string sensor = "0";                 ///< index or id
    int width = 0, height = 0;                ///< 0: as the scene says
    unsigned threads = 0;                     ///< 0: one per core
    uint64_t seed = 0;
    /// Samples a pixel at which it is left alone.
    double most_samples = 16384;
    /// What a preview may take, together with the change that it shows [s].
    double preview_seconds = 0.07;
    /// Render by itself; false: only what render() asks for.
    bool is_live = true;
    /// Called by the session's thread whenever there is something new to see; returns at once.
    std::function<void()> on_change;
  };

  /// Begins to load the scene.
  explicit RenderSession(Options options);
  /// Closes it.
  ~RenderSession();
  RenderSession(const RenderSession&) = delete;
  RenderSession& operator=(const RenderSession&) = delete;

  /// The latest; nullptr: there is none yet.
  PicturePointer picture() const;
  /// nullptr while the scene is loaded. May be a little older than the picture.
  std::shared_ptr<const SceneInfo> info() const;
  Status status() const;
  /// The latest ones, some hundred at most, of those with greater numbers than this. Warnings are
  /// among them.
  std::vector<Message> messages(uint64_t known = 0) const;
  void say(bool is_error, std::string text);

  /// Sets parameters: all of these, or, where one of them can't be, none. Of those that wait to be
  /// made, the last of the same path counts. `is_moving`: more of the kind will follow at once, as
  /// while something is dragged, so that nothing but previews is worth while; `is_undoable`: undo()
  /// takes it back.
  /// Returns its number, by which SceneInfo::served tells that it was made, or refused.
  uint64_t set(Edits edits, bool is_moving = false, bool is_undoable = true);
  /// Takes back the last set(). Those of the same paths that followed on each other count as one.
  void undo();
  /// By its plugin's name; "": the scene's own.
  void set_integrator(std::string name);
  void set_sensor(size_t index);
  void set_paused(bool is_paused);
  /// Begins the picture anew, also where render() has made the one that there is.
  void restart();
  /// Renders just the picture that `kinome` renders with so many samples a pixel (to the bit), and
  /// leaves it until the next change.
  void render(uint32_t samples);
  /// Loads the file anew, without what was edited.
  void reload();

  /// The scene as it is when a task is run.
  struct Access {
    SceneEditor& editor;
    const Scene& scene;    ///< with the integrator that is chosen
    const Sensor& sensor;  ///< the one that is rendered; its film is that of the picture: see
                           ///< with_own_film()
    unsigned threads;
  };
  using Task = std::function<void(const Access&)>;
  /// Has the session's thread do something between two passes, once all that was set before is
  /// made: the picture isn't begun anew. What it throws becomes a message. It must not call pick(),
  /// wait() or close().
  void run(Task task);
  /// Saves the scene as XML, as it is by all that was asked for before: SceneEditor::save().
  void save(std::string path);
  /// A save is still to be done.
  bool is_to_save() const;
  /// Ends what is being rendered, without waiting for it to be finished, does the saves that wait,
  /// and ends the session's thread. What there is may still be looked at. By one thread.
  void close();
  /// Waits until all that was asked for is done: changes and tasks are made, and what render() asks
  /// for is rendered.
  void wait() const;

  /// What is seen at a place of the sensor's film [pixels]; nullopt: no surface.
  /// May wait for a change or a task.
  std::optional<Pick> pick(const Vec2& film_position) const;
  /// The same without waiting: where the session is at a change or a task, it answers after that.
  std::shared_ptr<const PickAnswer> ask_pick(const Vec2& film_position) const;

 private:
  class Worker;
  std::unique_ptr<Worker> worker_;
};

}  // namespace kinome::viewer
