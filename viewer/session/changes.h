#pragma once

#include <chrono>
#include <vector>

#include "session/render_session.h"

namespace kinome::viewer {

/// Edits that were asked for by one call.
struct Change {
  Edits edits;
  bool is_undoable = true;
};

/// Adds a change to those that wait: of parameters that are set again, only the last setting is
/// left.
void add_change(std::vector<Change>& waiting, Change change);

/// Makes changes of a scene, and takes them back. Not thread-safe.
class ChangeHistory {
 public:
  /// Makes all of them by one update; where that fails, one by one. True: the scene has changed.
  /// `tell` is called with what is wrong.
  bool make(SceneEditor& editor, const std::vector<Change>& changes,
            const std::function<void(const std::string&)>& tell);
  /// Takes back the last one. False: there is none, or it can't be.
  bool undo(SceneEditor& editor, const std::function<void(const std::string&)>& tell);
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

/// All that is wrong, a line each.
std::string text_of(const std::exception& fault);

}  // namespace kinome::viewer
