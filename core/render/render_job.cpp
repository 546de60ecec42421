#include "kinome/render_job.h"

#include <mutex>

#include "kinome/process_group.h"
#include "kinome/sampler.h"
#include "kinome/work_source.h"
#include "render/item_cancelled.h"

namespace kinome {

RenderJob::RenderJob(RenderOptions options) : options_(std::move(options)) {
  if (options_.clock) return;
  options_.clock = [start = options_.start] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  };
}

void RenderJob::skip(std::string what, std::string why) {
  static std::mutex mutex;
  const std::lock_guard lock(mutex);
  for (const Skipped& s : stats_.skipped) {
    if (s.what == what && s.why == why) return;
  }
  stats_.skipped.push_back({std::move(what), std::move(why)});
}

void RenderJob::begin_pass(uint64_t index, double begin, double end) {
  pass_ = index;
  pass_begin_ = begin;
  pass_end_ = end;
  set_progress_range(0, 1);
}

uint64_t RenderJob::seed() const {
  return pass_ == 0 ? options_.seed : hash_words(options_.seed, pass_);
}

void RenderJob::set_progress_range(double begin, double end) {
  progress_begin_ = begin;
  progress_end_ = end;
}

void RenderJob::set_deadline(double seconds) {
  deadline_ = seconds;
  group_late_ = false;
}

bool RenderJob::interrupted() const {
  if (!options_.group) return is_interrupted_here();
  return group_interrupted_ || (group_at_work_ && is_interrupted_here());
}

bool RenderJob::cancelled() const {
  if (!options_.group) return is_interrupted_here() || is_late_here();
  return interrupted() || (group_at_work_ ? is_late_here() : group_late_.load());
}

void RenderJob::check_interrupt() const {
  if (options_.group && interrupted()) throw ItemCancelled();
}

bool RenderJob::is_wanted(const Rect& pixels, int layer) const {
  return !source_ || source_->is_wanted(pixels, layer);
}

double RenderJob::decide(const std::function<double()>& decide) const {
  double decision = 0;
  if (is_root(group())) decision = source_ ? source_->decide(decide) : decide();
  return agree(group(), decision);
}

WorkSource::~WorkSource() = default;

}  // namespace kinome
