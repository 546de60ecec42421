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

/// Bytes of one process that become the same values in another. The same calls write and read:
/// each hands on what it is given, or replaces that.
class SharedBytes {
 public:
  /// Writes.
  SharedBytes() = default;
  /// Reads.
  explicit SharedBytes(std::string_view bytes) : left_(bytes), reads_(true) {}

  bool reads() const { return reads_; }
  void bytes(void* data, size_t count) {
    if (!reads_) {
      written_.append(static_cast<const char*>(data), count);
      return;
    }
    if (count > left_.size()) throw std::logic_error("processes of a group differ in their data");
    if (count > 0) std::memcpy(data, left_.data(), count);
    left_.remove_prefix(count);
  }
  /// Without padding whose bytes would be anything, or where these don't matter.
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
  /// With its size.
  template <class T>
  void vector(std::vector<T>& all) {
    resize(all);
    items(std::span<T>(all));
  }
  /// The size alone.
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

/// What the items of a RenderContext::for_each leave in the caller's own memory, for a group of
/// processes, all of which have it in the end.
class SharedItems {
 public:
  /// `transfer` hands all that is left of an item to the bytes, or replaces it by what another
  /// process has made. Nothing is to be transferred where it is nullptr.
  using Transfer = std::function<void(size_t item, SharedBytes& bytes)>;
  explicit SharedItems(Transfer transfer) : transfer_(std::move(transfer)) {}

  const Transfer& transfer() const { return transfer_; }
  /// Ranks that have made the items, once they are made.
  const std::vector<int>& makers() const { return makers_; }
  void set_makers(std::vector<int> makers) { makers_ = std::move(makers); }
  /// Who is to make which item, where these go on with what they have kept to themselves; empty:
  /// whoever comes first.
  void stay_with(std::vector<int> makers) { stay_ = std::move(makers); }
  const std::vector<int>& stay() const { return stay_; }

 private:
  Transfer transfer_;
  std::vector<int> makers_, stay_;
};

}  // namespace kinome
