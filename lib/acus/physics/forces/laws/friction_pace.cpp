#include "acus/physics/forces/laws/friction_pace.h"

#include <algorithm>
#include <cmath>

namespace acus::forces {
namespace {

constexpr double kShaftPlayMm = 0.005;   // Jitter of an encoder: neither speed nor slip.
constexpr double kSpeedFilterS = 0.020;  // An encoder's steps look like short bursts.
constexpr double kLongestPieceS = 0.005;
constexpr double kLongestPieceOfSlip = 0.25;
constexpr double kMostPieces = 64.0;

}  // namespace

double MovedMm(FrictionPace& pace, double travel_mm) noexcept {
  const double ahead_mm = pace.ahead_mm + travel_mm;
  pace.ahead_mm = std::clamp(ahead_mm, -kShaftPlayMm, kShaftPlayMm);
  return ahead_mm - pace.ahead_mm;
}

int PiecesOf(const FrictionTime& settings, double moved_mm, double dt_s) noexcept {
  if (moved_mm == 0.0) return 1;
  const double pieces = std::ceil(std::max(
      dt_s / kLongestPieceS, std::abs(moved_mm) / (kLongestPieceOfSlip * settings.slip_mm)));
  return static_cast<int>(std::clamp(pieces, 1.0, kMostPieces));
}

PaceLogs AdvancePace(FrictionPace& pace, const FrictionTime& settings,
                     const ShaftMove& move) noexcept {
  const double dt_s = move.dt_s;
  const double speed = move.travel_mm / dt_s;
  const double speed_before = pace.speed_mm_per_s;
  pace.speed_mm_per_s = speed + (speed_before - speed) * std::exp(-dt_s / kSpeedFilterS);
  const double age_before_s = pace.age_s;
  const double slid = std::abs(move.slid_mm) / settings.slip_mm;
  const double kept_s = slid > 0.0 ? dt_s * -std::expm1(-slid) / slid : dt_s;
  pace.age_s = age_before_s * std::exp(-slid) + kept_s;
  return {settings.RateLog(0.5 * (speed_before + pace.speed_mm_per_s)),
          settings.DwellLog(0.5 * (age_before_s + pace.age_s))};
}

PaceLogs StepPace(FrictionPace& pace, const FrictionTime& settings,
                  const ShaftMove& move) noexcept {
  const double moved_mm = MovedMm(pace, move.travel_mm);
  const int pieces = PiecesOf(settings, moved_mm, move.dt_s);
  PaceLogs logs;
  for (int piece = 0; piece < pieces; ++piece) {
    logs =
        AdvancePace(pace, settings, {moved_mm / pieces, move.slid_mm / pieces, move.dt_s / pieces});
  }
  return logs;
}

double FrictionShare(const TissueTime& time, const PaceLogs& logs) noexcept {
  return 1.0 + time.friction_rate * logs.rate + time.friction_dwell * logs.dwell;
}

double StrainAfter(double strain, double strained, double decay, double limit) noexcept {
  // Where the limit has fallen below the strain, sliding takes the rest off, not the moment.
  const double faded = std::exp(-std::abs(strained));
  const double above = limit + std::max(0.0, strain - limit) * faded;
  const double below = limit + std::max(0.0, -strain - limit) * faded;
  const double free = decay > 0.0
                          ? strained / decay + (strain - strained / decay) * std::exp(-decay)
                          : strain + strained;
  return std::clamp(free, -below, above);
}

}  // namespace acus::forces
