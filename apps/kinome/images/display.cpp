// Sends an image to a viewer during the render, from a separate thread.

#include "images/display.h"

#include <algorithm>
#include <atomic>
#include <cerrno>
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

#include "images/tev_packets.h"
#include "kinome/error.h"
#include "kinome/log.h"
#include "options/interpret_options.h"

namespace kinome::app {
namespace {

using Clock = std::chrono::steady_clock;
using Seconds = std::chrono::duration<double>;

/// Side of a square cell of pixels, the unit of sending. Adjacent cells are sent in one packet, up
/// to kMaxPacketValues.
constexpr int kCellSize = 32;
constexpr size_t kMaxPacketValues = 1 << 18;
/// Minimum time between two commits of the whole film that are sent.
constexpr Seconds kWholeFilmInterval{0.5};
constexpr Seconds kConnectTimeout{5};
/// Time that finish() waits without progress.
constexpr Seconds kFinishTimeout{2};
constexpr int kPollMilliseconds = 50;

/// Owner of a socket's file descriptor.
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
  if (host.empty() || !parse_in_range(port, 1, 65535, number).empty()) {
    throw Error(fmt::format(
        "--display: expected the viewer's HOST:PORT, such as localhost:14158, got '{}'", address));
  }
  return {std::move(host), port};
}

/// State shared by both threads. It outlives Display if a name server blocks the thread.
class Display::Sender {
 public:
  Sender(std::string address, std::string name)
      : address_(std::move(address)), name_(std::move(name)) {}

  bool is_gone() const { return is_gone_; }

  /// Returns true, at most once per interval, if the whole film should be sent.
  bool is_whole_film_due() {
    const std::lock_guard lock(mutex_);
    const Clock::time_point now = Clock::now();
    if (now < next_whole_film_) return false;
    next_whole_film_ = now + std::chrono::duration_cast<Clock::duration>(kWholeFilmInterval);
    return true;
  }

  /// Copies `part` to position (x, y) of an image of this size.
  void put(const Image& part, int x, int y, int width, int height) {
    const std::lock_guard lock(mutex_);
    if (width != image_.width || height != image_.height ||
        !is_prefix(part.channels, image_.channels)) {
      begin_image(part.channels, width, height);
    }
    const size_t all = image_.channels.size(), own = part.channels.size();
    for (int row = 0; row < part.height; ++row) {
      for (int column = 0; column < part.width; ++column) {
        const auto from = static_cast<size_t>(row) * part.width + column;
        const auto to = static_cast<size_t>(y + row) * width + (x + column);
        std::copy_n(&part.data[from * own], own, &image_.data[to * all]);
      }
    }
    for (int j = y / kCellSize; j <= (y + part.height - 1) / kCellSize; ++j) {
      for (int i = x / kCellSize; i <= (x + part.width - 1) / kCellSize; ++i) {
        changed_[static_cast<size_t>(j) * num_columns_ + i] = true;
      }
    }
    changed_state_.notify_all();
  }

  void run() {
    const std::string failure = send_all();
    if (!failure.empty()) {
      is_gone_ = true;
      log_warn(fmt::format("--display {}: {}; rendering continues without it", address_, failure));
    }
    const std::lock_guard lock(mutex_);
    is_done_ = true;
    changed_state_.notify_all();
  }

  /// Waits until all is sent. Returns false if the thread is blocked and must not be joined.
  bool close() {
    std::unique_lock lock(mutex_);
    is_closing_ = true;
    changed_state_.notify_all();
    Clock::time_point last_progress = Clock::now();
    uint64_t sent = sent_;
    while (!is_done_ && Clock::now() - last_progress < kFinishTimeout + Seconds(0.5)) {
      changed_state_.wait_for(lock, Seconds(0.1));
      if (sent != sent_) last_progress = Clock::now();
      sent = sent_;
    }
    return is_done_;
  }

 private:
  void begin_image(const std::vector<std::string>& channels, int width, int height) {
    image_ = {width, height, channels, {}};
    image_.data.assign(static_cast<size_t>(width) * height * channels.size(), 0.f);
    num_columns_ = (width + kCellSize - 1) / kCellSize;
    const int num_rows = (height + kCellSize - 1) / kCellSize;
    changed_.assign(static_cast<size_t>(num_columns_) * num_rows, false);
    next_cell_ = 0;
    is_new_ = true;
  }

  /// Waits for the next packet to send. Returns nullopt once all is sent and no more will come.
  std::optional<Packet> next_packet() {
    std::unique_lock lock(mutex_);
    std::vector<bool>::iterator found;
    changed_state_.wait(lock, [&] {
      found = std::find(changed_.begin() + next_cell_, changed_.end(), true);
      if (found == changed_.end()) found = std::find(changed_.begin(), changed_.end(), true);
      return is_new_ || is_closing_ || found != changed_.end();
    });
    if (is_new_) {
      is_new_ = false;
      return create_image(name_, image_.width, image_.height, image_.channels);
    }
    if (found == changed_.end()) return std::nullopt;
    return take_cells(static_cast<int>(found - changed_.begin()));
  }

  /// Packs the changed cell `first` and the changed cells adjacent on its right.
  Packet take_cells(int first) {
    const size_t channels = image_.channels.size();
    const int row = first / num_columns_, left = first % num_columns_;
    const size_t max_cells =
        std::max<size_t>(1, kMaxPacketValues / (channels * kCellSize * kCellSize));
    int right = left;
    while (right < num_columns_ && changed_[static_cast<size_t>(row) * num_columns_ + right] &&
           static_cast<size_t>(right - left) < max_cells) {
      changed_[static_cast<size_t>(row) * num_columns_ + right] = false;
      ++right;
    }
    next_cell_ = static_cast<std::ptrdiff_t>(row) * num_columns_ + right;
    const Rect pixels{left * kCellSize, row * kCellSize, std::min(right * kCellSize, image_.width),
                      std::min((row + 1) * kCellSize, image_.height)};
    std::vector<float> data;
    data.reserve(static_cast<size_t>(pixels.area()) * channels);
    for (int y = pixels.y0; y < pixels.y1; ++y) {
      const auto begin = (static_cast<size_t>(y) * image_.width + pixels.x0) * channels;
      const auto count = static_cast<size_t>(pixels.width()) * channels;
      data.insert(data.end(), &image_.data[begin], &image_.data[begin] + count);
    }
    return update_image(name_, pixels, image_.channels, data);
  }

  /// Sends packets until close(). Returns an error message, or "".
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
    // A name such as "localhost" may have several addresses.
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

  /// Returns an error number, or 0.
  int connect(const Socket& socket, const addrinfo& to) const {
    if (::connect(socket.get(), to.ai_addr, to.ai_addrlen) == 0) return 0;
    if (errno != EINPROGRESS) return errno;
    const Clock::time_point start = Clock::now();
    while (!is_ready_to_send(socket)) {
      const Seconds timeout = is_closing_ ? kFinishTimeout : kConnectTimeout;
      if (Clock::now() - start > timeout) return ETIMEDOUT;
    }
    int error = 0;
    socklen_t size = sizeof error;
    return getsockopt(socket.get(), SOL_SOCKET, SO_ERROR, &error, &size) == 0 ? error : errno;
  }

  std::string send(const Socket& socket, const Packet& packet) {
    Clock::time_point last_progress = Clock::now();
    for (size_t at = 0; at < packet.size();) {
      const ssize_t count =
          ::send(socket.get(), packet.data() + at, packet.size() - at, MSG_NOSIGNAL);
      if (count >= 0) {
        at += static_cast<size_t>(count);
        sent_ += static_cast<uint64_t>(count);
        last_progress = Clock::now();
      } else if (errno == EAGAIN || errno == EWOULDBLOCK) {
        is_ready_to_send(socket);
        // There is no timeout until the render ends.
        if (is_closing_ && Clock::now() - last_progress > kFinishTimeout) {
          return "no longer accepts data";
        }
        if (!is_closing_) last_progress = Clock::now();
      } else if (errno != EINTR) {
        return std::strerror(errno);
      }
    }
    return "";
  }

  const std::string address_, name_;
  std::atomic<bool> is_gone_{false}, is_closing_{false};
  std::atomic<uint64_t> sent_{0};  ///< bytes
  std::mutex mutex_;               ///< guards all members below
  std::condition_variable changed_state_;
  Image image_;
  int num_columns_ = 0;           ///< of cells
  std::vector<bool> changed_;     ///< for each cell, whether it changed since it was sent
  std::ptrdiff_t next_cell_ = 0;  ///< where the search for changed cells begins
  bool is_new_ = false;           ///< whether the viewer doesn't have the image yet
  bool is_done_ = false;
  Clock::time_point next_whole_film_;
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
  const bool is_whole = pixels.area() == crop.area() && pixels.area() > kCellSize * kCellSize;
  if (is_whole && !sender_->is_whole_film_due()) return;
  sender_->put(film.develop(pixels), pixels.x0 - crop.x0, pixels.y0 - crop.y0, crop.width(),
               crop.height());
}

void Display::show(const Image& image) {
  if (sender_->is_gone()) return;
  sender_->put(image, 0, 0, image.width, image.height);
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
