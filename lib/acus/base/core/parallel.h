// Loops over independent pieces, on several threads.
#pragma once

#include <functional>

namespace acus {

/// Calls body(i) once for each i in [0, count), on at most `num_threads` threads, in any order.
/// Each i writes only its own output: then the result cannot depend on `num_threads`.
/// An exception of any body stops the rest and is rethrown here. Pieces should take >= 10 us.
/// The threads stay for the next loop: then nothing is allocated (loops within loops and beside
/// loops start threads of their own).
void ParallelFor(int count, int num_threads, const std::function<void(int)>& body);

}  // namespace acus
