#pragma once

#include <chrono>
#include <string>

namespace kinome::app {

/// What is said where `fraction` of the work took `seconds`: the share in per cent, 100 at the very
/// end alone, and ", 1 min 05 s left", or "" there.
struct ProgressText {
  int percent;
  std::string left;
};
ProgressText progress_text(double fraction, double seconds);

/// Tells how far a render is: a bar with the time left on a terminal, and lines in a log, more
/// seldom as time goes on.
class Progress {
 public:
  explicit Progress(bool quiet);
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  ~Progress() { finish(); }

  /// Starts the clock (anew): what came before the render, or before a further pass of it, says
  /// nothing about the time left.
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
  Clock::time_point start_;
  Clock::time_point next_;
  std::chrono::duration<double> interval_;
};

}  // namespace kinome::app
