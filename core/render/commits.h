#pragma once

#include <map>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "kinome/scheduler.h"

namespace kinome {

class WorkSource;

/// Queue for the results of a loop's items. Adds them to the film in the order of their indices,
/// whatever order they finish in, so that sums always have the same bits. Thread-safe.
class Commits {
 public:
  /// `source` may be nullptr. Both arguments must outlive this object.
  Commits(WorkSource* source, const CommitCallback& on_commit)
      : source_(source), on_commit_(on_commit) {}

  /// Sets the items of the loop that need no work. Call before the items run.
  void leave_out(std::vector<bool> items) { left_out_ = std::move(items); }
  /// True if the item needs no work: it is left out, or in the film already (resumed render).
  bool is_done(size_t item) const;

  /// Queues the result of an item, and adds all items whose turn it is.
  void finish(Film& film, size_t item, std::vector<FilmTile> tiles);
  /// Adds the result of an item to the film immediately.
  void add(Film& film, size_t item, const std::vector<FilmTile>& tiles) const;
  /// Calls finish() for the message of pack() in another process.
  void receive(Film& film, std::string_view message);
  static std::string pack(size_t item, std::vector<FilmTile> tiles);

  /// Writes the checkpoint with the current contents of the film.
  void save();
  /// Adds the items that wait for an earlier item, which was cancelled.
  void commit_rest();
  /// The film of the loop; nullptr if no item has finished.
  Film* film() const { return film_; }

 private:
  WorkSource* const source_;
  const CommitCallback& on_commit_;
  std::vector<bool> left_out_;
  Film* film_ = nullptr;
  std::mutex mutex_;
  std::map<size_t, std::vector<FilmTile>> waiting_;
  size_t next_ = 0;  ///< index of the next item to add to the film
};

}  // namespace kinome
