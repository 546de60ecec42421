#pragma once

#include <cstdlib>
#include <memory>
#include <new>
#include <type_traits>

namespace kinome {

/// A fixed number of zeros. Of a large array, what nobody has written takes addresses, but no
/// memory: the system gives pages of zeros when they are touched.
template <class T>
class ZeroedArray {
  static_assert(std::is_arithmetic_v<T>);

 public:
  ZeroedArray() = default;
  /// Throws std::bad_alloc.
  explicit ZeroedArray(size_t size)
      : data_(static_cast<T*>(std::calloc(size, sizeof(T)))), size_(size) {
    if (!data_ && size > 0) throw std::bad_alloc();
  }

  bool empty() const { return size_ == 0; }
  size_t size() const { return size_; }
  T* data() { return data_.get(); }
  T& operator[](size_t i) { return data_.get()[i]; }
  const T& operator[](size_t i) const { return data_.get()[i]; }

 private:
  struct Free {
    void operator()(T* memory) const { std::free(memory); }
  };
  std::unique_ptr<T, Free> data_;
  size_t size_ = 0;
};

}  // namespace kinome
