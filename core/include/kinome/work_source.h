#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>

#include "kinome/export.h"
#include "kinome/math.h"

namespace kinome {

class Film;

/// Reports which work of a render's passes is needed, and records the items that are added to the
/// film. Checkpoint (libs/session) implements it to resume earlier renders. The default functions
/// render everything and record nothing. Not thread-safe; the scheduler serialises the calls,
/// except for those of is_wanted().
class KINOME_EXPORT WorkSource {
 public:
  virtual ~WorkSource();

  /// Begins a render whose film is prepared. May fill the film with stored data.
  virtual void begin(Film& /*film*/) {}
  /// True if the film was filled with stored data.
  virtual bool resumes() const { return false; }
  /// True if some of `pixels` of a film layer need samples. Thread-safe.
  virtual bool is_wanted(const Rect& /*pixels*/, int /*layer*/) const { return true; }
  /// Begins a pass with this number of items.
  virtual void begin_pass(size_t /*items*/) {}
  /// True if an item of the pass is in the film already.
  virtual bool is_done(size_t /*item*/) const { return false; }
  /// Records that an item of the pass is in the film, with this number of commits.
  virtual void add(Film& /*film*/, size_t /*item*/, uint64_t /*commits*/) {}
  /// Returns decide(), or the stored result of the same decision.
  virtual double decide(const std::function<double()>& decide) { return decide(); }
  /// Stores the film now.
  virtual void save(Film& /*film*/) {}
  /// Stores the film a last time. Called only once.
  virtual void close(Film& /*film*/) {}
  /// Ends the storing of data, because the film contains samples that no pass accounts for.
  virtual void abandon() {}
};

}  // namespace kinome
