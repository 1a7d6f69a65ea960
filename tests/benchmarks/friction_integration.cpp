#include "benchmarks/friction_integration.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "acus/base/core/cpu_time.h"
#include "acus/base/core/error.h"

namespace acus::benchmarks {
namespace {

constexpr double kCommonMs = 10.0;
constexpr double kStrokeMm = 25.0;
constexpr double kRippleMm = 3.0;
constexpr double kRippleHz = 3.1;
constexpr double kTurn = 2.0 * std::numbers::pi;

constexpr double kBeginS = 0.5;  ///< From rest to full strokes.

double FullStrokesMm(double time_s) {
  return kStrokeMm * std::sin(kTurn * time_s) + kRippleMm * std::sin(kTurn * kRippleHz * time_s);
}

double RubbedSpeedMmPerS(double time_s) {
  const double s = std::min(1.0, time_s / kBeginS);
  const double share = s * s * s * (10.0 + s * (-15.0 + 6.0 * s));
  const double share_per_s = 30.0 * s * s * (1.0 - s) * (1.0 - s) / kBeginS;
  const double full_mm_per_s =
      kTurn * (kStrokeMm * std::cos(kTurn * time_s) +
               kRippleMm * kRippleHz * std::cos(kTurn * kRippleHz * time_s));
  return share * full_mm_per_s + share_per_s * FullStrokesMm(time_s);
}

/// Bristles and filtered speed, and the slopes of both.
struct Bristles {
  double z_mm = 0.0;
  double filtered_mm_per_s = 0.0;
};

Bristles SlopeOf(const forces::LuGreParameters& law, const Bristles& at, double speed_mm_per_s) {
  const double g = law.Stribeck(at.filtered_mm_per_s);
  return {speed_mm_per_s - law.sigma0_per_mm * std::abs(speed_mm_per_s) / g * at.z_mm,
          (speed_mm_per_s - at.filtered_mm_per_s) / law.speed_filter_s};
}

Bristles Plus(const Bristles& a, const Bristles& slope, double dt_s) {
  return {a.z_mm + dt_s * slope.z_mm, a.filtered_mm_per_s + dt_s * slope.filtered_mm_per_s};
}

Bristles RungeKutta4(const forces::LuGreParameters& law, const Bristles& at, double dt_s,
                     double begin_mm_per_s, double middle_mm_per_s, double end_mm_per_s) {
  const Bristles a = SlopeOf(law, at, begin_mm_per_s);
  const Bristles b = SlopeOf(law, Plus(at, a, 0.5 * dt_s), middle_mm_per_s);
  const Bristles c = SlopeOf(law, Plus(at, b, 0.5 * dt_s), middle_mm_per_s);
  const Bristles d = SlopeOf(law, Plus(at, c, dt_s), end_mm_per_s);
  Bristles out = Plus(at, a, dt_s / 6.0);
  out = Plus(out, b, dt_s / 3.0);
  out = Plus(out, c, dt_s / 3.0);
  return Plus(out, d, dt_s / 6.0);
}

double ForceN(const forces::LuGreParameters& law, const Bristles& at, double speed_mm_per_s) {
  double sigma1 = law.sigma1_s_per_mm;
  if (speed_mm_per_s != 0.0) {
    sigma1 = std::min(sigma1, 4.0 * law.Stribeck(at.filtered_mm_per_s) / std::abs(speed_mm_per_s));
  }
  return law.sigma0_per_mm * at.z_mm + sigma1 * SlopeOf(law, at, speed_mm_per_s).z_mm +
         law.sigma2_s_per_mm * at.filtered_mm_per_s;
}

/// One needle rubbed, by one method.
class Rubbing {
 public:
  Rubbing(const forces::LuGreParameters& law, FrictionMethod method) : law_(law), method_(method) {}

  double Step(double depth_mm, double dt_s) {
    const double travel_mm = depth_mm - depth_mm_;
    depth_mm_ = depth_mm;
    if (method_ == FrictionMethod::kShipped) {
      return shipped_.Advance(law_, travel_mm, dt_s, 1.0);
    }
    const double speed = travel_mm / dt_s;
    const double before_speed = speed_mm_per_s_;
    speed_mm_per_s_ = speed;
    const Bristles before = at_;
    switch (method_) {
      case FrictionMethod::kImplicitEuler: {
        const double share = dt_s / law_.speed_filter_s;
        at_.filtered_mm_per_s = (before.filtered_mm_per_s + share * speed) / (1.0 + share);
        const double g = law_.Stribeck(at_.filtered_mm_per_s);
        at_.z_mm = (before.z_mm + travel_mm) / (1.0 + law_.sigma0_per_mm * std::abs(travel_mm) / g);
        return ForceN(law_, at_, speed);
      }
      case FrictionMethod::kExplicitEuler:
        at_ = Plus(before, SlopeOf(law_, before, speed), dt_s);
        return ForceN(law_, at_, speed);
      default:
        break;
    }
    // The parabola through this sample and the two before: its speed at both ends of the step.
    const double bend = 0.5 * (speed - before_speed);
    at_ = RungeKutta4(law_, before, dt_s, speed - bend, speed, speed + bend);
    return ForceN(law_, at_, speed + bend);
  }

 private:
  const forces::LuGreParameters& law_;
  FrictionMethod method_;
  forces::LuGre shipped_;
  Bristles at_;
  double depth_mm_ = RubbedDepthMm(0.0);
  double speed_mm_per_s_ = 0.0;
};

}  // namespace

std::string_view NameOf(FrictionMethod method) {
  switch (method) {
    case FrictionMethod::kShipped:
      return "exact over the step";
    case FrictionMethod::kImplicitEuler:
      return "implicit Euler";
    case FrictionMethod::kExplicitEuler:
      return "explicit Euler";
    case FrictionMethod::kRungeKutta4:
      return "Runge-Kutta 4";
  }
  return "";
}

double RubbedDepthMm(double time_s) {
  const double s = std::min(1.0, time_s / kBeginS);
  return s * s * s * (10.0 + s * (-15.0 + 6.0 * s)) * FullStrokesMm(time_s);
}

FrictionRun RunFriction(const forces::LuGreParameters& law, FrictionMethod method, double step_ms) {
  const int per_common = static_cast<int>(std::lround(kCommonMs / step_ms));
  ACUS_ASSERT(std::abs(per_common * step_ms - kCommonMs) < 1e-9);
  const int num_common = static_cast<int>(std::lround(1e3 * kRubbedS / kCommonMs));
  std::vector<double> depth_mm;
  for (int n = 1; n <= num_common * per_common; ++n) {
    depth_mm.push_back(RubbedDepthMm(1e-3 * step_ms * n));
  }
  Rubbing rubbing(law, method);
  FrictionRun run;
  std::size_t next = 0;
  // The clock is read once for many steps: a step is far cheaper than that.
  const int common_per_timing = std::max(1, 20 / per_common);
  double before_s = ThreadCpuSeconds();
  for (int i = 1; i <= num_common; ++i) {
    double force_n = 0.0;
    for (int k = 0; k < per_common; ++k) {
      force_n = rubbing.Step(depth_mm[next++], 1e-3 * step_ms);
    }
    run.force_n.push_back(force_n);
    if (i % common_per_timing != 0) continue;
    const double now_s = ThreadCpuSeconds();
    run.step_us.push_back(1e6 * (now_s - before_s) / (common_per_timing * per_common));
    before_s = now_s;
  }
  return run;
}

FrictionRun ReferenceFriction(const forces::LuGreParameters& law, double step_ms) {
  const int per_common = static_cast<int>(std::lround(kCommonMs / step_ms));
  const int num_common = static_cast<int>(std::lround(1e3 * kRubbedS / kCommonMs));
  const double dt_s = 1e-3 * step_ms;
  Bristles at;
  FrictionRun run;
  for (int i = 0; i < num_common; ++i) {
    for (int k = 0; k < per_common; ++k) {
      const double t = dt_s * (static_cast<double>(i) * per_common + k);
      at = RungeKutta4(law, at, dt_s, RubbedSpeedMmPerS(t), RubbedSpeedMmPerS(t + 0.5 * dt_s),
                       RubbedSpeedMmPerS(t + dt_s));
    }
    run.force_n.push_back(ForceN(law, at, RubbedSpeedMmPerS(1e-3 * kCommonMs * (i + 1))));
  }
  return run;
}

}  // namespace acus::benchmarks
