#include "render/commits.h"

#include "image/film_pixels.h"
#include "kinome/shared_items.h"
#include "kinome/work_source.h"

namespace kinome {
namespace {

void transfer(FilmTile& tile, SharedBytes& bytes) {
  tile.transfer([&](void* data, size_t count) { bytes.bytes(data, count); });
}

}  // namespace

bool Commits::is_done(size_t item) const {
  return (item < left_out_.size() && left_out_[item]) || (source_ && source_->is_done(item));
}

void Commits::add(Film& film, size_t item, const std::vector<FilmTile>& tiles) const {
  for (const FilmTile& tile : tiles) film.commit(tile);
  if (on_commit_) {
    for (const FilmTile& tile : tiles) {
      const Rect& crop = film.crop();
      const Rect pixels = tile.has_splats() ? crop : intersection(tile.pixels(), crop);
      if (pixels.area() > 0) on_commit_(film, pixels);
    }
  }
  if (source_) source_->add(film, item, tiles.size());
}

void Commits::finish(Film& film, size_t item, std::vector<FilmTile> tiles) {
  const std::lock_guard lock(mutex_);
  film_ = &film;
  waiting_.emplace(item, std::move(tiles));
  while (!waiting_.empty()) {
    // Skip the items that a resumed render has finished before.
    while (is_done(next_)) ++next_;
    const auto first = waiting_.begin();
    if (first->first != next_) break;
    add(film, next_, first->second);
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

void Commits::save() {
  const std::lock_guard lock(mutex_);
  if (film_ && source_) source_->save(*film_);
}

void Commits::commit_rest() {
  const std::lock_guard lock(mutex_);
  for (const auto& [item, tiles] : waiting_) {
    for (const FilmTile& tile : tiles) film_->commit(tile);
  }
  waiting_.clear();
}

}  // namespace kinome
