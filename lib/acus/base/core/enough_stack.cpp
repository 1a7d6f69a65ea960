#include "acus/base/core/enough_stack.h"

#include <pthread.h>
#include <sys/resource.h>
#include <system_error>
#include <thread>

namespace acus {
namespace {

constexpr std::size_t kStackBytes = std::size_t{8} << 20U;

/// False if the system gives a large stack anyway.
bool SetStackOfNewThreads() {
  rlimit limit{};
  if (::getrlimit(RLIMIT_STACK, &limit) != 0 || limit.rlim_cur >= kStackBytes) return false;
  pthread_attr_t attributes;
  if (::pthread_attr_init(&attributes) != 0) return false;
  const bool is_set = ::pthread_attr_setstacksize(&attributes, kStackBytes) == 0 &&
                      ::pthread_setattr_default_np(&attributes) == 0;
  ::pthread_attr_destroy(&attributes);
  return is_set;
}

}  // namespace

void CallWithEnoughStack(const std::function<void()>& work) {
  if (!SetStackOfNewThreads()) return work();
  std::thread thread;
  try {
    thread = std::thread(work);
  } catch (const std::system_error&) {
    return work();  // No memory for a thread: the small stack may suffice.
  }
  thread.join();
}

}  // namespace acus
