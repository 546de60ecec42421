#include "rendering.h"

#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <atomic>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <optional>
#include <thread>

#include "values.h"

namespace kinome::python {
namespace {

/// How often it is looked for Ctrl-C, and progress is told.
constexpr std::chrono::milliseconds kPatience{50};

/// What the thread that renders has for the one that waits.
class Exchange {
 public:
  struct Pass {
    Image picture;
    double samples;
  };
  void tell(double fraction) { fraction_ = fraction; }
  double fraction() const { return fraction_; }
  /// Waits until it is taken, so that each is seen.
  void give(Pass pass) {
    std::unique_lock lock(mutex_);
    pass_ = std::move(pass);
    changed_.notify_all();
    changed_.wait(lock, [&] { return !pass_; });
  }
  void finish() {
    const std::lock_guard lock(mutex_);
    is_done_ = true;
    changed_.notify_all();
  }
  /// Whether the render has ended; `pass`: one that nobody has seen.
  bool wait(std::optional<Pass>& pass) {
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, kPatience, [&] { return is_done_ || pass_.has_value(); });
    pass = std::exchange(pass_, std::nullopt);
    changed_.notify_all();
    return is_done_ && !pass;
  }

 private:
  std::atomic<double> fraction_ = 0;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::optional<Pass> pass_;
  bool is_done_ = false;
};

/// Passes of 1, 1, 2, 4, … samples a pixel, so that each has seen half of what there is.
Image render_by_passes(const Scene& scene, const Sensor& sensor, RenderContext& context,
                       double seconds, Exchange& exchange) {
  const Integrator& integrator = scene.integrator();
  Film& film = sensor.film();
  film.prepare(integrator.layers(), integrator.channels());
  RenderStats& stats = context.stats();
  const StageTimer timer(stats.render_seconds);
  const auto passes = integrator.begin(scene, sensor, context, seconds > 0 ? seconds : kInfinity);
  const double wanted = seconds > 0 ? RenderBudget::kMostSamples : passes->samples();
  if (seconds > 0) context.set_deadline(seconds);
  double done = 0;
  for (uint64_t i = 1; done < wanted - 0.5 && !context.cancelled(); ++i) {
    const double next = std::min(std::max(1., done), wanted - done);
    context.begin_pass(i, done / wanted, std::min(1., (done + next) / wanted));
    done += passes->render(next);
    if (!context.cancelled()) exchange.give({film.develop(), done});
  }
  context.begin_pass(0, 0, 1);
  stats.samples = done;
  stats.threads = context.threads();
  stats.complete = !context.interrupted();
  stats.non_finite_samples += film.non_finite();
  return film.develop();
}

void call_back(const RenderRequest& request, double fraction, double& told,
               std::optional<Exchange::Pass>& pass) {
  if (!request.progress.is_none() && fraction > told) {
    told = fraction;
    request.progress(fraction);
  }
  if (pass && !request.on_pass.is_none()) {
    const std::vector<std::string> channels = pass->picture.channels;
    request.on_pass(picture_array(std::move(pass->picture)), channels, pass->samples);
  }
}

}  // namespace

Image render_for_python(const RenderRequest& request, RenderStats& stats) {
  Exchange exchange;
  std::atomic<bool> cancel = false;
  std::exception_ptr fault_of_render, fault_of_python;
  Image image;
  std::thread renderer([&] {
    try {
      std::unique_ptr<Sensor> other;
      if (request.samples > 0) other = request.sensor->with_sample_count(request.samples);
      const Sensor& sensor = other ? *other : *request.sensor;
      const bool by_passes = !request.on_pass.is_none();
      RenderContext context({.threads = request.threads,
                             .seed = request.seed,
                             .cancel = &cancel,
                             .progress = [&](double fraction) { exchange.tell(fraction); },
                             .budget = {.seconds = by_passes ? 0 : request.seconds,
                                        .rel_mse = request.rel_mse,
                                        .lanes = request.lanes}});
      image = by_passes
                  ? render_by_passes(*request.scene, sensor, context, request.seconds, exchange)
                  : render(*request.scene, sensor, context);
      stats = std::move(context.stats());
    } catch (...) {
      fault_of_render = std::current_exception();
    }
    exchange.finish();
  });
  const auto stop_for = [&](std::exception_ptr fault) {
    if (!fault_of_python) fault_of_python = std::move(fault);
    cancel = true;
  };
  double told = -1;
  for (bool is_done = false; !is_done;) {
    std::optional<Exchange::Pass> pass;
    {
      const nb::gil_scoped_release release;
      is_done = exchange.wait(pass);
    }
    try {
      if (PyErr_CheckSignals() != 0) {
        if (!PyErr_ExceptionMatches(PyExc_KeyboardInterrupt)) nb::raise_python_error();
        PyErr_Clear();
        cancel = true;
      }
      if (!cancel) call_back(request, is_done ? 1 : exchange.fraction(), told, pass);
    } catch (...) {
      stop_for(std::current_exception());
    }
  }
  renderer.join();
  if (fault_of_python) std::rethrow_exception(fault_of_python);
  if (fault_of_render) std::rethrow_exception(fault_of_render);
  return image;
}

}  // namespace kinome::python
