#pragma once

#include <map>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "kinome/film.h"

namespace kinome {

class WorkSource;
class RenderContext;

/// Queue for the results of a pass's items. Adds them to the film in the order of their indices,
/// whatever order they finish in, so that sums always have the same bits. Thread-safe.
class Commits {
 public:
  explicit Commits(RenderContext& context) : context_(context) {}

  /// Queues the result of an item, and adds all items whose turn it is.
  void finish(Film& film, size_t item, std::vector<FilmTile> tiles);
  /// Calls finish() for the message of pack() in another process.
  void receive(Film& film, std::string_view message);
  static std::string pack(size_t item, std::vector<FilmTile> tiles);

  /// Writes the checkpoint with the current contents of the film.
  void save(WorkSource& source);
  /// Adds the items that wait for an earlier item, which was cancelled.
  void commit_rest();
  /// The film of the pass; nullptr if no item has finished.
  Film* film() const { return film_; }

 private:
  RenderContext& context_;
  Film* film_ = nullptr;
  std::mutex mutex_;
  std::map<size_t, std::vector<FilmTile>> waiting_;
  size_t next_ = 0;  ///< index of the next item to add to the film
};

}  // namespace kinome
