#pragma once

#include <cstdint>
#include <cstring>
#include <functional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace kinome {

/// Serialises values between processes. The same sequence of calls writes or reads: each call
/// appends its argument to the bytes, or replaces it by the next value in them.
class SharedBytes {
 public:
  /// Writes to an empty buffer.
  SharedBytes() = default;
  /// Reads from `bytes`, which must outlive this object.
  explicit SharedBytes(std::string_view bytes) : left_(bytes), reads_(true) {}

  bool reads() const { return reads_; }
  /// Transfers `count` bytes. Throws std::logic_error if too few are left.
  void bytes(void* data, size_t count) {
    if (!reads_) {
      written_.append(static_cast<const char*>(data), count);
      return;
    }
    if (count > left_.size()) throw std::logic_error("processes of a group differ in their data");
    if (count > 0) std::memcpy(data, left_.data(), count);
    left_.remove_prefix(count);
  }
  /// Transfers a value. T may have padding only if its bytes may be undefined.
  template <class T>
  void value(T& value) {
    static_assert(std::is_trivially_copyable_v<T> && !std::is_pointer_v<T>);
    bytes(&value, sizeof value);
  }
  template <class... T>
  void values(T&... all) {
    (value(all), ...);
  }
  template <class T>
  void items(std::span<T> all) {
    static_assert(std::is_trivially_copyable_v<T> && !std::is_pointer_v<T>);
    bytes(all.data(), all.size_bytes());
  }
  /// Transfers the size and the elements.
  template <class T>
  void vector(std::vector<T>& all) {
    resize(all);
    items(std::span<T>(all));
  }
  /// Transfers only the size.
  template <class T>
  void resize(std::vector<T>& all) {
    auto size = static_cast<uint32_t>(all.size());
    value(size);
    if (reads_) all.resize(size);
  }
  void text(std::string& text) {
    auto size = static_cast<uint32_t>(text.size());
    value(size);
    text.resize(size);
    bytes(text.data(), size);
  }
  bool at_end() const { return left_.empty(); }
  const std::string& written() const { return written_; }

 private:
  std::string written_;
  std::string_view left_;
  bool reads_ = false;
};

/// Results that the items of a Scheduler::for_each() leave in the caller's memory. In a group
/// of processes, they are transferred to all processes.
class SharedItems {
 public:
  /// Transfers the results of an item: writes them, or replaces them by those of another process.
  /// nullptr: nothing to transfer.
  using Transfer = std::function<void(size_t item, SharedBytes& bytes)>;
  explicit SharedItems(Transfer transfer) : transfer_(std::move(transfer)) {}

  const Transfer& transfer() const { return transfer_; }
  /// Rank of the process that ran each item; set at the end of the loop.
  const std::vector<int>& ranks() const { return ranks_; }
  void set_ranks(std::vector<int> ranks) { ranks_ = std::move(ranks); }
  /// Assigns each item to a rank, for items that continue with data of an earlier loop. Empty: the
  /// next free process takes it.
  void assign(std::vector<int> ranks) { assigned_ = std::move(ranks); }
  const std::vector<int>& assigned_ranks() const { return assigned_; }

 private:
  Transfer transfer_;
  std::vector<int> ranks_, assigned_;
};

}  // namespace kinome
