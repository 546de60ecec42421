#include "session/mpi/mpi_group.h"

#include <algorithm>
#include <chrono>
#include <cstring>
#include <limits>

#include "kinome/shared_items.h"

namespace kinome {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::microseconds;

/// Maximum bytes of all processes in one collective call, whose counts have 31 bits.
constexpr uint64_t kMaxBytes = 1 << 30;
/// Ends a pass when it is added to the counter.
constexpr uint64_t kEnd = uint64_t{1} << 40;
/// Range of the sleep between polls, which becomes longer while nothing happens.
constexpr microseconds kMinSleep{20}, kMaxSleep{1000};

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

class Sleep {
 public:
  void operator()() {
    std::this_thread::sleep_for(time_);
    time_ = std::min(2 * time_, kMaxSleep);
  }
  void shorten() { time_ = kMinSleep; }

 private:
  microseconds time_ = kMinSleep;
};

}  // namespace

MpiGroup::MpiGroup() {
  int provided = MPI_THREAD_SINGLE;
  MPI_Init_thread(nullptr, nullptr, MPI_THREAD_SERIALIZED, &provided);
  if (provided < MPI_THREAD_SERIALIZED) {
    throw Error("unsupported MPI: it was built without threads (MPI_THREAD_SERIALIZED)");
  }
  MPI_Comm_dup(MPI_COMM_WORLD, &comm_);
  MPI_Comm_dup(MPI_COMM_WORLD, &items_);
  MPI_Comm_rank(comm_, &rank_);
  MPI_Comm_size(comm_, &size_);
  char name[MPI_MAX_PROCESSOR_NAME] = {};
  int length = 0;
  MPI_Get_processor_name(name, &length);
  machine_.assign(name, static_cast<size_t>(length));
  const MPI_Aint bytes = is_root() ? 2 * sizeof(uint64_t) : 0;
  MPI_Win_allocate(bytes, sizeof(uint64_t), MPI_INFO_NULL, comm_, &counters_, &window_);
  MPI_Win_lock_all(0, window_);
  if (is_root()) {
    counters_[0] = counters_[1] = 0;
    MPI_Win_sync(window_);
  }
  MPI_Barrier(comm_);
  received_.resize(static_cast<size_t>(size_));
  service_ = std::jthread([this](const std::stop_token& stop) {
    Sleep sleep;
    std::vector<Message> arrived;
    while (!stop.stop_requested()) {
      bool is_busy = false;
      {
        const std::lock_guard lock(mpi_);
        is_busy = continue_sending();
        is_busy = continue_receiving(arrived) || is_busy;
      }
      for (const Message& message : arrived) deliver(message);
      arrived.clear();
      if (is_busy) sleep.shorten();
      sleep();
    }
  });
}

MpiGroup::~MpiGroup() {
  service_ = {};
  if (!is_finished_) return;
  MPI_Win_unlock_all(window_);
  MPI_Win_free(&window_);
  MPI_Comm_free(&items_);
  MPI_Comm_free(&comm_);
  MPI_Finalize();
}

template <class Condition>
void MpiGroup::wait_until(const Condition& is_done) const {
  Sleep sleep;
  while (true) {
    {
      const std::lock_guard lock(mpi_);
      if (is_done()) return;
    }
    sleep();
  }
}

void MpiGroup::wait(MPI_Request& request) const {
  wait_until([&] {
    int done = 0;
    MPI_Test(&request, &done, MPI_STATUS_IGNORE);
    return done != 0;
  });
}

void MpiGroup::count(const char* what, uint64_t messages, uint64_t bytes, double seconds) {
  const std::lock_guard lock(mpi_);
  GroupTraffic& traffic = traffic_[what];
  traffic.messages += messages;
  traffic.bytes += bytes;
  traffic.seconds += seconds;
}

std::map<std::string, GroupTraffic> MpiGroup::traffic() const {
  const std::lock_guard lock(mpi_);
  return traffic_;
}

std::vector<std::string> MpiGroup::gather(std::string_view own, const char* what) {
  const Clock::time_point start = Clock::now();
  const auto begin_call = [&](MPI_Request& request, const auto& call) {
    const std::lock_guard lock(mpi_);
    call(request);
  };
  const auto all = static_cast<size_t>(size_);
  const auto others = static_cast<uint64_t>(size_ - 1);
  uint64_t size = own.size();
  std::vector<uint64_t> sizes(all);
  MPI_Request request = MPI_REQUEST_NULL;
  begin_call(request, [&](MPI_Request& r) {
    MPI_Iallgather(&size, 1, MPI_UINT64_T, sizes.data(), 1, MPI_UINT64_T, comm_, &r);
  });
  wait(request);
  std::vector<std::string> gathered(all);
  // A call can transfer a limited size from each process, which requires several rounds.
  const uint64_t max_size = kMaxBytes / all;
  const uint64_t longest = *std::max_element(sizes.begin(), sizes.end());
  uint64_t rounds = 1;
  for (uint64_t begin = 0; begin < longest; begin += max_size, ++rounds) {
    std::vector<int> counts(all), offsets(all);
    int end = 0;
    for (size_t i = 0; i < all; ++i) {
      counts[i] = static_cast<int>(std::min(max_size, sizes[i] - std::min(begin, sizes[i])));
      offsets[i] = end;
      end += counts[i];
    }
    std::string bytes(static_cast<size_t>(end), '\0');
    const char* const from = own.data() + std::min<uint64_t>(begin, own.size());
    begin_call(request, [&](MPI_Request& r) {
      MPI_Iallgatherv(from, counts[rank_], MPI_BYTE, bytes.data(), counts.data(), offsets.data(),
                      MPI_BYTE, comm_, &r);
    });
    wait(request);
    for (size_t i = 0; i < all; ++i) {
      gathered[i].append(bytes, static_cast<size_t>(offsets[i]), static_cast<size_t>(counts[i]));
    }
  }
  count(what, rounds * others, (sizeof size + size) * others, seconds_since(start));
  return gathered;
}

std::string MpiGroup::broadcast(std::string_view bytes, const char* what) {
  const Clock::time_point start = Clock::now();
  // Most texts fit into the first message.
  struct {
    uint64_t size = 0;
    char first[56] = {};
  } head;
  head.size = is_root() ? bytes.size() : 0;
  if (is_root()) std::memcpy(head.first, bytes.data(), std::min(bytes.size(), sizeof head.first));
  const auto broadcast_bytes = [&](void* data, uint64_t count) {
    MPI_Request request = MPI_REQUEST_NULL;
    {
      const std::lock_guard lock(mpi_);
      MPI_Ibcast(data, static_cast<int>(count), MPI_BYTE, 0, comm_, &request);
    }
    wait(request);
  };
  broadcast_bytes(&head, sizeof head);
  std::string received(head.first, std::min<uint64_t>(head.size, sizeof head.first));
  uint64_t messages = 1;
  if (head.size > sizeof head.first) {
    received = is_root() ? std::string(bytes) : std::string(head.size, '\0');
    for (uint64_t begin = 0; begin < head.size; begin += kMaxBytes, ++messages) {
      broadcast_bytes(received.data() + begin, std::min(kMaxBytes, head.size - begin));
    }
  }
  const uint64_t others = is_root() ? static_cast<uint64_t>(size_ - 1) : 0;
  const uint64_t more = head.size > sizeof head.first ? head.size : 0;
  count(what, messages * others, (sizeof head + more) * others, seconds_since(start));
  return received;
}

void MpiGroup::begin_pass(Receive receive) {
  const std::lock_guard lock(mpi_);
  receive_ = std::move(receive);
  std::fill(received_.begin(), received_.end(), 0);
  failure_ = nullptr;
  receives_ = is_root();
  sent_ = 0;
  if (!is_root()) return;
  // Resets the counter of the next pass. No process uses it now: it was that of the previous pass,
  // and the next pass begins after end_pass().
  const uint64_t zero = 0;
  MPI_Accumulate(&zero, 1, MPI_UINT64_T, 0, static_cast<MPI_Aint>((pass_ + 1) % 2), 1, MPI_UINT64_T,
                 MPI_REPLACE, window_);
  MPI_Win_flush(0, window_);
}

uint64_t MpiGroup::take(uint64_t count) {
  const std::lock_guard lock(mpi_);
  uint64_t before = 0;
  MPI_Fetch_and_op(&count, &before, MPI_UINT64_T, 0, static_cast<MPI_Aint>(pass_ % 2), MPI_SUM,
                   window_);
  MPI_Win_flush(0, window_);
  GroupTraffic& traffic = traffic_["counter"];
  if (!is_root()) {
    ++traffic.messages;
    traffic.bytes += sizeof count;
  }
  return before;
}

uint64_t MpiGroup::next() {
  return take(1);
}

void MpiGroup::stop() {
  take(kEnd);
}

void MpiGroup::send(std::string bytes) {
  if (bytes.size() > static_cast<size_t>(std::numeric_limits<int>::max())) {
    throw Error("a tile exceeds the 2 GB that MPI can send at once: use fewer samples per pixel");
  }
  const std::lock_guard lock(mpi_);
  Message& message = sending_.emplace_back();
  message.bytes = std::move(bytes);
  MPI_Isend(message.bytes.data(), static_cast<int>(message.bytes.size()), MPI_BYTE, 0, tag(),
            items_, &message.request);
  ++sent_;
  GroupTraffic& traffic = traffic_["items"];
  ++traffic.messages;
  traffic.bytes += message.bytes.size();
}

bool MpiGroup::continue_sending() {
  const size_t before = sending_.size();
  std::erase_if(sending_, [](Message& message) {
    int done = 0;
    MPI_Test(&message.request, &done, MPI_STATUS_IGNORE);
    return done != 0;
  });
  return sending_.size() != before;
}

bool MpiGroup::continue_receiving(std::vector<Message>& arrived) {
  if (!receives_) return false;
  bool is_busy = false;
  while (true) {
    int found = 0;
    MPI_Message handle = MPI_MESSAGE_NULL;
    MPI_Status status;
    MPI_Improbe(MPI_ANY_SOURCE, tag(), items_, &found, &handle, &status);
    if (found == 0) break;
    is_busy = true;
    int size = 0;
    MPI_Get_count(&status, MPI_BYTE, &size);
    Message& message = receiving_.emplace_back();
    message.rank = status.MPI_SOURCE;
    message.bytes.resize(static_cast<size_t>(size));
    MPI_Imrecv(message.bytes.data(), size, MPI_BYTE, &handle, &message.request);
  }
  for (auto message = receiving_.begin(); message != receiving_.end();) {
    int done = 0;
    MPI_Test(&message->request, &done, MPI_STATUS_IGNORE);
    if (done == 0) {
      ++message;
      continue;
    }
    arrived.push_back(std::move(*message));
    message = receiving_.erase(message);
  }
  return is_busy || !arrived.empty();
}

/// Passes a message to the receiver, without the lock, so that other threads can call MPI
/// meanwhile.
void MpiGroup::deliver(const Message& message) {
  std::exception_ptr failure;
  try {
    receive_(message.rank, message.bytes);
  } catch (...) {
    failure = std::current_exception();
  }
  // The image is incomplete, so that all processes stop rendering.
  if (failure) stop();
  const std::lock_guard lock(mpi_);
  ++received_[static_cast<size_t>(message.rank)];
  if (!failure_) failure_ = failure;
}

std::vector<std::string> MpiGroup::end_pass(std::string_view own) {
  SharedBytes number;
  number.value(sent_);
  std::vector<std::string> gathered = gather(number.written() + std::string(own), "ends of passes");
  std::vector<uint64_t> sent;
  for (std::string& bytes : gathered) {
    uint64_t theirs = 0;
    SharedBytes(bytes).value(theirs);
    sent.push_back(theirs);
    bytes.erase(0, sizeof theirs);
  }
  const Clock::time_point start = Clock::now();
  if (is_root()) wait_until([&] { return received_ == sent; });
  count("items", 0, 0, seconds_since(start));
  const std::lock_guard lock(mpi_);
  receives_ = false;
  ++pass_;
  if (failure_) std::rethrow_exception(failure_);
  return gathered;
}

void MpiGroup::finish() {
  wait_until([&] { return sending_.empty(); });
  MPI_Request request = MPI_REQUEST_NULL;
  {
    const std::lock_guard lock(mpi_);
    MPI_Ibarrier(comm_, &request);
  }
  wait(request);
  is_finished_ = true;
}

void MpiGroup::abort(int status) {
  // The thread that has the lock may never release it.
  std::unique_lock lock(mpi_, std::defer_lock);
  for (int i = 0; i < 100 && !lock.try_lock(); ++i) std::this_thread::sleep_for(kMaxSleep);
  MPI_Abort(MPI_COMM_WORLD, status);
  std::_Exit(status);
}

}  // namespace kinome

/// Entry point of this library. Returns the group, which the caller must delete; nullptr if the
/// program has another version.
extern "C" KINOME_EXPORT kinome::ProcessGroup* kinome_join_mpi_group(const char* version) {
  return std::strcmp(version, KINOME_VERSION) == 0 ? new kinome::MpiGroup : nullptr;
}
