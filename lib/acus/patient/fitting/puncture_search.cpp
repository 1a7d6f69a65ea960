#include "acus/patient/fitting/puncture_search.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <functional>
#include <span>

#include "acus/base/core/error.h"
#include "acus/patient/fitting/event_pursuit.h"
#include "acus/patient/fitting/series_fit.h"

namespace acus::fitting {
namespace {

constexpr int kMostTrials = 12;  // Of taking an event out again.
constexpr double kPeakWithinMm =
    0.5;  // A place to look at is the largest in so much on both sides.
constexpr double kRisesMm[] = {0.4, 0.8, 1.5, 2.5, 4.0, 6.0, 9.0, 14.0};
constexpr double kRecoveriesMm[] = {0.1, 0.4, 1.0, 2.5};
constexpr double kWidthsMm[] = {0.1, 0.4, 1.2, 3.0};

/// Depths at which what remains (times the sign of the strain) is larger than around it.
std::vector<std::size_t> Peaks(const StrainedRows& rows, const Eigen::VectorXd& residual) {
  std::vector<std::size_t> peaks;
  const std::size_t n = rows.depth_mm.size();
  for (std::size_t i = 0; i < n; ++i) {
    bool largest = true;
    for (std::size_t j = i; j-- > 0 && largest;) {
      if (std::abs(rows.depth_mm[i] - rows.depth_mm[j]) > kPeakWithinMm) break;
      largest = residual(static_cast<Eigen::Index>(i)) >= residual(static_cast<Eigen::Index>(j));
    }
    for (std::size_t j = i + 1; j < n && largest; ++j) {
      if (std::abs(rows.depth_mm[i] - rows.depth_mm[j]) > kPeakWithinMm) break;
      largest = residual(static_cast<Eigen::Index>(i)) > residual(static_cast<Eigen::Index>(j));
    }
    if (largest) peaks.push_back(i);
  }
  return peaks;
}

/// Place: depth of the puncture, rise before it, recovery after it. Columns: rising, rising with
/// the square, and the change that stays.
EventShape PunctureShape(const StrainedRows& rows, const std::vector<double>& place) {
  const double rise_mm = place[1];
  const double contact_mm = place[0] - rise_mm;
  const double recovery_mm = place[2];
  const auto n = static_cast<Eigen::Index>(rows.depth_mm.size());
  EventShape shape{place, Eigen::MatrixXd::Zero(n, 3)};
  for (Eigen::Index i = 0; i < n; ++i) {
    const double x = rows.depth_mm[static_cast<std::size_t>(i)] - contact_mm;
    if (x <= 0.0) continue;
    const double strain = rows.strain[static_cast<std::size_t>(i)];
    const double fading = x <= rise_mm ? 1.0 : std::exp(-(x - rise_mm) / recovery_mm);
    const double within = std::min(x, rise_mm);
    shape.columns(i, 0) = strain * within * fading;
    shape.columns(i, 1) = strain * within * within * fading;
    shape.columns(i, 2) = x <= rise_mm ? 0.0 : strain * (1.0 - fading);
  }
  return shape;
}

EventShape ReleaseShape(const StrainedRows& rows, const std::vector<double>& place) {
  const auto n = static_cast<Eigen::Index>(rows.depth_mm.size());
  EventShape shape{place, Eigen::MatrixXd::Zero(n, 1)};
  const Release unit{place[0], place[1], 1.0};
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto k = static_cast<std::size_t>(i);
    shape.columns(i, 0) = rows.strain[k] * unit.ForceN(rows.depth_mm[k]);
  }
  return shape;
}

std::vector<SeriesParameter> ProfileParameters(const ResistanceProfile& profile) {
  std::vector<SeriesParameter> parameters;
  for (const double force : profile.force_n) {
    parameters.push_back({"profile", std::clamp(force, -50.0, 100.0), -50.0, 100.0});
  }
  return parameters;
}

/// Profile (the first parameters) plus events, at all rows.
SeriesModel WholeModel(const StrainedRows& rows, const std::vector<double>& knots,
                       std::function<double(std::span<const double>, double)> events) {
  return [&rows, knots, events = std::move(events)](std::span<const double> p,
                                                    std::span<double> predicted) {
    const std::size_t count = knots.size();
    for (std::size_t i = 0; i < predicted.size(); ++i) {
      const double depth = rows.depth_mm[i];
      const auto above = std::upper_bound(knots.begin(), knots.end(), depth);
      const std::size_t k =
          std::clamp<std::size_t>(static_cast<std::size_t>(above - knots.begin()), 1, count - 1);
      const double along = (depth - knots[k - 1]) / (knots[k] - knots[k - 1]);
      const double base = p[k - 1] + along * (p[k] - p[k - 1]);
      predicted[i] = rows.strain[i] * (base + events(p.subspan(count), depth));
    }
  };
}

InternalPuncture PunctureFrom(std::span<const double> p) {
  return {p[0], p[1], p[2], p[3], p[4], p[5]};
}

/// All events and the profile, fitted together. Parameters: the profile's forces, then the events'.
class EventFit {
 public:
  using Law = std::function<double(std::span<const double> parameters, double depth_mm)>;

  EventFit(const StrainedRows& rows, const ResistanceProfile& profile, std::size_t per_event,
           Law law)
      : rows_(rows), knots_(profile.depth_mm), per_event_(per_event), law_(std::move(law)) {
    parameters_ = ProfileParameters(profile);
  }

  void Add(std::initializer_list<SeriesParameter> event) {
    parameters_.insert(parameters_.end(), event.begin(), event.end());
  }

  void Run() {
    const SeriesModel model =
        WholeModel(rows_, knots_, [this](std::span<const double> p, double d) {
          double sum = 0.0;
          for (std::size_t k = 0; k < p.size(); k += per_event_) sum += law_(p.subspan(k), d);
          return sum;
        });
    fit_ = FitSeries(model, rows_.force_n, parameters_, {.most_iterations = 25});
  }

  /// Takes out one event and fits the others again, if Akaike's criterion is then no worse.
  bool TryWithout(std::size_t first) {
    EventFit other = *this;
    for (std::size_t k = 0; k < parameters_.size(); ++k) {
      other.parameters_[k].start =
          std::clamp(fit_.parameters[k], parameters_[k].low, parameters_[k].high);
    }
    const auto begin = other.parameters_.begin() + static_cast<std::ptrdiff_t>(first);
    other.parameters_.erase(begin, begin + static_cast<std::ptrdiff_t>(per_event_));
    other.Run();
    const double samples = std::max(fit_.effective_samples, 30.0);
    const double worse = 2.0 * samples * std::log(other.fit_.rms_n / std::max(1e-12, fit_.rms_n));
    if (worse > 2.0 * static_cast<double>(per_event_)) return false;
    parameters_ = std::move(other.parameters_);
    fit_ = std::move(other.fit_);
    return true;
  }

  /// Index of each event's first parameter.
  std::vector<std::size_t> Events() const {
    std::vector<std::size_t> first;
    for (std::size_t k = knots_.size(); k < parameters_.size(); k += per_event_) first.push_back(k);
    return first;
  }

  std::span<const double> Of(std::size_t first) const {
    return std::span(fit_.parameters).subspan(first, per_event_);
  }
  const SeriesFit& fit() const { return fit_; }
  std::vector<double> ProfileForces() const {
    return {fit_.parameters.begin(),
            fit_.parameters.begin() + static_cast<std::ptrdiff_t>(knots_.size())};
  }

 private:
  const StrainedRows& rows_;
  std::vector<double> knots_;
  std::size_t per_event_;
  Law law_;
  std::vector<SeriesParameter> parameters_;
  SeriesFit fit_;
};

Estimate PeakOf(const EventFit& fit, std::size_t first) {
  const InternalPuncture law = PunctureFrom(fit.Of(first));
  Eigen::VectorXd gradient = Eigen::VectorXd::Zero(fit.fit().covariance.rows());
  const double x = law.puncture_mm;
  const auto row = static_cast<Eigen::Index>(first);
  gradient(row + 1) = law.a1_n_per_mm + 2.0 * law.a2_n_per_mm2 * x;
  gradient(row + 2) = x;
  gradient(row + 3) = x * x;
  return fit.fit().Of(law.PeakN(), gradient);
}

/// Takes out events that the others explain as well: their peaks are not determined.
void Prune(EventFit& fit) {
  std::vector<double> kept;  // Places of events that must stay.
  for (int trial = 0; trial < kMostTrials; ++trial) {
    double most = 0.5;
    std::size_t worst = 0;
    for (const std::size_t first : fit.Events()) {
      const Estimate peak = PeakOf(fit, first);
      const double doubt = peak.standard_error / std::max(1e-9, peak.value);
      const bool stays = std::ranges::find(kept, fit.Of(first)[0]) != kept.end();
      if (doubt > most && !stays) {
        most = doubt;
        worst = first;
      }
    }
    if (worst == 0) return;
    const double place = fit.Of(worst)[0];
    if (!fit.TryWithout(worst)) kept.push_back(place);
  }
}

}  // namespace

std::vector<FoundPuncture> FindInternalPunctures(const StrainedRows& rows,
                                                 const SearchLimits& limits,
                                                 ResistanceProfile& profile) {
  FitProfile(rows, {}, profile);
  if (rows.depth_mm.size() < 60) return {};
  EventKind kind;
  kind.positive = 2;
  kind.parameters = 6.0;
  kind.shape_at = [&](const std::vector<double>& place) { return PunctureShape(rows, place); };
  kind.places = [&](const Eigen::VectorXd& left) {
    std::vector<std::vector<double>> places;
    for (const std::size_t peak : Peaks(rows, left)) {
      for (const double rise : kRisesMm) {
        if (rows.depth_mm[peak] - rise < rows.depth_mm.front() - 0.1) break;
        for (const double recovery : kRecoveriesMm) {
          places.push_back({rows.depth_mm[peak], rise, recovery});
        }
      }
    }
    return places;
  };
  kind.size_n = [](const EventChoice& c) {
    const double rise = c.place[1];
    return std::max(std::abs((c.factor(0) + c.factor(1) * rise) * rise), std::abs(c.factor(2)));
  };
  const std::vector<EventChoice> choices =
      FindEvents(rows, kind, limits.least_n, limits.most_events, profile);
  if (choices.empty()) return {};
  EventFit fit(rows, profile, 6, [](std::span<const double> p, double depth_mm) {
    return PunctureFrom(p).ForceN(depth_mm);
  });
  for (const EventChoice& c : choices) {
    const double rise = c.place[1];
    const double contact = c.place[0] - rise;
    fit.Add({{"contact", contact, contact - 0.5 * rise - 0.2, contact + 0.5 * rise},
             {"puncture", rise, 0.3 * rise, 2.0 * rise},
             {"a1", std::clamp(c.factor(0), 0.0, 50.0), 0.0, 100.0},
             {"a2", std::clamp(c.factor(1), 0.0, 50.0), 0.0, 100.0},
             {"recovery", std::clamp(c.place[2], 0.02, 10.0), 0.02, 10.0},
             {"step", std::clamp(c.factor(2), -20.0, 20.0), -50.0, 50.0}});
  }
  fit.Run();
  Prune(fit);
  profile.force_n = fit.ProfileForces();
  std::vector<FoundPuncture> found;
  for (const std::size_t first : fit.Events()) {
    found.push_back({PunctureFrom(fit.Of(first)), fit.fit().Bounded(first),
                     fit.fit().Bounded(first + 1), PeakOf(fit, first),
                     fit.fit().Bounded(first + 5)});
  }
  return found;
}

std::vector<FoundRelease> FindReleases(const StrainedRows& rows, const SearchLimits& limits,
                                       ResistanceProfile& profile) {
  FitProfile(rows, {}, profile);
  if (rows.depth_mm.size() < 60) return {};
  EventKind kind;
  kind.parameters = 3.0;
  kind.shape_at = [&](const std::vector<double>& place) { return ReleaseShape(rows, place); };
  kind.places = [&](const Eigen::VectorXd&) {
    std::vector<std::vector<double>> places;
    double last_mm = 1e9;
    for (const double depth : rows.depth_mm) {
      if (std::abs(depth - last_mm) < 0.5) continue;
      last_mm = depth;
      for (const double width : kWidthsMm) places.push_back({depth, width});
    }
    return places;
  };
  kind.size_n = [](const EventChoice& c) { return std::abs(c.factor(0)); };
  const std::vector<EventChoice> choices =
      FindEvents(rows, kind, limits.least_n, limits.most_events, profile);
  if (choices.empty()) return {};
  EventFit fit(rows, profile, 3, [](std::span<const double> p, double depth_mm) {
    return Release{p[0], p[1], p[2]}.ForceN(depth_mm);
  });
  const auto [low_mm, high_mm] = std::ranges::minmax(rows.depth_mm);
  for (const EventChoice& c : choices) {
    const double at = std::clamp(c.place[0], low_mm, high_mm);
    fit.Add({{"at", at, std::max(low_mm - 0.1, at - 2.0), std::min(high_mm + 0.1, at + 2.0)},
             {"width", std::clamp(c.place[1], 0.02, 4.0), 0.02, 4.0},
             {"step", std::clamp(c.factor(0), -20.0, 20.0), -50.0, 50.0}});
  }
  fit.Run();
  profile.force_n = fit.ProfileForces();
  std::vector<FoundRelease> found;
  for (const std::size_t first : fit.Events()) {
    const std::span<const double> p = fit.Of(first);
    found.push_back({{p[0], p[1], p[2]}, fit.fit().Bounded(first), fit.fit().Bounded(first + 2)});
  }
  return found;
}

}  // namespace acus::fitting
