// Preloaded into a program: counts calls of the system, and makes one of them fail.
//
//   ACUS_CALLS=FILE     the file holds, afterwards, "name count" of each kind of call
//   ACUS_FAIL=NAME:N    the N-th call of NAME (from 1) fails, as it does when the system refuses it
//
// Kinds: open (for writing), write, fsync, rename, mkdir, mmap, socket, dlopen, memory (at least 1
// MB).
#include <atomic>
#include <cerrno>
#include <cstdarg>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <dlfcn.h>
#include <fcntl.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <unistd.h>

namespace {

enum Kind { kOpen, kWrite, kFsync, kRename, kMkdir, kMmap, kSocket, kDlopen, kMemory, kNumKinds };
constexpr const char* kNames[kNumKinds] = {"open", "write",  "fsync",  "rename", "mkdir",
                                           "mmap", "socket", "dlopen", "memory"};
constexpr std::size_t kLargeBytes = 1U << 20U;

/// Shared with the file, so that a program that ends at once has counted, too.
struct Counts {
  std::atomic<std::uint64_t> calls[kNumKinds];
};

struct State {
  Counts* counts = nullptr;
  int failing = -1;
  std::uint64_t number = 0;
};

State MakeState() {
  State state;
  static Counts local;
  state.counts = &local;
  if (const char* file = std::getenv("ACUS_CALLS")) {
    const int handle =
        static_cast<int>(::syscall(SYS_openat, AT_FDCWD, file, O_RDWR | O_CREAT, 0600));
    if (handle >= 0 && ::ftruncate(handle, sizeof(Counts)) == 0) {
      void* place = reinterpret_cast<void*>(::syscall(
          SYS_mmap, nullptr, sizeof(Counts), PROT_READ | PROT_WRITE, MAP_SHARED, handle, 0));
      if (place != MAP_FAILED) state.counts = static_cast<Counts*>(place);
    }
  }
  if (const char* fail = std::getenv("ACUS_FAIL")) {
    for (int kind = 0; kind < kNumKinds; ++kind) {
      const std::size_t length = std::strlen(kNames[kind]);
      if (std::strncmp(fail, kNames[kind], length) != 0 || fail[length] != ':') continue;
      state.failing = kind;
      state.number = std::strtoull(fail + length + 1, nullptr, 10);
    }
  }
  return state;
}

/// Counts a call. @returns whether it is the one that fails.
bool Fails(Kind kind) {
  static State state = MakeState();
  const std::uint64_t number = state.counts->calls[kind].fetch_add(1) + 1;
  return kind == state.failing && number == state.number;
}

template <typename Function>
Function* Real(const char* name) {
  return reinterpret_cast<Function*>(::dlsym(RTLD_NEXT, name));
}

int Refused(int error) {
  errno = error;
  return -1;
}

bool IsForWriting(int flags) {
  return (flags & O_ACCMODE) != O_RDONLY;
}

/// Terminals and /dev are not where outputs go.
bool IsOutput(const char* path) {
  return std::strncmp(path, "/dev/", 5) != 0;
}

}  // namespace

extern "C" {

int open(const char* path, int flags, ...) {
  va_list rest;
  va_start(rest, flags);
  const mode_t mode = va_arg(rest, mode_t);
  va_end(rest);
  if (IsForWriting(flags) && IsOutput(path) && Fails(kOpen)) return Refused(EACCES);
  return static_cast<int>(::syscall(SYS_openat, AT_FDCWD, path, flags, mode));
}

int open64(const char* path, int flags, ...) {
  va_list rest;
  va_start(rest, flags);
  const mode_t mode = va_arg(rest, mode_t);
  va_end(rest);
  return open(path, flags, mode);
}

FILE* fopen(const char* path, const char* mode) {
  static auto* real = Real<FILE*(const char*, const char*)>("fopen");
  if (mode[0] != 'r' && IsOutput(path) && Fails(kOpen)) {
    errno = EACCES;
    return nullptr;
  }
  return real(path, mode);
}

FILE* fopen64(const char* path, const char* mode) {
  return fopen(path, mode);
}

ssize_t write(int file, const void* bytes, size_t size) {
  if (file > 2 && Fails(kWrite)) return Refused(ENOSPC);
  return ::syscall(SYS_write, file, bytes, size);
}

ssize_t writev(int file, const iovec* parts, int count) {
  if (file > 2 && Fails(kWrite)) return Refused(ENOSPC);
  return ::syscall(SYS_writev, file, parts, count);
}

ssize_t pwrite64(int file, const void* bytes, size_t size, off64_t offset) {
  if (Fails(kWrite)) return Refused(ENOSPC);
  return ::syscall(SYS_pwrite64, file, bytes, size, offset);
}

int fsync(int file) {
  return Fails(kFsync) ? Refused(EIO) : static_cast<int>(::syscall(SYS_fsync, file));
}

int rename(const char* from, const char* to) {
  if (Fails(kRename)) return Refused(EIO);
  return static_cast<int>(::syscall(SYS_renameat2, AT_FDCWD, from, AT_FDCWD, to, 0));
}

int renameat2(int from_folder, const char* from, int to_folder, const char* to,
              unsigned flags) noexcept {
  if (Fails(kRename)) return Refused(EIO);
  return static_cast<int>(::syscall(SYS_renameat2, from_folder, from, to_folder, to, flags));
}

int mkdir(const char* path, mode_t mode) noexcept {
  if (Fails(kMkdir)) return Refused(ENOSPC);
  return static_cast<int>(::syscall(SYS_mkdirat, AT_FDCWD, path, mode));
}

void* mmap(void* address, size_t size, int protection, int flags, int file, off_t offset) noexcept {
  if (file >= 0 && Fails(kMmap)) {
    errno = ENOMEM;
    return MAP_FAILED;
  }
  return reinterpret_cast<void*>(
      ::syscall(SYS_mmap, address, size, protection, flags, file, offset));
}

void* mmap64(void* address, size_t size, int protection, int flags, int file,
             off64_t offset) noexcept {
  return mmap(address, size, protection, flags, file, offset);
}

int socket(int domain, int type, int protocol) noexcept {
  if (Fails(kSocket)) return Refused(EMFILE);
  return static_cast<int>(::syscall(SYS_socket, domain, type, protocol));
}

void* dlopen(const char* name, int flags) noexcept {
  static auto* real = Real<void*(const char*, int)>("dlopen");
  return Fails(kDlopen) ? nullptr : real(name, flags);
}

void* __libc_malloc(size_t size);
void* __libc_calloc(size_t count, size_t size);
void* __libc_realloc(void* memory, size_t size);
void* __libc_memalign(size_t alignment, size_t size);

void* malloc(size_t size) {
  if (size >= kLargeBytes && Fails(kMemory)) {
    errno = ENOMEM;
    return nullptr;
  }
  return __libc_malloc(size);
}

void* calloc(size_t count, size_t size) {
  if (count * size >= kLargeBytes && Fails(kMemory)) {
    errno = ENOMEM;
    return nullptr;
  }
  return __libc_calloc(count, size);
}

void* realloc(void* memory, size_t size) {
  if (size >= kLargeBytes && Fails(kMemory)) {
    errno = ENOMEM;
    return nullptr;
  }
  return __libc_realloc(memory, size);
}

int posix_memalign(void** place, size_t alignment, size_t size) {
  if (size >= kLargeBytes && Fails(kMemory)) return ENOMEM;
  *place = __libc_memalign(alignment, size);
  return *place == nullptr ? ENOMEM : 0;
}

void* aligned_alloc(size_t alignment, size_t size) {
  if (size >= kLargeBytes && Fails(kMemory)) {
    errno = ENOMEM;
    return nullptr;
  }
  return __libc_memalign(alignment, size);
}

}  // extern "C"
