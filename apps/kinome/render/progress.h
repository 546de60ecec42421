#pragma once

#include <chrono>
#include <string>

namespace kinome::app {

/// Progress of a render, formatted.
struct ProgressText {
  int percent;       ///< finished share of the work; 100 only at the very end
  std::string left;  ///< time left, such as ", 1 min 05 s left"; "" at the end and while unknown
};
/// Formats the progress if `fraction` of the work is finished, of which the last part, `measured`,
/// took `seconds`. The time left is unknown until that part is 1 % of the work or has taken 10
/// seconds.
ProgressText progress_text(double fraction, double measured, double seconds);

/// Reports the progress of a render on stderr: as a bar on a terminal, otherwise as lines at
/// increasing intervals.
class Progress {
 public:
  explicit Progress(bool quiet);
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  ~Progress() { finish(); }

  /// Starts a pass. The time before its first update() is left out of the estimate, because
  /// preparations don't depend on the number of samples.
  void begin();
  /// Reports that `fraction` of the pass is finished. A smaller fraction than before starts a new
  /// pass.
  void update(double fraction);
  /// Erases the bar.
  void finish();

 private:
  using Clock = std::chrono::steady_clock;
  void draw_bar(double fraction, const ProgressText& progress) const;

  bool quiet_;
  bool terminal_;
  bool bar_drawn_ = false;
  double last_fraction_ = 0;
  double first_fraction_ = 0;  ///< fraction at the first update() of a pass; 0 before that
  Clock::time_point first_;    ///< time of the first update() of a pass
  Clock::time_point next_;     ///< time of the next report
  std::chrono::duration<double> interval_;
};

}  // namespace kinome::app
