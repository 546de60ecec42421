#include "kinome/process_group.h"

#include <algorithm>

#include <fmt/format.h>

#include "kinome/shared_items.h"

namespace kinome {
namespace {

constexpr char kMark = '!';

/// Returns the message of an exception; for Errors, one line per error.
std::string message_of(const std::exception& error) {
  const auto* const errors = dynamic_cast<const Errors*>(&error);
  if (!errors) return error.what();
  std::string text;
  for (const Error& one : errors->all()) {
    if (!text.empty()) text += '\n';
    text += one.what();
  }
  return text;
}

}  // namespace

void on_all_processes(ProcessGroup* group, const std::function<void()>& fn) {
  if (!group) {
    fn();
    return;
  }
  // A mark precedes the message, because it may be empty.
  std::string failure;
  try {
    fn();
  } catch (const std::bad_alloc&) {
    failure = kMark + std::string("out of memory");
  } catch (const std::exception& error) {
    failure = kMark + message_of(error);
  } catch (...) {
    failure = kMark + std::string("an unknown exception was thrown");
  }
  const std::vector<std::string> failures = group->gather(failure, "agreement");
  const std::vector<std::string> machines = group->gather(group->machine(), "agreement");
  const auto failed = [](const std::string& text) { return !text.empty(); };
  const auto first = std::find_if(failures.begin(), failures.end(), failed);
  if (first == failures.end()) return;
  const bool by_all = std::all_of(failures.begin(), failures.end(), failed);
  const auto rank = static_cast<size_t>(first - failures.begin());
  const std::string why = first->substr(1);
  if (by_all || rank == 0) throw AgreedError(why);
  throw AgreedError(fmt::format("rank {} on {}: {}", rank, machines[rank], why));
}

bool is_root(const ProcessGroup* group) {
  return !group || group->is_root();
}

double agree(ProcessGroup* group, double value) {
  if (!group) return value;
  SharedBytes own;
  own.value(value);
  const std::string said = group->broadcast(own.written(), "decisions");
  SharedBytes(said).value(value);
  return value;
}

void sum_over_processes(ProcessGroup* group, std::span<uint64_t> numbers) {
  if (!group) return;
  SharedBytes own;
  own.items(numbers);
  const std::vector<std::string> all = group->gather(own.written(), "sums");
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

}  // namespace kinome
