// How the force of held tissue falls with time.
#pragma once

#include <array>

namespace acus::mechanics {

/// A Prony series: after a step of deformation the force is that of the elastic tissue times
///   1 - sum_k share_k (1 - exp(-t / time_k)).
/// The same for all tissues of a scene, so that the elastic solution carries over (correspondence
/// principle; Christensen 1982, Theory of Viscoelasticity, ch. 2).
struct Relaxation {
  static constexpr int kMostTerms = 4;
  struct Term {
    double share = 0.0;   ///< 0 .. 1; all together below 1.
    double time_s = 1.0;  ///< > 0.
  };
  std::array<Term, kMostTerms> term{};
  int num_terms = 0;  ///< 0: elastic.
};

}  // namespace acus::mechanics
