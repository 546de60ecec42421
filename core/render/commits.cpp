#include "render/commits.h"

#include "kinome/work_source.h"
#include "kinome/render_context.h"
#include "kinome/shared_items.h"

namespace kinome {
namespace {

void transfer(FilmTile& tile, SharedBytes& bytes) {
  tile.transfer([&](void* data, size_t count) { bytes.bytes(data, count); });
}

}  // namespace

void Commits::finish(Film& film, size_t item, std::vector<FilmTile> tiles) {
  const std::lock_guard lock(mutex_);
  film_ = &film;
  waiting_.emplace(item, std::move(tiles));
  while (!waiting_.empty()) {
    // Skip the items that a resumed render has finished before.
    while (context_.is_committed(next_)) ++next_;
    const auto first = waiting_.begin();
    if (first->first != next_) break;
    context_.add(film, next_, first->second);
    waiting_.erase(first);
    ++next_;
  }
}

void Commits::receive(Film& film, std::string_view message) {
  SharedBytes bytes(message);
  uint64_t item = 0, count = 0;
  bytes.values(item, count);
  std::vector<FilmTile> tiles;
  for (; count > 0; --count) {
    Rect pixels;
    int layer = 0;
    bytes.values(pixels, layer);
    tiles.push_back(film.make_tile(pixels, layer - film.first_layer()));
    transfer(tiles.back(), bytes);
  }
  finish(film, item, std::move(tiles));
}

std::string Commits::pack(size_t item, std::vector<FilmTile> tiles) {
  SharedBytes bytes;
  uint64_t number = item, count = tiles.size();
  bytes.values(number, count);
  for (FilmTile& tile : tiles) {
    Rect pixels = tile.pixels();
    int layer = tile.layer();
    bytes.values(pixels, layer);
    transfer(tile, bytes);
  }
  return bytes.written();
}

void Commits::save(WorkSource& source) {
  const std::lock_guard lock(mutex_);
  if (film_) source.save(*film_);
}

void Commits::commit_rest() {
  const std::lock_guard lock(mutex_);
  for (const auto& [item, tiles] : waiting_) {
    for (const FilmTile& tile : tiles) film_->commit(tile);
  }
  waiting_.clear();
}

}  // namespace kinome
