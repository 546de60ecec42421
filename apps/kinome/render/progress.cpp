#include "render/progress.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include <sys/ioctl.h>
#include <unistd.h>

#include <fmt/format.h>

#include "say.h"

namespace kinome::app {
namespace {

constexpr std::chrono::duration<double> kBarInterval{0.1};
constexpr std::chrono::duration<double> kFirstLineDelay{1};
constexpr std::chrono::duration<double> kMaxLineInterval{30};

/// The time left is estimated after this share of the work or these seconds. Earlier estimates may
/// be wrong by any factor.
constexpr double kMinShare = 0.01;
constexpr double kMinSeconds = 10;

std::string format_duration(double seconds) {
  const long s = std::max(1L, std::lround(seconds));
  if (s < 60) return fmt::format("{} s", s);
  if (s < 3600) return fmt::format("{} min {:02} s", s / 60, s % 60);
  return fmt::format("{} h {:02} min", s / 3600, s / 60 % 60);
}

int terminal_width() {
  winsize size{};
  return ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 ? size.ws_col : 80;
}

}  // namespace

ProgressText progress_text(double fraction, double measured, double seconds) {
  if (!(fraction < 1)) return {100, ""};
  const int percent = std::min(99, static_cast<int>(std::lround(100 * fraction)));
  const bool is_known = measured >= kMinShare || (measured > 0 && seconds >= kMinSeconds);
  if (!is_known) return {percent, ""};
  return {percent, ", " + format_duration(seconds / measured * (1 - fraction)) + " left"};
}

Progress::Progress(bool quiet) : quiet_(quiet), terminal_(isatty(STDERR_FILENO) == 1) {
  interval_ = terminal_ ? kBarInterval : kFirstLineDelay;
  begin();
}

void Progress::begin() {
  next_ = Clock::now() + std::chrono::duration_cast<Clock::duration>(interval_);
  last_fraction_ = first_fraction_ = 0;
}

void Progress::update(double fraction) {
  if (fraction < last_fraction_) begin();
  last_fraction_ = fraction;
  const Clock::time_point now = Clock::now();
  if (!(fraction > 0)) return;
  if (!(first_fraction_ > 0)) {
    first_fraction_ = fraction;
    first_ = now;
  }
  if (quiet_ || now < next_) return;
  if (!terminal_) interval_ = std::min(interval_ * 2, kMaxLineInterval);
  next_ = now + std::chrono::duration_cast<Clock::duration>(interval_);
  const double elapsed = std::chrono::duration<double>(now - first_).count();
  const ProgressText text = progress_text(fraction, fraction - first_fraction_, elapsed);
  if (terminal_) {
    draw_bar(fraction, text);
    bar_drawn_ = true;
  } else {
    say("rendering: {} % done{}\n", text.percent, text.left);
  }
}

void Progress::draw_bar(double fraction, const ProgressText& progress) const {
  const std::string text = fmt::format(" {:3} %{}", progress.percent, progress.left);
  const int width = std::clamp(terminal_width() - static_cast<int>(text.size()) - 3, 0, 60);
  const int full = static_cast<int>(fraction * width);
  // \r and "erase to the end of the line" redraw the bar on the same line.
  say("\r[{:=<{}}{:<{}}]{}\x1b[K", "", full, "", width - full, text);
  std::fflush(stderr);
}

void Progress::finish() {
  if (!bar_drawn_) return;
  say("\r\x1b[K");
  std::fflush(stderr);
  bar_drawn_ = false;
}

}  // namespace kinome::app
