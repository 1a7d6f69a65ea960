// Counts what is taken from the heap. Include in exactly one source of a test program: it replaces
// the program's operator new.
#pragma once

#include <atomic>
#include <cstdlib>
#include <new>

namespace acus::testing_support {

inline std::atomic<long> num_allocations{0};

inline void* Counted(std::size_t size, std::size_t alignment) {
  ++num_allocations;
  void* p = nullptr;
  if (alignment < sizeof(void*)) alignment = sizeof(void*);
  if (posix_memalign(&p, alignment, size == 0 ? 1 : size) != 0) throw std::bad_alloc();
  return p;
}

}  // namespace acus::testing_support

[[gnu::noinline]] void* operator new(std::size_t size) {
  return acus::testing_support::Counted(size, 16);
}
[[gnu::noinline]] void* operator new[](std::size_t size) {
  return acus::testing_support::Counted(size, 16);
}
[[gnu::noinline]] void* operator new(std::size_t size, std::align_val_t alignment) {
  return acus::testing_support::Counted(size, static_cast<std::size_t>(alignment));
}
[[gnu::noinline]] void* operator new[](std::size_t size, std::align_val_t alignment) {
  return acus::testing_support::Counted(size, static_cast<std::size_t>(alignment));
}
// The sanitizers have their own nothrow forms, which would not match the deletes below.
[[gnu::noinline]] void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  return acus::testing_support::Counted(size, 16);
}
[[gnu::noinline]] void* operator new[](std::size_t size, const std::nothrow_t&) noexcept {
  return acus::testing_support::Counted(size, 16);
}
[[gnu::noinline]] void operator delete(void* p) noexcept {
  std::free(p);
}
[[gnu::noinline]] void operator delete[](void* p) noexcept {
  std::free(p);
}
[[gnu::noinline]] void operator delete(void* p, std::size_t) noexcept {
  std::free(p);
}
[[gnu::noinline]] void operator delete[](void* p, std::size_t) noexcept {
  std::free(p);
}
[[gnu::noinline]] void operator delete(void* p, std::align_val_t) noexcept {
  std::free(p);
}
[[gnu::noinline]] void operator delete[](void* p, std::align_val_t) noexcept {
  std::free(p);
}
[[gnu::noinline]] void operator delete(void* p, std::size_t, std::align_val_t) noexcept {
  std::free(p);
}
[[gnu::noinline]] void operator delete[](void* p, std::size_t, std::align_val_t) noexcept {
  std::free(p);
}
