#include <cstdint>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <limits>
#include <new>
#include <sstream>
#include <string>
#include <vector>

namespace acus {
namespace {

/// Whether the kernel was asked for large pages where `address` lies.
bool IsOnLargePages(const void* address) {
  const auto at = reinterpret_cast<std::uintptr_t>(address);
  std::ifstream maps("/proc/self/smaps");
  bool inside = false;
  for (std::string line; std::getline(maps, line);) {
    std::uintptr_t begin = 0, end = 0;
    char dash = 0;
    std::istringstream range(line);
    if (range >> std::hex >> begin >> dash >> end && dash == '-') inside = begin <= at && at < end;
    if (inside && line.starts_with("VmFlags:")) return (line + " ").find(" hg ") != line.npos;
  }
  ADD_FAILURE() << "no mapping has the address";
  return false;
}

TEST(LargeArrays, LieOnLargePages) {
  if (!std::filesystem::exists("/sys/kernel/mm/transparent_hugepage")) {
    GTEST_SKIP() << "this kernel has no large pages";
  }
  std::vector<float> large(std::size_t{16} << 20);
  EXPECT_TRUE(IsOnLargePages(&large[large.size() / 2]));
}

TEST(LargeArrays, SmallOnesDoNot) {
  std::vector<float> small(std::size_t{64} << 10);
  EXPECT_FALSE(IsOnLargePages(&small[small.size() / 2]));
}

TEST(LargeArrays, MemoryThatIsNotThereIsRefused) {
  std::size_t size = std::numeric_limits<std::size_t>::max() / 2;
  EXPECT_THROW(::operator delete(::operator new(size)), std::bad_alloc);
}

int num_calls = 0;

TEST(LargeArrays, TheHandlerIsAskedFirst) {
  num_calls = 0;
  const auto old = std::set_new_handler([] {
    if (++num_calls == 2) std::set_new_handler(nullptr);
  });
  std::size_t size = std::numeric_limits<std::size_t>::max() / 2;
  EXPECT_THROW(::operator delete(::operator new(size)), std::bad_alloc);
  std::set_new_handler(old);
  EXPECT_EQ(num_calls, 2);
}

}  // namespace
}  // namespace acus
