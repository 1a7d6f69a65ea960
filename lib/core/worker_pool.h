// Threads that stay: for work of a millisecond, where starting threads would cost too much.
#pragma once

#include <memory>

namespace acus {

/// Runs loops over independent pieces on the caller's thread and on helpers that wait in between.
/// No allocation after construction. One caller at a time.
class WorkerPool {
 public:
  /// @param num_threads  With the caller; below 2 there are no helpers. If the system has no thread
  ///     left, those that could be started do the work.
  explicit WorkerPool(int num_threads);
  ~WorkerPool();
  WorkerPool(const WorkerPool&) = delete;
  WorkerPool& operator=(const WorkerPool&) = delete;

  /// With the caller.
  int num_threads() const;

  /// Calls body(i) once for each i in [0, count), in any order, and returns when all are done.
  /// Each i writes only its own output: then the result cannot depend on the number of threads.
  /// @pre body does not throw.
  template <typename Body>
  void Run(int count, const Body& body) {
    RunPieces(
        count, [](const void* self, int i) { (*static_cast<const Body*>(self))(i); }, &body);
  }

 private:
  using Call = void (*)(const void*, int);
  void RunPieces(int count, Call call, const void* body);

  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace acus
