#include "core/parallel.h"

#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cstddef>

namespace acus {

void ParallelFor(int count, int num_threads, const std::function<void(int)>& body) {
  if (num_threads <= 1 || count <= 1) {
    for (int i = 0; i < count; ++i) body(i);
    return;
  }
  // Without this, TBB prints a warning when more threads are asked for than there are cores.
  const auto most = static_cast<std::size_t>(std::max(num_threads, tbb::info::default_concurrency()));
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, most);
  tbb::task_arena arena(num_threads);
  arena.execute([&] { tbb::parallel_for(0, count, [&body](int i) { body(i); }); });
}

}  // namespace acus
