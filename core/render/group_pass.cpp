#include "render/group_pass.h"

#include <limits>

#include "kinome/error.h"
#include "kinome/process_group.h"
#include "kinome/shared_items.h"

namespace kinome {
namespace {

constexpr uint64_t kNoItem = std::numeric_limits<uint64_t>::max();

void transfer(RenderCounters& counters, SharedBytes& bytes) {
  bytes.values(counters.rays, counters.embree_seconds, counters.skipped_shadow_rays);
  auto stages = static_cast<uint32_t>(counters.stage_seconds.size());
  bytes.value(stages);
  auto next = counters.stage_seconds.begin();
  for (; stages > 0; --stages) {
    std::string name = bytes.reads() ? "" : next->first;
    double seconds = bytes.reads() ? 0 : next->second;
    bytes.text(name);
    bytes.value(seconds);
    if (bytes.reads()) {
      counters.stage_seconds[name] = seconds;
    } else {
      ++next;
    }
  }
}

}  // namespace

void FirstException::capture(size_t item) {
  const std::lock_guard lock(mutex_);
  if (!exception_ || item < item_) {
    exception_ = std::current_exception();
    item_ = item;
  }
  any_.store(true, std::memory_order_relaxed);
}

std::string FirstException::message() const {
  try {
    rethrow();
  } catch (const std::bad_alloc&) {
    return "out of memory";
  } catch (const std::exception& error) {
    return error.what();
  } catch (...) {
    return "an unknown exception was thrown";
  }
  return {};
}

void GroupPass::add_finished(size_t item) {
  if (!shared_) return;
  const std::lock_guard lock(mutex_);
  finished_.push_back(item);
}

std::string GroupPass::report(bool interrupted, bool late, RenderCounters& counters,
                              const FirstException& exception) const {
  SharedBytes bytes;
  uint64_t failed = exception.any() ? exception.item() : kNoItem;
  std::string message = exception.message();
  bytes.values(interrupted, late, failed);
  bytes.text(message);
  transfer(counters, bytes);
  for (uint64_t item : finished_) {
    bytes.value(item);
    if (shared_->transfer()) shared_->transfer()(item, bytes);
  }
  return bytes.written();
}

GroupPass::Outcome GroupPass::end(bool interrupted, bool late, RenderCounters counters,
                                  const FirstException& exception) {
  const std::vector<std::string> reports =
      group_.end_pass(report(interrupted, late, counters, exception));
  Outcome outcome;
  std::vector<int> ranks(shared_ ? items_ : 0);
  uint64_t first_failed = kNoItem;
  std::string first_message;
  for (int rank = 0; rank < group_.size(); ++rank) {
    SharedBytes bytes(reports[rank]);
    bool is_interrupted = false, is_late = false;
    uint64_t failed = 0;
    std::string message;
    RenderCounters theirs;
    bytes.values(is_interrupted, is_late, failed);
    bytes.text(message);
    transfer(theirs, bytes);
    outcome.interrupted = outcome.interrupted || is_interrupted;
    outcome.late = outcome.late || is_late;
    outcome.counters.add(theirs);
    if (failed < first_failed) {
      first_failed = failed;
      first_message = message;
    }
    if (rank == group_.rank()) {
      for (const size_t item : finished_) ranks.at(item) = rank;
      continue;
    }
    while (!bytes.at_end()) {
      uint64_t item = 0;
      bytes.value(item);
      ranks.at(item) = rank;
      if (shared_->transfer()) shared_->transfer()(item, bytes);
    }
  }
  if (first_failed != kNoItem) throw AgreedError(first_message);
  if (shared_) shared_->set_ranks(std::move(ranks));
  return outcome;
}

}  // namespace kinome
