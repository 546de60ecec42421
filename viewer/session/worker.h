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

/// What the session is asked for: all of it is done in the order in which it was asked for.
struct Settings {
  std::vector<Change> changes;
  bool is_moving = false;
  std::chrono::steady_clock::time_point when{};  ///< of the last one
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
  bool is_save = false;  ///< is done, too, where the session is closed before
};
struct AskPick {
  Vec2 film_position;
  std::shared_ptr<PickAnswer> answer;
};
using Request = std::variant<Settings, Undo, Restart, Reload, UseIntegrator, UseSensor, Pause,
                             RenderExactly, RunTask, AskPick>;

/// The session's thread, and what it shares with others: by `mutex` but for what says otherwise.
class RenderSession::Worker {
 public:
  explicit Worker(Options options);
  ~Worker();

  /// `ends_render`: what is rendered isn't wanted any more, unless it is a preview.
  /// Returns its number.
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
  void tell_of_samples_that_are_not_finite(const RenderStats& stats);
  std::shared_ptr<const Scene> with_integrator(SceneEditor& editor, const std::string& name) const;
  const Scene& preview_scene();
  const Sensor& sensor() const { return *scene_->sensors()[sensor_]; }
  void notify() const {
    if (options_.on_change) options_.on_change();
  }

  const Options options_;

  // By the mutex.
  std::vector<Request> requests_;
  std::condition_variable changed_;
  bool is_closing_ = false;
  /// Requests are counted, loading is the first; those up to `served_` are done with.
  uint64_t asked_ = 1, taken_ = 1, served_ = 0;
  bool may_be_ended_ = false;  ///< what is rendered now
  std::atomic<bool> cancel_ = false;
  std::atomic<bool> can_undo_ = false;  ///< needs no mutex

  /// Held while the scene is changed, and by who else looks at it: before `mutex`.
  std::mutex scene_mutex_;
  std::shared_ptr<const Scene> scene_;  ///< with the chosen integrator
  size_t sensor_ = 0;

  // Of the thread.
  std::unique_ptr<PluginRegistry> registry_;
  std::unique_ptr<SceneEditor> editor_;
  std::unique_ptr<RenderContext> context_;
  ChangeHistory history_;
  std::unique_ptr<LiveRender> live_;
  std::string integrator_;                      ///< that was asked for
  std::shared_ptr<const Scene> preview_scene_;  ///< nullptr: to be made
  uint64_t edition_ = 0;
  uint64_t generation_ = 0;
  uint64_t told_edition_ = ~uint64_t{0};  ///< for which samples were told not to be finite
  uint64_t info_edition_ = ~uint64_t{0};
  bool wants_preview_ = false;
  bool is_coarse_ =
      false;  ///< what is shown: a preview, which is followed by a pass, paused or not
  bool wants_whole_preview_ = false;
  bool is_paused_ = false;
  bool is_moving_ = false;
  Clock::time_point last_change_{};
  std::optional<uint32_t> exact_samples_;  ///< to be rendered, and shown from then on
  bool is_done_ = false;                   ///< there is nothing left to render
  double change_seconds_ = 0;              ///< that the last change took to be made
  double seconds_per_pixel_ = 0;           ///< of previews; 0: unknown

  uint64_t told_ = 0;  ///< messages; by the mutex
  const LogListener listener_{[this](const std::string& warning) { warn(warning); }};
  std::thread thread_;
};

}  // namespace kinome::viewer
