#pragma once

#include <barrier>
#include <cstdlib>
#include <functional>
#include <map>
#include <mutex>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "kinome/process_group.h"

namespace kinome::test {

/// A process group whose processes are threads of this one. Tests use it to test cooperation
/// between processes without MPI.
class ThreadGroups {
 public:
  /// Calls work(group) in `size` threads, each with a group of its own rank. Any exception that
  /// leaves work() ends the test program.
  static void run(int size, const std::function<void(ProcessGroup&)>& work) {
    Shared shared(size);
    std::vector<std::jthread> threads;
    for (int rank = 0; rank < size; ++rank) {
      threads.emplace_back([&shared, &work, rank] {
        Group group(shared, rank);
        work(group);
      });
    }
  }

 private:
  struct Shared {
    explicit Shared(int processes)
        : barrier(processes), gathered(static_cast<size_t>(processes)), size(processes) {}
    std::barrier<> barrier;
    std::vector<std::string> gathered;
    const int size;
    std::mutex mutex;
    uint64_t counters[2] = {0, 0};
    ProcessGroup::Receive receive;
  };
  class Group final : public ProcessGroup {
   public:
    Group(Shared& shared, int rank) : shared_(shared), rank_(rank) {}
    int rank() const override { return rank_; }
    int size() const override { return shared_.size; }
    std::string machine() const override { return "here"; }

    std::vector<std::string> gather(std::string_view own, const char* what) override {
      shared_.gathered[static_cast<size_t>(rank_)] = own;
      shared_.barrier.arrive_and_wait();
      const std::vector<std::string> gathered = shared_.gathered;
      shared_.barrier.arrive_and_wait();
      const std::lock_guard lock(mutex_);
      ++traffic_[what].messages;
      return gathered;
    }
    std::string broadcast(std::string_view bytes, const char* what) override {
      return gather(is_root() ? bytes : std::string_view(), what)[0];
    }
    void begin_pass(Receive receive) override {
      ++pass_;
      if (is_root()) {
        shared_.counters[pass_ % 2] = 0;
        shared_.receive = std::move(receive);
      }
      shared_.barrier.arrive_and_wait();
    }
    uint64_t next() override { return take(1); }
    void stop() override { take(uint64_t{1} << 40); }
    void send(std::string bytes) override {
      const std::lock_guard lock(shared_.mutex);
      shared_.receive(rank_, bytes);
    }
    std::vector<std::string> end_pass(std::string_view own) override { return gather(own, "ends"); }
    std::map<std::string, GroupTraffic> traffic() const override {
      const std::lock_guard lock(mutex_);
      return traffic_;
    }
    void finish() override {}
    [[noreturn]] void abort(int status) override { std::_Exit(status); }

   private:
    uint64_t take(uint64_t count) {
      const std::lock_guard lock(shared_.mutex);
      const uint64_t before = shared_.counters[pass_ % 2];
      shared_.counters[pass_ % 2] += count;
      return before;
    }
    Shared& shared_;
    const int rank_;
    uint64_t pass_ = 0;
    mutable std::mutex mutex_;
    std::map<std::string, GroupTraffic> traffic_;
  };
};

}  // namespace kinome::test
