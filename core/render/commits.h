#pragma once

#include <map>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "kinome/film.h"

namespace kinome {

class Checkpoint;
class RenderContext;

/// What the items of a pass have made, on its way to the film: in the order of their numbers,
/// whatever order they are finished in, so that sums have the same bits always. Thread-safe.
class Commits {
 public:
  explicit Commits(RenderContext& context) : context_(context) {}

  void finish(Film& film, size_t item, std::vector<FilmTile> tiles);
  /// What pack() has made in another process.
  void receive(Film& film, std::string_view bytes);
  static std::string pack(size_t item, std::vector<FilmTile> tiles);

  /// What is in the film so far.
  void save(Checkpoint& checkpoint);
  /// What waits for an item that will not come any more.
  void commit_rest();
  /// nullptr: there was nothing to commit.
  Film* film() const { return film_; }

 private:
  RenderContext& context_;
  Film* film_ = nullptr;
  std::mutex mutex_;
  std::map<size_t, std::vector<FilmTile>> waiting_;
  size_t next_ = 0;
};

}  // namespace kinome
