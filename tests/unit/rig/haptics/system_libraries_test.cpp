#include "acus/base/core/system_libraries.h"

#include <cstdint>
#include <dlfcn.h>
#include <gmock/gmock.h>
#include <link.h>

#include "acus/base/core/error.h"

namespace acus {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::ThrowsMessage;

void Append(std::string& bytes, std::uint32_t number) {
  bytes.append(reinterpret_cast<const char*>(&number), sizeof number);
}

/// A cache of two libraries `a.so` and one `b.so`, as ldconfig writes it.
std::string Cache() {
  const std::string texts("a.so\0/1/a.so\0/2/a.so\0b.so\0/1/b.so\0", 34);
  const std::uint32_t start = 48 + 3 * 24;
  std::string cache = "glibc-ld.so.cache1.1";
  Append(cache, 3);
  Append(cache, static_cast<std::uint32_t>(texts.size()));
  cache.resize(48, '\0');
  const std::uint32_t rows[][2] = {{0, 5}, {21, 26}, {0, 13}};
  for (const auto& row : rows) {
    Append(cache, 0x0303);
    Append(cache, start + row[0]);
    Append(cache, start + row[1]);
    cache.append(12, '\0');
  }
  return cache + texts;
}

TEST(LoaderCache, GivesThePathsOfAName) {
  EXPECT_THAT(PathsInCache(Cache(), "a.so"), ElementsAre("/1/a.so", "/2/a.so"));
  EXPECT_THAT(PathsInCache(Cache(), "b.so"), ElementsAre("/1/b.so"));
  EXPECT_THAT(PathsInCache(Cache(), "c.so"), IsEmpty());
}

TEST(LoaderCache, DamagedIsReadWithinItsBounds) {
  const std::string whole = Cache();
  for (std::size_t size = 0; size < whole.size(); ++size) {
    // A copy of just this size, so that what lies behind it is not ours.
    const std::vector<char> part(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size));
    const auto paths = PathsInCache({part.data(), part.size()}, "b.so");
    EXPECT_THAT(paths, IsEmpty()) << size;
  }
  std::string damaged = whole;
  damaged.replace(20, 4, "\xFF\xFF\xFF\x7F");
  EXPECT_THAT(PathsInCache(damaged, "b.so"), IsEmpty());
}

TEST(LoaderSearch, MayNotLeadToTheWorkingDirectory) {
  EXPECT_NO_THROW(CheckSearch({}));
  EXPECT_NO_THROW(CheckSearch({"/opt/vendor/lib", "/usr/lib"}));
  for (const char* entry : {"", ".", "lib", "../lib"}) {
    EXPECT_THAT(
        [&] {
          CheckSearch({"/opt/vendor/lib", entry, "/usr/lib"});
        },
        ThrowsMessage<InputError>(AllOf(HasSubstr("LD_LIBRARY_PATH"),
                                        HasSubstr(Message("its entry '", entry, "'")),
                                        HasSubstr("absolute paths only"))))
        << entry;
  }
}

TEST(LoaderSearch, FindsWhatTheLoaderLoads) {
  for (const char* name : {"libm.so.6", "libstdc++.so.6", "libc.so.6"}) {
    void* library = dlopen(name, RTLD_LAZY);
    ASSERT_NE(library, nullptr) << name;
    link_map* map = nullptr;
    ASSERT_EQ(dlinfo(library, RTLD_DI_LINKMAP, &map), 0);
    const fs::path found = FindSystemLibrary(name);
    ASSERT_FALSE(found.empty()) << name;
    EXPECT_EQ(fs::canonical(found), fs::canonical(map->l_name)) << name;
  }
  EXPECT_TRUE(FindSystemLibrary("libthere_is_none.so").empty());
}

}  // namespace
}  // namespace acus
