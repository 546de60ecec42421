#include "options/line_width.h"

#include <cstdlib>

#include <sys/ioctl.h>
#include <unistd.h>

#include "options/interpret_options.h"

namespace kinome::app {

size_t line_width() {
  if (const char* const columns = std::getenv("COLUMNS")) {
    size_t width = 0;
    if (parse_in_range(columns, size_t{1}, SIZE_MAX, width).empty()) return width;
  }
  winsize size{};
  const bool is_terminal = isatty(STDOUT_FILENO) && ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0;
  return is_terminal ? size.ws_col : 0;
}

std::string wrapped(const std::string& text, size_t width) {
  if (width == 0) return text;
  std::string lines;
  size_t length = 0;  // of the last line
  for (size_t begin = 0; begin < text.size();) {
    const size_t end = std::min(text.find(' ', begin), text.size());
    if (length > 0) {
      const bool fits = length + 1 + end - begin <= width;
      lines += fits ? ' ' : '\n';
      length = fits ? length + 1 : 0;
    }
    lines.append(text, begin, end - begin);
    length += end - begin;
    begin = end + 1;
  }
  return lines;
}

}  // namespace kinome::app
