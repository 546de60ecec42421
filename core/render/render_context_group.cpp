// The functions of RenderContext that processes of a group call collectively. A single process
// computes the results alone.

#include <algorithm>

#include "kinome/work_source.h"
#include "kinome/process_group.h"
#include "kinome/render_context.h"
#include "kinome/shared_items.h"

namespace kinome {

double RenderContext::decide(const std::function<double()>& decide) {
  if (!is_root()) return agree(0);
  return agree(work_source_ ? work_source_->decide(decide) : decide());
}

double RenderContext::agree(double value) {
  if (!options_.group) return value;
  SharedBytes own;
  own.value(value);
  const std::string said = options_.group->broadcast(own.written(), "decisions");
  SharedBytes(said).value(value);
  return value;
}

void RenderContext::add_up(std::span<uint64_t> numbers) {
  if (!options_.group) return;
  SharedBytes own;
  own.items(numbers);
  const std::vector<std::string> all = options_.group->gather(own.written(), "sums");
  std::fill(numbers.begin(), numbers.end(), 0);
  for (const std::string& bytes : all) {
    SharedBytes theirs(bytes);
    for (uint64_t& number : numbers) {
      uint64_t more = 0;
      theirs.value(more);
      number += more;
    }
  }
}

bool RenderContext::is_root() const {
  return !options_.group || options_.group->is_root();
}

bool RenderContext::interrupted() const {
  if (!options_.group) return is_interrupted_here();
  return group_interrupted_ || (group_at_work_ && is_interrupted_here());
}

bool RenderContext::cancelled() const {
  if (!options_.group) return is_interrupted_here() || is_late_here();
  return interrupted() || (group_at_work_ ? is_late_here() : group_late_.load());
}

void RenderContext::set_deadline(double seconds) {
  deadline_ = seconds;
  group_late_ = false;
}

}  // namespace kinome
