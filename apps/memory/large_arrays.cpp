// Arrays of volumes on large pages: this operator new takes the place of the standard one in the
// programs. The kernel fills 512 pages of 4 kB as slowly as many large ones, and a CT of 200 MB
// goes through dozens of arrays of that size. What is smaller, or has an alignment of its own,
// comes as from the standard one. docs/library.md says so to users of the library, which does not
// contain it.
#include <cstdint>
#include <cstdlib>
#include <new>
#include <sys/mman.h>

namespace {

constexpr std::uintptr_t kLargePage = std::uintptr_t{1} << 21;

/// Only the pages that lie wholly inside. Where large pages are not to be had, it is slower.
void AskForLargePages(const void* memory, std::size_t size) noexcept {
  const auto begin = reinterpret_cast<std::uintptr_t>(memory);
  const std::uintptr_t first = (begin + kLargePage - 1) / kLargePage * kLargePage;
  const std::uintptr_t end = (begin + size) / kLargePage * kLargePage;
  if (end > first) ::madvise(reinterpret_cast<void*>(first), end - first, MADV_HUGEPAGE);
}

}  // namespace

void* operator new(std::size_t size) {
  for (;;) {
    if (void* const memory = std::malloc(size == 0 ? 1 : size)) {
      if (size >= 2 * kLargePage) AskForLargePages(memory, size);
      return memory;
    }
    const std::new_handler handler = std::get_new_handler();
    if (handler == nullptr) throw std::bad_alloc();
    handler();
  }
}
