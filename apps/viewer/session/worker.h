#pragma once

#include <atomic>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <thread>
#include <variant>

#include "kinome/log_listener.h"
#include "kinome/render_context.h"
#include "session/changes.h"
#include "session/live_render.h"
#include "session/render_session.h"

namespace kinome::viewer {

/// Requests to the session. They are processed in order.
struct Settings {
  std::vector<Change> changes;
  bool is_moving = false;
  std::chrono::steady_clock::time_point when{};  ///< time of the last change
};
struct Undo {};
struct Restart {};
struct Reload {};
struct UseIntegrator {
  std::string name;
};
struct UseSensor {
  size_t index;
};
struct Pause {
  bool is_paused;
};
struct RenderExactly {
  uint32_t samples;
};
struct RunTask {
  RenderSession::Task task;
  bool is_save = false;  ///< also runs if the session is closed first
};
struct AskPick {
  Vec2 film_position;
  std::shared_ptr<PickAnswer> answer;
};
using Request = std::variant<Settings, Undo, Restart, Reload, UseIntegrator, UseSensor, Pause,
                             RenderExactly, RunTask, AskPick>;

/// The session's thread, and the state that it shares with other threads. `mutex` protects the
/// public members, except where noted.
class RenderSession::Worker {
 public:
  explicit Worker(Options options);
  ~Worker();

  /// Appends a request and returns its number. `ends_render` cancels the current render, unless it
  /// is a preview.
  uint64_t request(bool ends_render, Request asked);
  void say(bool is_error, std::string text);
  void warn(const std::string& text);
  void wait();
  void close();
  std::optional<Pick> pick(const Vec2& film_position);
  std::shared_ptr<const PickAnswer> ask_pick(const Vec2& film_position);

  mutable std::mutex mutex;
  struct Shown {
    PicturePointer picture;
    std::shared_ptr<const SceneInfo> info;
    Status status;
    std::string integrator;
    std::deque<Message> messages;  ///< the latest ones
  } shown;
  std::atomic<double> fraction = 0;    ///< needs no mutex
  std::atomic<int> saves_to_come = 0;  ///< needs no mutex

 private:
  using Clock = std::chrono::steady_clock;

  void work();
  void load();
  void make(std::vector<Request> requests);
  void make_at_the_end();
  void serve(Settings& settings);
  void serve(Undo&);
  void serve(Restart&) { begin_anew(); }
  void serve(Reload&) { load(); }
  void serve(UseIntegrator& use);
  void serve(UseSensor& use);
  void serve(Pause& pause) { is_paused_ = pause.is_paused; }
  void serve(RenderExactly& exactly);
  void serve(RunTask& run);
  void serve(AskPick& ask);
  std::optional<Pick> picked(const Vec2& film_position) const;
  void take_edited_scene();
  void begin_anew();
  size_t choose_sensor(SceneEditor& editor) const;
  bool has_work() const;
  bool is_still() const;
  void preview();
  double preview_of(int width, int height, double start);
  void improve();
  void render_exactly();
  void publish(const Scene& scene, Image image, bool is_preview, bool is_final, double seconds,
               double rel_mse);
  void publish_info();
  void set_activity(Activity activity);
  void report_non_finite_samples(const RenderStats& stats);
  std::shared_ptr<const Scene> with_integrator(SceneEditor& editor, const std::string& name) const;
  const Scene& preview_scene();
  const Sensor& sensor() const { return *scene_->sensors()[sensor_]; }
  void notify() const {
    if (options_.on_change) options_.on_change();
  }

  const Options options_;

  // Protected by `mutex`, except where noted.
  std::vector<Request> requests_;
  std::condition_variable changed_;
  bool is_closing_ = false;
  /// Number of the last request that has arrived, has been taken by the thread, and is done.
  /// Loading is request 1.
  uint64_t asked_ = 1, taken_ = 1, served_ = 0;
  bool may_be_ended_ = false;  ///< requests may cancel the current render
  std::atomic<bool> cancel_ = false;
  std::atomic<bool> can_undo_ = false;  ///< needs no mutex

  /// Held while the scene is changed, and by other threads that read it. Lock it before `mutex`.
  std::mutex scene_mutex_;
  std::shared_ptr<const Scene> scene_;  ///< with the selected integrator
  size_t sensor_ = 0;

  // Used by the session's thread.
  std::unique_ptr<PluginRegistry> registry_;
  std::unique_ptr<SceneEditor> editor_;
  std::unique_ptr<RenderContext> context_;
  ChangeHistory history_;
  std::unique_ptr<LiveRender> live_;
  std::string integrator_;                      ///< selected integrator; "" for the scene's own
  std::shared_ptr<const Scene> preview_scene_;  ///< nullptr until preview_scene() makes it
  uint64_t edition_ = 0;
  uint64_t generation_ = 0;
  uint64_t reported_edition_ = ~uint64_t{0};  ///< edition whose non-finite samples were reported
  uint64_t info_edition_ = ~uint64_t{0};
  bool wants_preview_ = false;
  bool is_coarse_ = false;  ///< the image is a preview; a pass follows it even when paused
  bool wants_whole_preview_ = false;
  bool is_paused_ = false;
  bool is_moving_ = false;
  Clock::time_point last_change_{};
  std::optional<uint32_t> exact_samples_;  ///< samples per pixel passed to render()
  bool is_done_ = false;                   ///< there is nothing left to render
  double seconds_per_pixel_ = 0;           ///< time of previews; 0 if unknown

  uint64_t num_messages_ = 0;  ///< protected by `mutex`
  const LogListener listener_{[this](const std::string& warning) { warn(warning); }};
  std::thread thread_;
};

}  // namespace kinome::viewer
