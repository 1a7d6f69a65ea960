#include "acus/patient/registration/touches.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "acus/base/core/error.h"
#include "acus/base/core/text_table.h"
#include "acus/base/math/statistics.h"
#include "acus/patient/registration/rigid_registration.h"

namespace acus::registration {
namespace {

using Eigen::Vector3d;

constexpr double kShaftMm = 100.0;
constexpr int kMostChoices = 20000;

struct TipSample {
  std::int64_t time_ns;
  Vector3d tip_mm;
  Vector3d shaft_mm;
};

void Check(const TouchSettings& s) {
  ACUS_REQUIRE(s.window_s > 0.0 && s.window_s <= 10.0, "the window must be in (0, 10] s, got ",
               s.window_s);
  ACUS_REQUIRE(s.least_s >= s.window_s, "a rest must last at least one window of ", s.window_s,
               " s, got ", s.least_s);
  ACUS_REQUIRE(s.still_mm > 0.0, "the tip must be allowed to move by more than 0 mm, got ",
               s.still_mm);
  ACUS_REQUIRE(s.shaft_mm >= 0.0 && s.same_place_mm >= 0.0,
               "the shaft's way and the distance of places must not be negative");
  ACUS_REQUIRE(s.average_from_s >= 0.0 && s.average_to_s > s.average_from_s,
               "what is averaged must begin before it ends, got ", s.average_from_s, " to ",
               s.average_to_s, " s");
}

std::vector<TipSample> TipSamples(const session::PoseStream& stream, const Vector3d& tip_mm) {
  const double length_mm = tip_mm.norm();
  const Vector3d up = length_mm > 1e-6 ? Vector3d(-tip_mm / length_mm) : Vector3d(0, 0, -1);
  const Vector3d shaft_mm = tip_mm + kShaftMm * up;
  std::vector<TipSample> samples;
  for (const session::PoseSample& sample : stream) {
    if (!sample.valid) continue;
    samples.push_back({.time_ns = sample.time_ns,
                       .tip_mm = sample.reference_from_tool * tip_mm,
                       .shaft_mm = sample.reference_from_tool * shaft_mm});
  }
  return samples;
}

double MedianIntervalS(const std::vector<TipSample>& samples) {
  std::vector<double> intervals_s;
  for (std::size_t i = 1; i < samples.size(); ++i) {
    intervals_s.push_back(static_cast<double>(samples[i].time_ns - samples[i - 1].time_ns) * 1e-9);
  }
  return math::Median(intervals_s);
}

/// A rest: samples [begin, end).
struct Rest {
  std::size_t begin;
  std::size_t end;
};

std::vector<Rest> FindRests(const std::vector<TipSample>& samples, const TouchSettings& settings) {
  const double interval_s = std::max(1e-6, MedianIntervalS(samples));
  const auto window =
      static_cast<std::size_t>(std::max(1.0, std::round(settings.window_s / interval_s)));
  const auto least = static_cast<std::size_t>(std::floor(settings.least_s / settings.window_s));
  std::vector<Rest> rests;
  std::size_t begin = 0;
  Eigen::AlignedBox3d tip, shaft;
  const auto restart = [&](std::size_t at) {
    begin = at;
    tip.setEmpty();
    shaft.setEmpty();
  };
  for (std::size_t end = window; end <= samples.size(); ++end) {
    if ((end - begin) % window != 0 || end == begin) continue;
    Vector3d mean_mm = Vector3d::Zero();
    for (std::size_t i = end - window; i < end; ++i) mean_mm += samples[i].tip_mm;
    tip.extend(Vector3d(mean_mm / static_cast<double>(window)));
    shaft.extend(samples[end - 1].shaft_mm);
    if (tip.diagonal().norm() > settings.still_mm) {
      restart(end);
    } else if ((end - begin) / window >= least && shaft.diagonal().norm() >= settings.shaft_mm) {
      rests.push_back({begin, end});
      restart(end);
    }
  }
  return rests;
}

/// The samples of a place, gathered over its rests.
struct Place {
  Vector3d first_mm;
  Touch touch;
  std::vector<Vector3d> tips_mm;
};

void Add(const std::vector<TipSample>& samples, const Rest& rest, const TouchSettings& settings,
         bool is_first, Place& place) {
  const std::int64_t start_ns = samples[rest.begin].time_ns;
  for (std::size_t i = rest.begin; i < rest.end; ++i) {
    const double since_s = static_cast<double>(samples[i].time_ns - start_ns) * 1e-9;
    const bool within = since_s >= settings.average_from_s && since_s < settings.average_to_s;
    const bool later = !is_first && std::isinf(settings.average_to_s);
    if (is_first ? within : later) place.tips_mm.push_back(samples[i].tip_mm);
  }
  place.touch.end_ns = samples[rest.end - 1].time_ns;
}

Vector3d MeanTip(const std::vector<TipSample>& samples, const Rest& rest) {
  Vector3d sum_mm = Vector3d::Zero();
  for (std::size_t i = rest.begin; i < rest.end; ++i) sum_mm += samples[i].tip_mm;
  return sum_mm / static_cast<double>(rest.end - rest.begin);
}

/// Takes out the beginnings of moves: far from the median, against the middle distance from it.
void Trim(std::vector<Vector3d>& tips_mm) {
  Vector3d median_mm;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> values;
    for (const Vector3d& tip_mm : tips_mm) values.push_back(tip_mm[axis]);
    median_mm[axis] = math::Median(values);
  }
  std::vector<double> distances_mm;
  for (const Vector3d& tip_mm : tips_mm) distances_mm.push_back((tip_mm - median_mm).norm());
  const double limit_mm = 3.0 * math::Median(distances_mm) + 1e-9;
  std::erase_if(tips_mm, [&](const Vector3d& tip) { return (tip - median_mm).norm() > limit_mm; });
}

void Finish(const TouchSettings& settings, Place& place) {
  Touch& touch = place.touch;
  if (std::isinf(settings.average_to_s)) Trim(place.tips_mm);
  touch.num_samples = place.tips_mm.size();
  for (const Vector3d& tip_mm : place.tips_mm) touch.reference_mm += tip_mm;
  touch.reference_mm /= static_cast<double>(touch.num_samples);
  double sum_mm2 = 0.0;
  for (const Vector3d& tip_mm : place.tips_mm) {
    sum_mm2 += (tip_mm - touch.reference_mm).squaredNorm();
  }
  touch.rms_mm = std::sqrt(sum_mm2 / static_cast<double>(touch.num_samples));
}

}  // namespace

std::vector<Touch> FindTouches(const session::PoseStream& reference_from_tool,
                               const Vector3d& tip_mm, const TouchSettings& settings) {
  Check(settings);
  const auto samples = TipSamples(reference_from_tool, tip_mm);
  ACUS_REQUIRE(samples.size() >= 2, "the recording has ", samples.size(),
               " valid poses of the pointer; nothing can be found in it");
  std::vector<Place> places;
  for (const Rest& rest : FindRests(samples, settings)) {
    const Vector3d mean_mm = MeanTip(samples, rest);
    const auto near = std::ranges::find_if(places, [&](const Place& place) {
      return (place.first_mm - mean_mm).norm() < settings.same_place_mm;
    });
    const bool is_first = near == places.end();
    if (is_first) {
      places.push_back({.first_mm = mean_mm, .touch = {}, .tips_mm = {}});
      places.back().touch.start_ns = samples[rest.begin].time_ns;
    }
    Add(samples, rest, settings, is_first, is_first ? places.back() : *near);
  }
  std::vector<Touch> touches;
  for (Place& place : places) {
    ACUS_REQUIRE(!place.tips_mm.empty(), "no sample lies within the ", settings.average_from_s,
                 " to ", settings.average_to_s, " s that are to be averaged");
    Finish(settings, place);
    touches.push_back(place.touch);
  }
  return touches;
}

std::vector<Touch> ChooseTouches(const std::vector<Touch>& touches,
                                 const transforms::Landmarks& known) {
  const auto wanted = static_cast<std::size_t>(known.points_mm.cols());
  if (touches.size() <= wanted || wanted < 4) return touches;
  std::vector<std::size_t> chosen(wanted);
  std::iota(chosen.begin(), chosen.end(), 0U);
  std::vector<std::size_t> best;
  double best_mm = std::numeric_limits<double>::infinity();
  double second_mm = best_mm;
  for (int tried = 0; tried < kMostChoices; ++tried) {
    transforms::Markers touched_mm(3, known.points_mm.cols());
    for (std::size_t i = 0; i < wanted; ++i) {
      touched_mm.col(static_cast<Eigen::Index>(i)) = touches[chosen[i]].reference_mm;
    }
    const Vector3d spread_mm = SpreadMm(touched_mm);
    const double fre_mm = spread_mm[1] < 1.0 ? std::numeric_limits<double>::infinity()
                                             : FitMarkers(touched_mm, known.points_mm).fre_rms_mm;
    if (fre_mm < best_mm) {
      second_mm = std::exchange(best_mm, fre_mm);
      best = chosen;
    } else {
      second_mm = std::min(second_mm, fre_mm);
    }
    std::size_t at = wanted;
    while (at > 0 && chosen[at - 1] == touches.size() - wanted + at - 1) --at;
    if (at == 0) break;
    ++chosen[at - 1];
    for (std::size_t i = at; i < wanted; ++i) chosen[i] = chosen[i - 1] + 1;
  }
  // Clear only if the points fit well, and no other choice does.
  const bool clear = best_mm < 0.05 * SpreadMm(known.points_mm).norm() && second_mm > 3.0 * best_mm;
  if (!clear) return touches;
  std::vector<Touch> result;
  for (const std::size_t i : best) result.push_back(touches[i]);
  return result;
}

transforms::Landmarks NamedTouches(const std::vector<Touch>& touches,
                                   const transforms::Landmarks& known, const std::string& source) {
  std::string found;
  for (const Touch& touch : touches) {
    found += Message(found.empty() ? "" : ", ",
                     FixedText(static_cast<double>(touch.start_ns) * 1e-9, 1), " s");
  }
  ACUS_REQUIRE(static_cast<Eigen::Index>(touches.size()) == known.points_mm.cols(), source,
               ": the tip rested at ", touches.size(), " places (at ", found.empty() ? "-" : found,
               "), but ", known.source, " has ", known.points_mm.cols(),
               " points; touch each once, for at least a second, or change what counts as a rest");
  transforms::Landmarks landmarks;
  landmarks.source = source;
  landmarks.names = known.names;
  landmarks.points_mm.resize(3, known.points_mm.cols());
  for (std::size_t i = 0; i < touches.size(); ++i) {
    landmarks.points_mm.col(static_cast<Eigen::Index>(i)) = touches[i].reference_mm;
  }
  return landmarks;
}

transforms::Landmarks SweptPoints(const session::PoseStream& reference_from_tool,
                                  const Vector3d& tip_mm, double spacing_mm,
                                  const std::string& source) {
  std::vector<Vector3d> kept;
  for (const session::PoseSample& sample : reference_from_tool) {
    if (!sample.valid) continue;
    const Vector3d tip = sample.reference_from_tool * tip_mm;
    if (kept.empty() || (tip - kept.back()).norm() >= spacing_mm) kept.push_back(tip);
  }
  transforms::Landmarks landmarks;
  landmarks.source = source;
  landmarks.names.resize(kept.size());
  landmarks.points_mm.resize(3, static_cast<Eigen::Index>(kept.size()));
  for (std::size_t i = 0; i < kept.size(); ++i) {
    landmarks.points_mm.col(static_cast<Eigen::Index>(i)) = kept[i];
  }
  return landmarks;
}

}  // namespace acus::registration
