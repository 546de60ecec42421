#pragma once

#include <exception>
#include <list>
#include <mutex>
#include <thread>

#include <mpi.h>

#include "kinome/process_group.h"

namespace kinome {

/// The processes of MPI_COMM_WORLD. Only one thread at a time calls MPI. Threads that wait for
/// other processes sleep between polls, because there may be more processes than processors.
class MpiGroup final : public ProcessGroup {
 public:
  /// Initialises MPI for the whole program. Throws Error if this MPI doesn't support threads.
  MpiGroup();
  /// Finalises MPI if finish() was called.
  ~MpiGroup() override;
  MpiGroup(const MpiGroup&) = delete;
  MpiGroup& operator=(const MpiGroup&) = delete;

  int rank() const override { return rank_; }
  int size() const override { return size_; }
  std::string machine() const override { return machine_; }

  std::vector<std::string> gather(std::string_view own, const char* what) override;
  std::string broadcast(std::string_view bytes, const char* what) override;
  void begin_pass(Receive receive) override;
  uint64_t next() override;
  void stop() override;
  void send(std::string bytes) override;
  std::vector<std::string> end_pass(std::string_view own) override;
  std::map<std::string, GroupTraffic> traffic() const override;
  void finish() override;
  [[noreturn]] void abort(int status) override;

 private:
  /// A message that is being sent or received. It must not move until then, because MPI uses its
  /// address.
  struct Message {
    std::string bytes;
    MPI_Request request = MPI_REQUEST_NULL;
    int rank = 0;
  };
  /// Polls messages. Both functions return true if there was progress.
  bool continue_sending();
  bool continue_receiving(std::vector<Message>& arrived);
  void deliver(const Message& message);
  uint64_t take(uint64_t count);
  void count(const char* what, uint64_t messages, uint64_t bytes, double seconds);
  /// Waits until `is_done` returns true. It is called with the lock held.
  template <class Condition>
  void wait_until(const Condition& is_done) const;
  void wait(MPI_Request& request) const;
  int tag() const { return static_cast<int>(pass_ % 32768); }

  int rank_ = 0;
  int size_ = 1;
  std::string machine_;
  bool is_finished_ = false;

  mutable std::mutex mpi_;  ///< guards MPI and all members below
  MPI_Comm comm_ = MPI_COMM_NULL;
  MPI_Comm items_ = MPI_COMM_NULL;  ///< for messages to the root
  /// Counters of passes with even and odd numbers, in the root's memory.
  MPI_Win window_ = MPI_WIN_NULL;
  uint64_t* counters_ = nullptr;
  uint64_t pass_ = 0;
  uint64_t sent_ = 0;  ///< messages in this pass
  std::list<Message> sending_;
  std::list<Message> receiving_;
  bool receives_ = false;
  Receive receive_;
  std::vector<uint64_t> received_;  ///< messages from each rank in this pass
  std::exception_ptr failure_;      ///< exception that receive_ has thrown
  std::map<std::string, GroupTraffic> traffic_;

  std::jthread service_;  ///< sends and receives messages while this process renders
};

}  // namespace kinome
