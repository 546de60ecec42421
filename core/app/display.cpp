// A picture in the making, sent to a viewer by a thread of its own.

#include "display.h"

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <charconv>
#include <chrono>
#include <condition_variable>
#include <cstring>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

#include <fcntl.h>
#include <netdb.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <fmt/format.h>

#include "kinome/error.h"
#include "kinome/log.h"
#include "tev_packets.h"

namespace kinome::app {
namespace {

using Clock = std::chrono::steady_clock;
using Seconds = std::chrono::duration<double>;

/// What is sent in one piece: side of a square of pixels; several that stand side by side go
/// together, up to so many numbers.
constexpr int kCell = 32;
constexpr size_t kMostNumbers = 1 << 18;
/// Between two whole pictures with splats.
constexpr Seconds kWholeInterval{0.5};
constexpr Seconds kConnectPatience{5};
/// Of finish(), while nothing goes through.
constexpr Seconds kLastPatience{2};
constexpr int kPollMilliseconds = 50;

/// A file descriptor, closed in the end.
class Socket {
 public:
  Socket() = default;
  explicit Socket(int descriptor) : descriptor_(descriptor) {}
  Socket(Socket&& other) noexcept : descriptor_(std::exchange(other.descriptor_, -1)) {}
  Socket& operator=(Socket&& other) noexcept {
    std::swap(descriptor_, other.descriptor_);
    return *this;
  }
  ~Socket() {
    if (descriptor_ >= 0) close(descriptor_);
  }
  int get() const { return descriptor_; }
  bool is_open() const { return descriptor_ >= 0; }

 private:
  int descriptor_ = -1;
};

bool is_ready_to_send(const Socket& socket) {
  pollfd polled{socket.get(), POLLOUT, 0};
  return poll(&polled, 1, kPollMilliseconds) > 0;
}

bool is_prefix(const std::vector<std::string>& some, const std::vector<std::string>& all) {
  return some.size() <= all.size() && std::equal(some.begin(), some.end(), all.begin());
}

}  // namespace

std::pair<std::string, std::string> split_address(const std::string& address) {
  const size_t colon = address.rfind(':');
  std::string host = address.substr(0, colon == std::string::npos ? 0 : colon);
  const std::string port = colon == std::string::npos ? "" : address.substr(colon + 1);
  if (host.size() > 2 && host.front() == '[' && host.back() == ']') {
    host = host.substr(1, host.size() - 2);
  }
  int number = 0;
  const char* const end = port.data() + port.size();
  const auto [rest, error] = std::from_chars(port.data(), end, number);
  if (host.empty() || error != std::errc{} || rest != end || number < 1 || number > 65535) {
    throw Error(fmt::format(
        "--display: expected HOST:PORT, as localhost:14158, where tev listens, got '{}'", address));
  }
  return {std::move(host), port};
}

/// What both threads know. It outlives Display where a name server keeps the thread from ending.
class Display::Sender {
 public:
  Sender(std::string address, std::string name)
      : address_(std::move(address)), name_(std::move(name)) {}

  bool is_gone() const { return is_gone_; }

  bool is_time_for_a_whole() {
    const std::lock_guard lock(mutex_);
    const Clock::time_point now = Clock::now();
    if (now < next_whole_) return false;
    next_whole_ = now + std::chrono::duration_cast<Clock::duration>(kWholeInterval);
    return true;
  }

  /// `part` of a picture of this size begins at (x, y).
  void put(const Image& part, int x, int y, int width, int height) {
    const std::lock_guard lock(mutex_);
    if (width != picture_.width || height != picture_.height ||
        !is_prefix(part.channels, picture_.channels)) {
      begin_picture(part.channels, width, height);
    }
    const size_t all = picture_.channels.size(), own = part.channels.size();
    for (int row = 0; row < part.height; ++row) {
      for (int column = 0; column < part.width; ++column) {
        const auto from = static_cast<size_t>(row) * part.width + column;
        const auto to = static_cast<size_t>(y + row) * width + (x + column);
        std::copy_n(&part.data[from * own], own, &picture_.data[to * all]);
      }
    }
    for (int j = y / kCell; j <= (y + part.height - 1) / kCell; ++j) {
      for (int i = x / kCell; i <= (x + part.width - 1) / kCell; ++i) {
        changed_[static_cast<size_t>(j) * cells_across_ + i] = true;
      }
    }
    news_.notify_all();
  }

  void run() {
    const std::string failure = send_all();
    if (!failure.empty()) {
      is_gone_ = true;
      log_warn(fmt::format("--display {}: {}; the render goes on without it", address_, failure));
    }
    const std::lock_guard lock(mutex_);
    is_done_ = true;
    news_.notify_all();
  }

  /// False: the thread is held up, and to be left alone.
  bool close() {
    std::unique_lock lock(mutex_);
    is_closing_ = true;
    news_.notify_all();
    Clock::time_point moved = Clock::now();
    uint64_t sent = sent_;
    while (!is_done_ && Clock::now() - moved < kLastPatience + Seconds(0.5)) {
      news_.wait_for(lock, Seconds(0.1));
      if (sent != sent_) moved = Clock::now();
      sent = sent_;
    }
    return is_done_;
  }

 private:
  void begin_picture(const std::vector<std::string>& channels, int width, int height) {
    picture_ = {width, height, channels, {}};
    picture_.data.assign(static_cast<size_t>(width) * height * channels.size(), 0.f);
    cells_across_ = (width + kCell - 1) / kCell;
    const int down = (height + kCell - 1) / kCell;
    changed_.assign(static_cast<size_t>(cells_across_) * down, false);
    next_cell_ = 0;
    is_new_ = true;
  }

  /// What there is to send, once there is something; none: the end.
  std::optional<tev::Packet> next_packet() {
    std::unique_lock lock(mutex_);
    std::vector<bool>::iterator found;
    news_.wait(lock, [&] {
      found = std::find(changed_.begin() + next_cell_, changed_.end(), true);
      if (found == changed_.end()) found = std::find(changed_.begin(), changed_.end(), true);
      return is_new_ || is_closing_ || found != changed_.end();
    });
    if (is_new_) {
      is_new_ = false;
      return tev::create_image(name_, picture_.width, picture_.height, picture_.channels);
    }
    if (found == changed_.end()) return std::nullopt;
    return take_cells(static_cast<int>(found - changed_.begin()));
  }

  /// Those that have changed, from this one to the right.
  tev::Packet take_cells(int first) {
    const size_t channels = picture_.channels.size();
    const int row = first / cells_across_, left = first % cells_across_;
    const size_t most = std::max<size_t>(1, kMostNumbers / (channels * kCell * kCell));
    int right = left;
    while (right < cells_across_ && changed_[static_cast<size_t>(row) * cells_across_ + right] &&
           static_cast<size_t>(right - left) < most) {
      changed_[static_cast<size_t>(row) * cells_across_ + right] = false;
      ++right;
    }
    next_cell_ = static_cast<std::ptrdiff_t>(row) * cells_across_ + right;
    const Rect pixels{left * kCell, row * kCell, std::min(right * kCell, picture_.width),
                      std::min((row + 1) * kCell, picture_.height)};
    std::vector<float> data;
    data.reserve(static_cast<size_t>(pixels.area()) * channels);
    for (int y = pixels.y0; y < pixels.y1; ++y) {
      const auto begin = (static_cast<size_t>(y) * picture_.width + pixels.x0) * channels;
      const auto count = static_cast<size_t>(pixels.width()) * channels;
      data.insert(data.end(), &picture_.data[begin], &picture_.data[begin] + count);
    }
    return tev::update_image(name_, pixels, picture_.channels, data);
  }

  /// Returns what went wrong, or "".
  std::string send_all() {
    Socket socket;
    const std::string failure = connect(socket);
    if (!failure.empty()) return failure;
    while (const auto packet = next_packet()) {
      const std::string fault = send(socket, *packet);
      if (!fault.empty()) return fault;
    }
    return "";
  }

  std::string connect(Socket& socket) const {
    const auto [host, port] = split_address(address_);
    addrinfo hints{};
    hints.ai_socktype = SOCK_STREAM;
    addrinfo* found = nullptr;
    const int error = getaddrinfo(host.c_str(), port.c_str(), &hints, &found);
    if (error != 0) return gai_strerror(error);
    const std::unique_ptr<addrinfo, decltype(&freeaddrinfo)> owner(found, &freeaddrinfo);
    std::string failure = "no such address";
    // As "localhost", a name may stand for several.
    for (const addrinfo* one = found; one; one = one->ai_next) {
      Socket made(::socket(one->ai_family, one->ai_socktype | SOCK_NONBLOCK | SOCK_CLOEXEC,
                           one->ai_protocol));
      const int code = made.is_open() ? connect(made, *one) : errno;
      if (code == 0) {
        socket = std::move(made);
        return "";
      }
      failure = std::strerror(code);
    }
    return failure;
  }

  /// An error number, or 0.
  int connect(const Socket& socket, const addrinfo& to) const {
    if (::connect(socket.get(), to.ai_addr, to.ai_addrlen) == 0) return 0;
    if (errno != EINPROGRESS) return errno;
    const Clock::time_point start = Clock::now();
    while (!is_ready_to_send(socket)) {
      const Seconds patience = is_closing_ ? kLastPatience : kConnectPatience;
      if (Clock::now() - start > patience) return ETIMEDOUT;
    }
    int error = 0;
    socklen_t size = sizeof error;
    return getsockopt(socket.get(), SOL_SOCKET, SO_ERROR, &error, &size) == 0 ? error : errno;
  }

  std::string send(const Socket& socket, const tev::Packet& packet) {
    Clock::time_point moved = Clock::now();
    for (size_t at = 0; at < packet.size();) {
      const ssize_t count =
          ::send(socket.get(), packet.data() + at, packet.size() - at, MSG_NOSIGNAL);
      if (count >= 0) {
        at += static_cast<size_t>(count);
        sent_ += static_cast<uint64_t>(count);
        moved = Clock::now();
      } else if (errno == EAGAIN || errno == EWOULDBLOCK) {
        is_ready_to_send(socket);
        // While the render goes on, a display may take its time.
        if (is_closing_ && Clock::now() - moved > kLastPatience) return "takes nothing any more";
        if (!is_closing_) moved = Clock::now();
      } else if (errno != EINTR) {
        return std::strerror(errno);
      }
    }
    return "";
  }

  const std::string address_, name_;
  std::atomic<bool> is_gone_{false}, is_closing_{false};
  std::atomic<uint64_t> sent_{0};  ///< bytes
  std::mutex mutex_;               ///< of all that follows
  std::condition_variable news_;
  Image picture_;
  int cells_across_ = 0;
  std::vector<bool> changed_;     ///< of each cell, since it was sent
  std::ptrdiff_t next_cell_ = 0;  ///< where to look first
  bool is_new_ = false;           ///< the picture, to the display
  bool is_done_ = false;
  Clock::time_point next_whole_;
};

Display::Display(const std::string& address, const std::string& name) {
  split_address(address);
  sender_ = std::make_shared<Sender>(address, name);
  thread_ = std::thread([sender = sender_] { sender->run(); });
}

Display::~Display() {
  finish();
}

void Display::show(const Film& film, const Rect& pixels) {
  if (sender_->is_gone()) return;
  const Rect& crop = film.crop();
  const bool is_whole = pixels.area() == crop.area() && pixels.area() > kCell * kCell;
  if (is_whole && !sender_->is_time_for_a_whole()) return;
  sender_->put(film.develop(pixels), pixels.x0 - crop.x0, pixels.y0 - crop.y0, crop.width(),
               crop.height());
}

void Display::show(const Image& picture) {
  if (sender_->is_gone()) return;
  sender_->put(picture, 0, 0, picture.width, picture.height);
}

void Display::finish() {
  if (!thread_.joinable()) return;
  if (sender_->close()) {
    thread_.join();
  } else {
    thread_.detach();
  }
}

}  // namespace kinome::app
