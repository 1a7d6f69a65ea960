#include "acus/physics/mechanics/condensation/mapped_file.h"

#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include "acus/base/core/error.h"
#include "acus/base/core/input_file.h"

namespace acus::mechanics {
namespace {

struct Descriptor {
  explicit Descriptor(const std::filesystem::path& path)
      : number(::open(path.c_str(), O_RDONLY | O_CLOEXEC)) {}
  ~Descriptor() {
    if (number >= 0) ::close(number);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int number;
};

}  // namespace

MappedFile::MappedFile(const std::filesystem::path& path) {
  RequireInputFile(path);
  const Descriptor file(path);
  ACUS_REQUIRE(file.number >= 0, path.string(), ": cannot be opened: ", std::strerror(errno));
  struct stat about {};
  ACUS_REQUIRE(::fstat(file.number, &about) == 0 && S_ISREG(about.st_mode), path.string(),
               ": is not a file");
  ACUS_REQUIRE(about.st_size > 0, path.string(), ": is empty");
  size_ = static_cast<std::size_t>(about.st_size);
  void* at = ::mmap(nullptr, size_, PROT_READ, MAP_SHARED, file.number, 0);
  ACUS_REQUIRE(at != MAP_FAILED, path.string(), ": cannot be mapped: ", std::strerror(errno));
  data_ = static_cast<const std::byte*>(at);
}

MappedFile::~MappedFile() {
  ::munmap(const_cast<std::byte*>(data_), size_);
}

}  // namespace acus::mechanics
