#include "acus/base/core/child_process.h"

#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <fcntl.h>
#include <fstream>
#include <new>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "acus/base/core/error.h"

namespace acus::core {
namespace {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kIsSanitized = true;  // Shadow memory needs terabytes of address space.
#else
constexpr bool kIsSanitized = false;
#endif

void LimitMemory(double extra_bytes) {
  if (kIsSanitized) return;
  double pages = 0.0;
  std::ifstream("/proc/self/statm") >> pages;
  const auto limit =
      static_cast<rlim_t>(pages * static_cast<double>(::sysconf(_SC_PAGESIZE)) + extra_bytes);
  const rlimit memory{limit, limit};
  ::setrlimit(RLIMIT_AS, &memory);
}

void WriteAll(int file, const std::string& bytes) {
  for (std::size_t done = 0; done < bytes.size();) {
    const ssize_t count = ::write(file, bytes.data() + done, bytes.size() - done);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) ::_exit(2);
    done += static_cast<std::size_t>(count);
  }
}

/// The child's answer: one letter (D done, T threw, N threw a number), then bytes or message.
std::string Answer(const std::function<std::string()>& work) {
  try {
    return "D" + work();
  } catch (const std::bad_alloc&) {
    return "Tit needs more memory than it may take";
  } catch (const std::exception& error) {
    return std::string("T") + error.what();
  } catch (int number) {  // TetGen's way to fail.
    return "N" + std::to_string(number);
  }
}

[[noreturn]] void BeChild(const std::function<std::string()>& work, int output, double memory) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  ::signal(SIGINT, SIG_IGN);  // The parent decides; it kills this process when it is stopped.
  ::signal(SIGPIPE, SIG_DFL);
  for (const int signal : {SIGSEGV, SIGABRT, SIGBUS, SIGFPE, SIGILL, SIGTERM}) {
    ::signal(signal, SIG_DFL);
  }
  const rlimit no_core{0, 0};
  ::setrlimit(RLIMIT_CORE, &no_core);
  const int null = ::open("/dev/null", O_RDWR);
  ::dup2(null, STDOUT_FILENO);
  ::dup2(null, STDERR_FILENO);
  // The threads of a pool do not survive the fork: VTK must not wait for them.
  ::setenv("VTK_SMP_BACKEND_IN_USE", "Sequential", 1);
  LimitMemory(memory);
  WriteAll(output, Answer(work));
  ::_exit(0);
}

/// Owns the child and the reading end of its pipe.
class Child {
 public:
  Child(pid_t id, int input) : id_(id), input_(input) {}
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;
  ~Child() {
    if (id_ > 0) {
      ::kill(id_, SIGKILL);
      Wait();
    }
    ::close(input_);
  }
  int Wait() {
    int status = 0;
    while (::waitpid(id_, &status, 0) < 0 && errno == EINTR) {
    }
    id_ = -1;
    return status;
  }
  int input() const { return input_; }

 private:
  pid_t id_;
  int input_;
};

/// Reads until the child closes its end. False if the time is over.
bool ReadUntilEnd(int input, const ChildLimits& limits, std::string& bytes) {
  using Clock = std::chrono::steady_clock;
  const auto end = Clock::now() + std::chrono::duration_cast<Clock::duration>(
                                      std::chrono::duration<double>(limits.time_s));
  std::array<char, 65536> buffer{};
  while (Clock::now() < end) {
    if (limits.on_wait) limits.on_wait();
    pollfd wait{input, POLLIN, 0};
    if (::poll(&wait, 1, 200) <= 0) continue;
    const ssize_t count = ::read(input, buffer.data(), buffer.size());
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return true;
    bytes.append(buffer.data(), static_cast<std::size_t>(count));
  }
  return false;
}

}  // namespace

ChildResult RunInChild(const std::function<std::string()>& work, const ChildLimits& limits) {
  std::array<int, 2> ends{};
  ACUS_REQUIRE(::pipe2(ends.data(), O_CLOEXEC) == 0, "no pipe: ", std::strerror(errno));
  const pid_t id = ::fork();
  if (id == 0) {
    ::close(ends[0]);
    BeChild(work, ends[1], limits.memory_bytes);
  }
  ::close(ends[1]);
  if (id < 0) {
    ::close(ends[0]);
    throw InputError(Message("no process can be started: ", std::strerror(errno)));
  }
  Child child(id, ends[0]);
  ChildResult out;
  if (!ReadUntilEnd(child.input(), limits, out.bytes)) {
    out.end = ChildResult::End::kTimedOut;
    out.problem = Message("no answer within ", limits.time_s, " s");
    return out;
  }
  const int status = child.Wait();
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0 || out.bytes.empty()) {
    out.end = ChildResult::End::kCrashed;
    out.problem = WIFSIGNALED(status) ? ::strsignal(WTERMSIG(status)) : "it ended on its own";
    return out;
  }
  const char kind = out.bytes.front();
  out.bytes.erase(0, 1);
  if (kind != 'D') {
    out.end = kind == 'N' ? ChildResult::End::kThrewNumber : ChildResult::End::kThrew;
    out.problem.swap(out.bytes);
  }
  return out;
}

}  // namespace acus::core
