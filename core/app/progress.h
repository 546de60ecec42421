#pragma once

#include <chrono>
#include <string>

namespace kinome::app {

/// The share of the work that is done in per cent, 100 only at the very end, and the time left, as
/// ", 1 min 05 s left", or "" at the end and while it is unknown.
struct ProgressText {
  int percent;
  std::string left;
};
/// `fraction` of the work is done; its last part, `measured`, took `seconds`. The time left is
/// unknown until that part is 1 % of the work or has taken 10 seconds.
ProgressText progress_text(double fraction, double measured, double seconds);

/// Tells how far a render is: a bar with the time left on a terminal, and lines in a log, more
/// seldom as time goes on.
class Progress {
 public:
  explicit Progress(bool quiet);
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  ~Progress() { finish(); }

  /// Forgets the pass before. The time before a pass's first update() is no part of the estimate:
  /// preparations do not become longer with the number of samples.
  void begin();
  /// Share of the pass that is done. A share that falls begins another pass.
  void update(double fraction);
  /// Wipes the bar.
  void finish();

 private:
  using Clock = std::chrono::steady_clock;
  void draw_bar(double fraction, const ProgressText& progress) const;

  bool quiet_;
  bool terminal_;
  bool bar_drawn_ = false;
  double last_fraction_ = 0;
  double first_fraction_ = 0;  ///< of the first update() of a pass; 0: there was none
  Clock::time_point first_;    ///< when that was
  Clock::time_point next_;
  std::chrono::duration<double> interval_;
};

}  // namespace kinome::app
