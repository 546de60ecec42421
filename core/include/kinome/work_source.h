#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>

#include "kinome/export.h"

namespace kinome {

class Film;

/// Reports which items of a render's passes are in the film already, and records the items that are
/// added. Checkpoint (libs/session) resumes earlier renders by it. Without one, all items
/// are rendered. Not thread-safe; the render context serialises the calls.
class KINOME_EXPORT WorkSource {
 public:
  virtual ~WorkSource();

  /// Begins a render whose film is prepared. May fill the film with stored data.
  virtual void begin(Film& film) = 0;
  /// True if the film was filled with stored data.
  virtual bool resumes() const = 0;
  /// Begins a pass with this number of items.
  virtual void begin_pass(size_t items) = 0;
  /// True if an item of the pass is in the film already.
  virtual bool is_done(size_t item) const = 0;
  /// Records that an item of the pass is in the film, with this number of commits.
  virtual void add(Film& film, size_t item, uint64_t commits) = 0;
  /// Returns decide(), or the stored result of the same decision.
  virtual double decide(const std::function<double()>& decide) = 0;
  /// Stores the film now.
  virtual void save(Film& film) = 0;
  /// Stores the film a last time. Called only once.
  virtual void close(Film& film) = 0;
  /// Stores nothing more, because the film contains samples that no pass accounts for.
  virtual void abandon() = 0;
};

}  // namespace kinome
