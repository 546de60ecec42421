#include "session/changes.h"

#include <algorithm>

namespace kinome::viewer {
namespace {

/// Settings of the same parameters that follow on each other, as while a slider is dragged, are one
/// change to whoever undoes it.
constexpr std::chrono::milliseconds kOneChange{1000};
constexpr size_t kMostUndone = 256;
constexpr size_t kMostLines = 10;

bool are_of_same_paths(const Edits& a, const Edits& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const auto& x, const auto& y) { return x.first == y.first; });
}

/// What sets all back that a change sets.
Edits edits_before(const SceneEditor& editor, const Change& change) {
  Edits before;
  if (!change.is_undoable) return before;
  for (const auto& [path, value] : change.edits) before.emplace_back(path, editor.edit_of(path));
  return before;
}

/// Whether there may be other objects afterwards, and other paths.
bool puts_or_takes(const Change& change) {
  return std::any_of(change.edits.begin(), change.edits.end(), [](const auto& edit) {
    return std::holds_alternative<ObjectDescription>(edit.second) ||
           std::holds_alternative<Unset>(edit.second) ||
           std::holds_alternative<AsWritten>(edit.second);
  });
}

}  // namespace

std::string text_of(const std::exception& fault) {
  const auto* const all = dynamic_cast<const Errors*>(&fault);
  if (!all) return fault.what();
  std::string text;
  for (size_t i = 0; i < std::min(all->all().size(), kMostLines); ++i) {
    if (i > 0) text += '\n';
    text += all->all()[i].what();
  }
  return text;
}

void add_change(std::vector<Change>& waiting, Change change) {
  for (Change& earlier : waiting) {
    std::erase_if(earlier.edits, [&](const auto& old) {
      return std::any_of(change.edits.begin(), change.edits.end(),
                         [&](const auto& edit) { return edit.first == old.first; });
    });
  }
  std::erase_if(waiting, [](const Change& earlier) { return earlier.edits.empty(); });
  waiting.push_back(std::move(change));
}

bool ChangeHistory::make(SceneEditor& editor, const std::vector<Change>& changes,
                         const std::function<void(const std::string&)>& tell) {
  if (changes.empty()) return false;
  const bool is_one_by_one =
      changes.size() > 1 && std::any_of(changes.begin(), changes.end(), puts_or_takes);
  if (!is_one_by_one) {
    try {
      std::vector<Edits> before;
      Edits all;
      for (const Change& change : changes) {
        before.push_back(edits_before(editor, change));
        all.insert(all.end(), change.edits.begin(), change.edits.end());
      }
      editor.set(std::move(all));
      editor.update();
      for (Edits& one : before) note(std::move(one));
      return true;
    } catch (const std::exception& fault) {
      if (changes.size() == 1) {
        tell(text_of(fault));
        return false;
      }
    }
  }
  bool has_changed = false;
  for (const Change& change : changes) has_changed |= make(editor, {change}, tell);
  return has_changed;
}

void ChangeHistory::note(Edits before) {
  if (before.empty()) return;
  const Clock::time_point now = Clock::now();
  if (!done_.empty() && now - done_.back().when < kOneChange &&
      are_of_same_paths(done_.back().before, before)) {
    done_.back().when = now;
    return;
  }
  if (done_.size() == kMostUndone) done_.erase(done_.begin());
  done_.push_back({std::move(before), now});
}

bool ChangeHistory::undo(SceneEditor& editor, const std::function<void(const std::string&)>& tell) {
  if (done_.empty()) return false;
  const Edits before = std::move(done_.back().before);
  done_.pop_back();
  try {
    editor.set(before);
    editor.update();
    return true;
  } catch (const std::exception& fault) {
    tell(text_of(fault));
    return false;
  }
}

}  // namespace kinome::viewer
