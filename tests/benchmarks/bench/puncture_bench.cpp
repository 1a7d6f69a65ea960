// Where the layers of the tissue block are pierced, with elements of the sizes that are given, mm:
//   bench_puncture 4 2 1
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <exception>

#include "benchmarks/punctures.h"

int main(int argc, char** argv) {
  constexpr double kMemoryMib = 20000.0;
  try {
    acus::Provenance provenance;
    const auto tables = acus::benchmarks::TissueBlockTables::FromPresets(provenance);
    for (int n = 1; n < argc; ++n) {
      const auto begin = std::chrono::steady_clock::now();
      std::printf("elements of %s mm:", argv[n]);
      for (const acus::benchmarks::Puncture& p :
           acus::benchmarks::PuncturesWith(std::atof(argv[n]), tables, kMemoryMib)) {
        std::printf("  %.2f mm %.2f N", p.depth_mm, p.force_n);
      }
      const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - begin;
      std::printf("  (%.0f s)\n", taken.count());
      std::fflush(stdout);
    }
  } catch (const std::exception& error) {
    std::fprintf(stderr, "bench_puncture: %s\n", error.what());
    return 1;
  }
  return 0;
}
