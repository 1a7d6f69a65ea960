// A stack that suffices, also where the system gives programs a small one (ulimit -s).
#pragma once

#include <functional>

namespace acus {

/// Calls `work` on a stack of at least 8 MB: on the caller's, or on a thread with such a stack if
/// the limit is lower. Threads that are started from then on have such a stack, too.
/// @param work  Must not throw.
void CallWithEnoughStack(const std::function<void()>& work);

}  // namespace acus
