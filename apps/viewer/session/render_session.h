#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "kinome/log_listener.h"
#include "kinome/render_context.h"
#include "kinome/scene_editor.h"
#include "session/changes.h"
#include "session/live_render.h"
#include "picture/outline.h"
#include "session/picture.h"
#include "session/preview_denoiser.h"

namespace kinome::viewer {

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
  Aabb bounds;                         ///< of the shape, in world space
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
  double fraction = 0;        ///< finished part of the pass, or of the samples passed to render()
  bool is_exact = false;      ///< render() is running or finished
  bool is_paused = false;     ///< by set_paused(), independent of the activity
  bool is_denoising = false;  ///< by set_denoising()
  std::optional<Rect> region{};  ///< by set_region()
  std::string integrator;     ///< selected integrator; "" for the scene's own
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
    double max_samples = 16384;
    /// Time for a preview, including the change that it shows [s].
    double preview_seconds = 0.07;
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
  /// Denoises previews, which are rendered while the camera moves or parameters change. Off at
  /// first. A missing library is an error in messages(), and leaves it off.
  void set_denoising(bool is_denoising);
  /// Restricts further passes to the tiles of the film that overlap a region [pixels of the full
  /// film]; nullopt ends the restriction. The whole image is still rendered by previews, by the
  /// first passes after a change, and by render(). Another scene or sensor ends it, too.
  void set_region(std::optional<Rect> region);
  /// Restarts the image, even if it is the result of render().
  void restart();
  /// Renders the image that `kinome` renders with this number of samples per pixel,
  /// bit-identically, and keeps it until the next change.
  void render(uint32_t samples);
  /// Loads the file again and discards all edits.
  void reload();
  /// Loads another scene file, without the definitions and the sensor of Options. If that fails,
  /// the current scene remains.
  void open(std::string scene);

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
  bool is_to_save() const { return saves_to_come_ > 0; }
  /// Cancels the current render, does the pending saves, and ends the session's thread. The
  /// functions that return results remain usable. Only one thread may call it.
  void close();
  /// Waits until all changes and tasks are done and the image of render() is finished.
  void wait();

  /// Returns the surface at a position on the sensor's film [pixels], or nullopt if there is none.
  /// Waits for a change or task that is running.
  std::optional<Pick> pick(const Vec2& film_position) const;
  /// Requests the same without waiting. The answer arrives after the current change or task, or at
  /// once if there is none.
  std::shared_ptr<const PickAnswer> ask_pick(const Vec2& film_position);
  /// Returns the outline of a shape, by its path, in an image, from a ray through each cell of
  /// `cell` x `cell` pixels. The outline is empty if the image has no sensor or no shape has this
  /// path. Returns nullopt if the scene is changed in the meantime. Waits for a change or task that
  /// is running if `may_wait`, and returns nullopt otherwise. Takes about 0.1 s for a million
  /// cells.
  std::optional<Outline> outline(const Picture& picture, const std::string& shape, float cell,
                                 bool may_wait) const;

 private:
  using Clock = std::chrono::steady_clock;

  /// A request to the session's thread, which processes requests in order.
  struct Request {
    enum class Kind { kSet, kUndo, kReload, kTask, kSave, kOther };
    Kind kind;
    std::function<void()> serve;     ///< unused for kSet
    std::function<void()> refuse{};  ///< called instead if there is no scene; may be empty
    // For kSet. Consecutive requests become one.
    std::vector<Change> changes{};
    bool is_moving = false;
    Clock::time_point when{};  ///< time of the last change
  };

  /// Appends a request and returns its number. `ends_render` cancels the current render, unless it
  /// is a preview.
  uint64_t request(bool ends_render, Request asked);
  void work();
  std::optional<std::vector<Request>> take_requests();
  void load(const std::string& file);
  void make(const std::vector<Request>& requests);
  void make_at_the_end();
  void make_changes(const Request& settings);
  void run_now(const Task& task);
  /// Returns true unless `function` throws, which becomes a message.
  bool attempt(const std::function<void()>& function);
  void warn(const std::string& text);
  std::optional<Pick> picked(const Vec2& film_position) const;
  void take_edited_scene();
  void begin_anew();
  size_t choose_sensor(SceneEditor& editor, const std::string& file) const;
  bool has_work() const;
  bool can_end_pass() const;
  bool is_still() const;
  void preview();
  double preview_of(int width, int height, double start);
  void improve();
  void render_exactly();
  /// Contents of a published image: a preview, passes with a part of the next one, whole passes, or
  /// all requested samples.
  enum class Shows { kPreview, kPart, kPasses, kAll };
  void publish(const Scene& scene, Image image, Shows shows, double seconds, double rel_mse);
  void publish_live();
  void publish_info();
  void set_activity(Activity activity);
  void report_non_finite_samples(const RenderStats& stats);
  std::shared_ptr<const Scene> with_integrator(SceneEditor& editor, const std::string& name) const;
  /// Returns the name of the plugin without its category, such as "path".
  static std::string name_of(const Integrator& integrator);
  const Scene& preview_scene();
  const Sensor& sensor() const { return *scene_->sensors()[sensor_]; }
  void notify() const {
    if (options_.on_change) options_.on_change();
  }

  const Options options_;

  // Protected by mutex_.
  mutable std::mutex mutex_;
  PicturePointer picture_;
  std::shared_ptr<const SceneInfo> info_;
  Status status_;
  std::deque<Message> messages_;  ///< the latest ones
  uint64_t num_messages_ = 0;
  std::vector<Request> requests_;
  std::condition_variable changed_;
  bool is_closing_ = false;
  /// Number of the last request that has arrived, has been taken by the thread, and is done.
  /// Loading is request 1.
  uint64_t last_requested_ = 1, last_taken_ = 1, last_served_ = 0;
  bool may_be_ended_ = false;  ///< requests may cancel the current render

  // Used by all threads without a mutex.
  std::atomic<bool> cancel_ = false;
  std::atomic<bool> can_undo_ = false;
  std::atomic<double> fraction_ = 0;
  std::atomic<int> saves_to_come_ = 0;

  /// Held while the scene is changed, and by other threads that read it. Lock it before mutex_.
  mutable std::mutex scene_mutex_;
  std::shared_ptr<const Scene> scene_;  ///< with the selected integrator
  size_t sensor_ = 0;

  // Used by the session's thread.
  std::string file_;  ///< scene file
  std::unique_ptr<PluginRegistry> registry_;
  std::unique_ptr<SceneEditor> editor_;
  std::unique_ptr<RenderContext> context_;
  ChangeHistory history_;
  std::unique_ptr<LiveRender> live_;
  std::string integrator_;                      ///< selected integrator; "" for the scene's own
  std::shared_ptr<const Scene> preview_scene_;  ///< nullptr until preview_scene() makes it
  std::unique_ptr<const PreviewDenoiser> denoiser_;  ///< nullptr unless previews are denoised
  std::shared_ptr<const Scene> guide_scene_;         ///< nullptr until a preview is denoised
  std::optional<Rect> region_;                       ///< by set_region()
  uint64_t edition_ = 0;
  uint64_t generation_ = 0;
  uint64_t reported_edition_ = ~uint64_t{0};  ///< edition whose non-finite samples were reported
  uint64_t info_edition_ = ~uint64_t{0};
  bool wants_preview_ = false;
  bool is_coarse_ = false;  ///< the image is a preview; a pass follows it even when paused
  bool wants_whole_preview_ = false;
  bool has_finished_tiles_ = false;  ///< of an interrupted pass; they aren't published yet
  bool is_paused_ = false;
  bool is_moving_ = false;
  Clock::time_point last_change_{};
  std::optional<uint32_t> exact_samples_;  ///< samples per pixel passed to render()
  bool is_done_ = false;                   ///< there is nothing left to render
  double seconds_per_pixel_ = 0;           ///< time of previews; 0 if unknown

  const LogListener listener_{[this](const std::string& warning) { warn(warning); }};
  std::thread thread_;
};

}  // namespace kinome::viewer
