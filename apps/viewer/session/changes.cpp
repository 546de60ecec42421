#include "session/changes.h"

#include <algorithm>

namespace kinome::viewer {
namespace {

/// Consecutive changes of the same parameters within this interval, such as the drag of a slider,
/// are undone together.
constexpr std::chrono::milliseconds kMergeInterval{1000};
constexpr size_t kMaxUndoSteps = 256;
constexpr size_t kMaxErrorLines = 10;

bool are_of_same_paths(const Edits& a, const Edits& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const auto& x, const auto& y) { return x.first == y.first; });
}

/// Returns the edits that undo a change.
Edits edits_before(const SceneEditor& editor, const Change& change) {
  Edits before;
  if (!change.is_undoable) return before;
  for (const auto& [path, value] : change.edits) before.emplace_back(path, editor.edit_of(path));
  return before;
}

/// Returns true if a change can add or remove objects, and so change paths.
bool changes_objects(const Change& change) {
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
  for (size_t i = 0; i < std::min(all->all().size(), kMaxErrorLines); ++i) {
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
                         const std::function<void(const std::string&)>& report) {
  if (changes.empty()) return false;
  const bool is_one_by_one =
      changes.size() > 1 && std::any_of(changes.begin(), changes.end(), changes_objects);
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
        report(text_of(fault));
        return false;
      }
    }
  }
  bool has_changed = false;
  for (const Change& change : changes) has_changed |= make(editor, {change}, report);
  return has_changed;
}

void ChangeHistory::note(Edits before) {
  if (before.empty()) return;
  const Clock::time_point now = Clock::now();
  if (!done_.empty() && now - done_.back().when < kMergeInterval &&
      are_of_same_paths(done_.back().before, before)) {
    done_.back().when = now;
    return;
  }
  if (done_.size() == kMaxUndoSteps) done_.erase(done_.begin());
  done_.push_back({std::move(before), now});
}

void ChangeHistory::undo(SceneEditor& editor) {
  Edits before = std::move(done_.back().before);
  done_.pop_back();
  editor.set(std::move(before));
  editor.update();
}

}  // namespace kinome::viewer
