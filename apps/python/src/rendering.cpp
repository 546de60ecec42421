#include "rendering.h"

#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <atomic>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <optional>
#include <thread>

#include "kinome/log.h"
#include "values.h"

namespace kinome::python {
namespace {

/// Time between two checks for Ctrl-C and reports of progress.
constexpr std::chrono::milliseconds kPollInterval{50};

/// Passes progress and images from the rendering thread to the waiting one.
class Exchange {
 public:
  struct Pass {
    Image picture;
    double samples;
    uint32_t renders;
    std::vector<double> variance_of_mean;
  };
  void report(double fraction) { fraction_ = fraction; }
  double fraction() const { return fraction_; }
  /// Hands over a pass and waits for seen(). This time is part of the render's.
  void show(Pass pass) {
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
  /// Waits for a new pass, up to kPollInterval. Returns nullptr if there is none. The caller must
  /// call seen() after using a pass.
  Pass* wait() {
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, kPollInterval, [&] { return is_done_ || pass_.has_value(); });
    return pass_ ? &*pass_ : nullptr;
  }
  void seen() {
    const std::lock_guard lock(mutex_);
    pass_.reset();
    changed_.notify_all();
  }
  bool is_done() {
    const std::lock_guard lock(mutex_);
    return is_done_;
  }

 private:
  std::atomic<double> fraction_ = 0;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::optional<Pass> pass_;
  bool is_done_ = false;
};

void call_back(const RenderRequest& request, double fraction, double& reported,
               Exchange::Pass* pass) {
  if (!request.progress.is_none() && fraction > reported) {
    reported = fraction;
    request.progress(fraction);
  }
  if (!pass) return;
  nb::dict stats;
  stats["complete"] = false;
  stats["samples"] = pass->samples;
  stats["seed"] = request.seed;
  stats["renders"] = pass->renders;
  stats["variance_of_mean"] = pass->variance_of_mean;
  const std::vector<std::string> channels = pass->picture.channels;
  request.on_pass(picture_array(std::move(pass->picture)), channels, stats);
}

/// Names of the Python arguments, for messages.
constexpr BudgetNames kNames{"time=", "error=", "render {}"};

/// Returns the sensor with the requested number of samples, or nullptr if no number is requested.
std::unique_ptr<Sensor> with_samples(const RenderRequest& request) {
  if (request.samples == 0) return nullptr;
  auto sensor = request.sensor->with_sample_count(request.samples);
  const uint32_t count = sensor->sampler().sample_count();
  if (count != request.samples && !(request.seconds > 0) && !(request.rel_mse > 0)) {
    log_warn("spp=" + std::to_string(request.samples) + " is rounded up to " +
             std::to_string(count) + ", a number that the sampler supports");
  }
  return sensor;
}

Image render_in_this_thread(const RenderRequest& request, const std::atomic<bool>& cancel,
                            Exchange& exchange, RenderStats& stats) {
  const std::unique_ptr<Sensor> other = with_samples(request);
  RenderContext context(
      {.threads = request.threads,
       .seed = request.seed,
       .cancel = &cancel,
       .progress = [&](double fraction) { exchange.report(fraction); },
       .budget = {.seconds = request.seconds, .rel_mse = request.rel_mse, .lanes = request.lanes}});
  PassCallback on_pass;
  if (!request.on_pass.is_none()) {
    on_pass = [&](Image picture, const RenderStats& so_far) {
      exchange.show({std::move(picture), so_far.samples, so_far.renders, so_far.variance_of_mean});
    };
  }
  Image image = render(*request.scene, other ? *other : *request.sensor, context, on_pass);
  warn_of_missed_budget(context.job.budget(), context.job.stats(), context.job.seconds(), kNames);
  stats = std::move(context.job.stats());
  return image;
}

}  // namespace

Image render_for_python(const RenderRequest& request, RenderStats& stats) {
  Exchange exchange;
  std::atomic<bool> cancel = false;
  std::exception_ptr fault_of_render, fault_of_python;
  Image image;
  std::thread renderer([&] {
    try {
      image = render_in_this_thread(request, cancel, exchange, stats);
    } catch (...) {
      fault_of_render = std::current_exception();
    }
    exchange.finish();
  });
  const auto stop_for = [&](std::exception_ptr fault) {
    if (!fault_of_python) fault_of_python = std::move(fault);
    cancel = true;
  };
  double reported = -1;
  for (bool is_done = false; !is_done;) {
    Exchange::Pass* pass = nullptr;
    {
      const nb::gil_scoped_release release;
      pass = exchange.wait();
      is_done = !pass && exchange.is_done();
    }
    try {
      if (PyErr_CheckSignals() != 0) nb::raise_python_error();
      // A failed render must not report that it is finished.
      const bool has_failed = is_done && fault_of_render;
      if (!cancel && !has_failed)
        call_back(request, is_done ? 1 : exchange.fraction(), reported, pass);
    } catch (const nb::python_error& error) {
      // Ctrl-C ends only the render, even during a callback.
      if (error.matches(PyExc_KeyboardInterrupt)) {
        cancel = true;
      } else {
        stop_for(std::current_exception());
      }
    } catch (...) {
      stop_for(std::current_exception());
    }
    if (pass) exchange.seen();
  }
  renderer.join();
  if (fault_of_python) std::rethrow_exception(fault_of_python);
  if (fault_of_render) std::rethrow_exception(fault_of_render);
  return image;
}

}  // namespace kinome::python
