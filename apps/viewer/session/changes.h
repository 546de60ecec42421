#pragma once

#include <chrono>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "kinome/scene_editor.h"

namespace kinome::viewer {

/// Paths and new values of parameters of the scene, in the order in which they are set.
using Edits = std::vector<std::pair<std::string, EditedValue>>;

/// Edits from one call of RenderSession::set().
struct Change {
  Edits edits;
  bool is_undoable = true;
};

/// Appends a change to the waiting ones. Removes earlier edits of the same parameters.
void add_change(std::vector<Change>& waiting, Change change);

/// Applies and undoes changes of a scene. Not thread-safe.
class ChangeHistory {
 public:
  /// Applies all changes with one update; one by one if that fails or if objects are added or
  /// removed. Returns true if the scene has changed. Calls `report` with each error.
  bool make(SceneEditor& editor, const std::vector<Change>& changes,
            const std::function<void(const std::string&)>& report);
  /// Undoes the last change; only if can_undo(). Throws Error if that fails.
  void undo(SceneEditor& editor);
  bool can_undo() const { return !done_.empty(); }
  void forget() { done_.clear(); }

 private:
  using Clock = std::chrono::steady_clock;
  struct Done {
    Edits before;
    Clock::time_point when;
  };
  void note(Edits before);

  std::vector<Done> done_;
};

/// Returns the message of an exception; of Errors, the first few messages, one per line.
std::string text_of(const std::exception& fault);

}  // namespace kinome::viewer
