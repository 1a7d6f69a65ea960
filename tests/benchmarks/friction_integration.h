// LuGre friction carried over a step by several methods: what the choice of one costs and buys.
#pragma once

#include <string_view>
#include <vector>

#include "acus/physics/forces/laws/lugre.h"

namespace acus::benchmarks {

/// All see the same samples of the needle's depth, and solve the same law (forces/lugre.h, with its
/// filtered speed).
enum class FrictionMethod {
  kShipped,        ///< Exact for constant speed over the step: forces::LuGre.
  kImplicitEuler,  ///< z+ = (z + T v) / (1 + T sigma0 |v| / g).
  kExplicitEuler,  ///< z+ = z + T (v - sigma0 |v| z / g): stable while sigma0 |v| T / g < 2.
  kRungeKutta4,    ///< Fourth order, with the speed of the parabola through three samples.
};
std::string_view NameOf(FrictionMethod method);
constexpr FrictionMethod kFrictionMethods[] = {
    FrictionMethod::kShipped, FrictionMethod::kImplicitEuler, FrictionMethod::kExplicitEuler,
    FrictionMethod::kRungeKutta4};

/// The depth of a shaft that is rubbed to and fro, up to 0.21 m/s, mm.
double RubbedDepthMm(double time_s);
constexpr double kRubbedS = 4.0;

struct FrictionRun {
  std::vector<double> force_n;  ///< Every 10 ms from 0.01 s on, for a normal force of 1 N.
  std::vector<double> step_us;  ///< CPU time of a step, means over many.
};

/// @param step_ms  divides 10 ms. @pre the law's speed_filter_s > 0, here and below.
FrictionRun RunFriction(const forces::LuGreParameters& law, FrictionMethod method, double step_ms);

/// The law itself: fourth order with the motion's own speed, in steps of 5 us.
FrictionRun ReferenceFriction(const forces::LuGreParameters& law, double step_ms = 0.005);

}  // namespace acus::benchmarks
