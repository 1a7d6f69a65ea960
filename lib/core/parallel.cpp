#include "core/parallel.h"

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

namespace acus {

void ParallelFor(int count, int num_threads, const std::function<void(int)>& body) {
  if (num_threads <= 1 || count <= 1) {
    for (int i = 0; i < count; ++i) body(i);
    return;
  }
  tbb::task_arena arena(num_threads);
  arena.execute([&] { tbb::parallel_for(0, count, [&body](int i) { body(i); }); });
}

}  // namespace acus
