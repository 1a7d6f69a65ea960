// Fits of the 20 public insertions into human liver (de Jong & Dankelman 2017).
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "acus/base/config/json_file.h"
#include "acus/base/math/statistics.h"
#include "acus/patient/fitting/fit_models.h"
#include "acus/patient/fitting/fit_report.h"
#include "acus/patient/fitting/fitted_table.h"
#include "acus/patient/fitting/measured_fit.h"
#include "acus/physics/forces/models/measured_model.h"
#include "acus/physics/forces/models/needle_force.h"
#include "support/shared_data.h"

namespace acus::fitting {
namespace {

using forces::ReadForceCurve;
namespace fs = std::filesystem;

std::vector<std::filesystem::path> Recordings() {
  std::vector<std::filesystem::path> folders;
  if (const auto root = testing_support::SharedData("forces/human_liver")) {
    for (int i = 0; i < 40; i += 2) folders.push_back(*root / ("Data" + std::to_string(i)));
  }
  return folders;
}

/// Mean force while the needle is drawn back through depth +- 1 mm.
double RetractionForceN(const ForceCurve& curve, const CurvePhases& phases, double depth_mm) {
  std::vector<double> force;
  for (std::size_t i = phases.retract.begin; i < phases.retract.end; ++i) {
    if (std::abs(curve.depth_mm[i] - depth_mm) < 1.0) force.push_back(curve.force_n[i]);
  }
  return math::Mean(force);
}

TEST(HumanLiver, EveryRecordingHasItsPhasesAndAUsableFit) {
  const auto folders = Recordings();
  if (folders.empty()) GTEST_SKIP() << "test data forces/human_liver is not here";
  for (const auto& folder : folders) {
    SCOPED_TRACE(folder.filename().string());
    const ForceCurve curve = ReadForceCurve(folder);
    const PunctureCurveFit fit = FitPunctureCurve(curve);
    ASSERT_TRUE(fit.converged) << fit.message;

    // As described with the data: 5 mm/s in to 85 mm, about a minute of hold, out again.
    const CurvePhases& phases = fit.phases;
    EXPECT_NEAR(phases.advance_mm_per_s, 5.0, 0.1);
    EXPECT_NEAR(curve.depth_mm[phases.hold.begin], 85.0, 1.0);
    const double hold_s = curve.time_s[phases.hold.end] - curve.time_s[phases.hold.begin];
    EXPECT_TRUE(hold_s > 54.0 && hold_s < 63.0) << hold_s;
    EXPECT_TRUE(fit.starts_in_tissue);
    EXPECT_NEAR(fit.offset_n->value, 0.0, 0.01);
    // At rest the sensor has a standard deviation of 0.005 N; the drive's vibration adds to it.
    EXPECT_TRUE(phases.noise_n > 0.004 && phases.noise_n < 0.008) << phases.noise_n;

    // The law leaves less than a fifth of the rise's height (0.02 N at the smallest).
    EXPECT_GT(fit.puncture_n->low, 0.0);
    EXPECT_LT(fit.puncture_n->value, 3.5);
    EXPECT_LT(fit.rise_rms_n, std::max(0.02, 0.18 * fit.puncture_n->value));
    EXPECT_GE(fit.a1_n_per_mm->value, 0.0);
    EXPECT_GE(fit.a2_n_per_mm2->value, 0.0);

    // Friction against plain means at two depths.
    const double plain_n_per_mm =
        (RetractionForceN(curve, phases, 15.0) - RetractionForceN(curve, phases, 60.0)) / 45.0;
    EXPECT_NEAR(fit.friction_n_per_mm->value, plain_n_per_mm, 0.3 * plain_n_per_mm);

    // Half of the force relaxes within seconds.
    ASSERT_TRUE(fit.relaxation_fraction.has_value());
    EXPECT_TRUE(fit.relaxation_fraction->value > 0.35 && fit.relaxation_fraction->value < 0.7);
    EXPECT_TRUE(fit.relaxation_time_s->value > 0.3 && fit.relaxation_time_s->value < 3.0);
  }
}

TEST(HumanLiver, FitsTheSameBitsAgain) {
  const auto folders = Recordings();
  if (folders.empty()) GTEST_SKIP() << "test data forces/human_liver is not here";
  const ForceCurve curve = ReadForceCurve(folders.front());
  const auto a = FitPunctureCurve(curve).Estimates();
  const auto b = FitPunctureCurve(curve).Estimates();
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].second.value, b[i].second.value) << a[i].first;
    EXPECT_EQ(a[i].second.low, b[i].second.low) << a[i].first;
  }
}

/// All recordings with all models; fitted once for all tests below.
const std::vector<FittedCurve>& Fitted() {
  static const std::vector<FittedCurve> kFitted = [] {
    std::vector<FittedCurve> fitted;
    for (const auto& folder : Recordings()) {
      fitted.push_back(FitModelsTo(ReadForceCurve(folder), FitModels{}));
    }
    return fitted;
  }();
  return kFitted;
}

/// The best straight line over depth of the samples in `range`, by hand.
double LineRms(const ForceCurve& curve, const SampleRange& range) {
  double n = 0.0, x = 0.0, y = 0.0, xx = 0.0, xy = 0.0, yy = 0.0;
  for (std::size_t i = range.begin; i < range.end; ++i) {
    const double d = curve.depth_mm[i] - 40.0;
    const double f = curve.force_n[i];
    n += 1.0, x += d, y += f, xx += d * d, xy += d * f, yy += f * f;
  }
  const double sxx = xx - x * x / n, sxy = xy - x * y / n, syy = yy - y * y / n;
  return std::sqrt(std::max(0.0, syy - sxy * sxy / sxx) / n);
}

void GaussiansFollowEveryInsertion() {
  for (const FittedCurve& f : Fitted()) {
    SCOPED_TRACE(f.curve.name);
    ASSERT_TRUE(f.gaussians->converged);
    EXPECT_GE(f.gaussians->terms.size(), 8u);
    EXPECT_LE(f.gaussians->terms.size(), 12u);
    EXPECT_LE(f.gaussians->rms_n, 0.06);
    double squares = 0.0;
    const SampleRange& range = f.puncture.phases.advance;
    for (std::size_t i = range.begin; i < range.end; ++i) {
      squares += std::pow(SumN(f.gaussians->terms, f.curve.depth_mm[i]) - f.curve.force_n[i], 2);
    }
    EXPECT_NEAR(f.gaussians->rms_n, std::sqrt(squares / static_cast<double>(range.size())), 1e-9);
  }
}

void ConstantsAreAsGoodAsTheBestLines() {
  for (const FittedCurve& f : Fitted()) {
    SCOPED_TRACE(f.curve.name);
    ASSERT_TRUE(f.mechanical->converged) << f.mechanical->message;
    const CurvePhases& phases = f.puncture.phases;
    const PhaseRms rms = ReplayRms(f.mechanical->constant, f.curve, phases);
    EXPECT_LE(rms.insertion_n, 1.05 * LineRms(f.curve, phases.advance));
    EXPECT_LE(rms.retraction_n, 1.05 * LineRms(f.curve, phases.retract));
    EXPECT_EQ(f.mechanical->constant.in.depth_mm.size(), 2u);
    EXPECT_EQ(f.mechanical->constant.out.depth_mm.size(), 2u);
    EXPECT_LE(rms.hold_n, 0.10);
  }
}

void PuncturesAreFoundAndFitted() {
  int insertions = 0;
  int retractions = 0;
  for (const FittedCurve& f : Fitted()) {
    const PhaseRms rms = ReplayRms(f.mechanical->eventful, f.curve, f.puncture.phases);
    insertions += rms.insertion_n <= 0.10 ? 1 : 0;
    retractions += rms.retraction_n <= 0.10 ? 1 : 0;
    EXPECT_LE(rms.hold_n, 0.10) << f.curve.name;
    EXPECT_GE(f.mechanical->punctures.size(), 1u) << f.curve.name;
    EXPECT_LE(f.mechanical->punctures.size(), 16u) << f.curve.name;
    // The largest fall that the phases list is among what was found.
    const auto& events = f.puncture.phases.punctures;
    const auto largest = std::ranges::max_element(events, {}, &PunctureEvent::drop_n);
    const double at_mm = f.curve.depth_mm[largest->peak];
    const bool found = std::ranges::any_of(f.mechanical->punctures, [&](const FoundPuncture& p) {
      return std::abs(p.law.contact_mm + p.law.puncture_mm - at_mm) < 1.5;
    });
    EXPECT_TRUE(found || largest->drop_n < 0.2) << f.curve.name << " at " << at_mm;
  }
  EXPECT_GE(insertions, 15);
  EXPECT_GE(retractions, 15);
}

/// Each recording from the nine others of its liver; predicted once.
const std::vector<Prediction>& Predictions() {
  static const std::vector<Prediction> kPredictions = [] {
    std::vector<Prediction> predictions;
    for (const std::size_t liver : {0u, 1u}) {
      std::vector<JointRecording> recordings;
      for (std::size_t k = 10 * liver; k < 10 * liver + 10; ++k) {
        const FittedCurve& f = Fitted()[k];
        recordings.push_back({&f.curve, &f.puncture.phases, &*f.mechanical});
      }
      for (Prediction& p : LeaveOneOut(recordings)) predictions.push_back(std::move(p));
    }
    return predictions;
  }();
  return kPredictions;
}

void OthersForetellAsWellAsTheirMean() {
  ASSERT_EQ(Predictions().size(), Fitted().size());
  for (const Prediction& p : Predictions()) {
    EXPECT_LE(p.model.insertion_n, 1.1 * p.mean_curve.insertion_n) << p.name;
    EXPECT_LE(p.model.retraction_n, 1.1 * p.mean_curve.retraction_n) << p.name;
    EXPECT_GT(p.mean_curve.insertion_n, 0.03) << p.name;  // It is not the recording's own.
  }
}

/// RMS by phase of the force model "measured" along a recording's own depths, through its file.
PhaseRms MeasuredReplayRms(const FittedCurve& f) {
  const forces::MeasuredForces file =
      forces::MeasuredForcesFromJson(MeasuredJson({&f, 1}, 1.27), f.curve.name);
  const forces::NeedleProperties needle = {
      .name = "18G", .gauge = 18, .length_mm = 150.0, .beam = {.outer_diameter_mm = 1.27}};
  const auto table =
      forces::ReadForceTable(fs::path(ACUS_SOURCE_DIR) / "configs/forces/default.json");
  const forces::MeasuredModel model(table, needle, file.Law(f.curve.name), file.needle_diameter_mm);
  forces::MeasuredState state;
  const volume::Label liver = volume::LabelOf("liver");
  const CurvePhases& phases = f.puncture.phases;
  const std::size_t begin = phases.advance.begin;
  const double origin_mm = f.mechanical->eventful.in.depth_mm.front();
  const double before_s = f.curve.time_s[begin] - 1e-3;
  model.Step(state, {before_s, {0, 0, -1e-3}, Eigen::Vector3d::UnitZ(), 0, true});
  const SampleRange hold{phases.advance.end, phases.retract.begin};
  double squares[3] = {};
  for (std::size_t i = begin; i < phases.retract.end; ++i) {
    const double depth_mm = std::max(0.0, f.curve.depth_mm[i] - origin_mm);
    const auto force = model.Step(
        state, {f.curve.time_s[i], {0, 0, depth_mm}, Eigen::Vector3d::UnitZ(), liver, true});
    const double left = force.AxialN() + f.mechanical->eventful.offset_n - f.curve.force_n[i];
    squares[i < hold.begin ? 0 : i < hold.end ? 1 : 2] += left * left;
  }
  const auto rms = [&](int phase, const SampleRange& range) {
    return std::sqrt(squares[phase] / static_cast<double>(std::max<std::size_t>(1, range.size())));
  };
  return {rms(0, phases.advance), rms(1, hold), rms(2, phases.retract)};
}

void TheMeasuredModelReplaysEveryRecording() {
  for (const FittedCurve& f : Fitted()) {
    const PhaseRms rms = MeasuredReplayRms(f);
    std::printf("  replay of %-7s in %.3f, hold %.3f, out %.3f N\n", f.curve.name.c_str(),
                rms.insertion_n, rms.hold_n, rms.retraction_n);
    EXPECT_LE(rms.insertion_n, 0.10) << f.curve.name;
    EXPECT_LE(rms.hold_n, 0.15) << f.curve.name;
    EXPECT_LE(rms.retraction_n, 0.15) << f.curve.name;
  }
}

void NothingIsBelowItsBound() {
  for (const FittedCurve& f : Fitted()) {
    for (const auto& [name, estimate] : f.mechanical->estimates) {
      EXPECT_GE(estimate.low, 0.0) << f.curve.name << " " << name;
      EXPECT_GE(estimate.high, estimate.value) << f.curve.name << " " << name;
    }
    const auto fortmeier = Fortmeier(f);
    ASSERT_TRUE(fortmeier.has_value()) << f.curve.name;
    EXPECT_GE(fortmeier->cut_n.low, 0.0);
    EXPECT_GE(fortmeier->stiffness_n_per_mm.low, 0.0);
    EXPECT_FALSE(fortmeier->capsule_cut_n) << f.curve.name;  // The needle is inside from the start.
  }
}

/// The table of docs/models/force_fit.md.
void PrintTable() {
  for (std::size_t k = 0; k < Predictions().size(); ++k) {
    const FittedCurve& f = Fitted()[k];
    const MechanicalFit& m = *f.mechanical;
    const Prediction& p = Predictions()[k];
    std::printf(
        "| %s | %.3f | %.3f | %.2f | %.2f | %.3f | %zu | %.3f | %.3f | %.2f (%.2f) | %.2f (%.2f) "
        "|\n",
        f.curve.name.c_str(), f.gaussians->rms_n, m.line.insertion_n,
        m.constant_rms.insertion_n / m.line.insertion_n,
        m.constant_rms.retraction_n / m.line.retraction_n, m.eventful_rms.insertion_n,
        m.punctures.size(), m.eventful_rms.retraction_n, m.constant_rms.hold_n,
        p.model.insertion_n / p.mean_curve.insertion_n,
        p.two_knots.insertion_n / p.mean_curve.insertion_n,
        p.model.retraction_n / p.mean_curve.retraction_n,
        p.two_knots.retraction_n / p.mean_curve.retraction_n);
  }
}

/// Mean over the depths of an insertion through untouched tissue.
double MeanInN(const forces::MechanicalModel& law) {
  std::vector<double> force;
  for (double depth_mm = 10.0; depth_mm <= 80.0; depth_mm += 0.5) {
    force.push_back(law.ResistanceInN(depth_mm, -1e9));
  }
  return math::Mean(force);
}

/// The same of what was recorded.
double MeanInN(const FittedCurve& f) {
  std::vector<double> force;
  const SampleRange& range = f.puncture.phases.advance;
  const double begin_mm = f.curve.depth_mm[range.begin];
  for (std::size_t i = range.begin; i < range.end; ++i) {
    const double depth_mm = f.curve.depth_mm[i] - begin_mm;
    if (depth_mm < 10.0 || depth_mm > 80.0) continue;
    force.push_back(f.curve.force_n[i] - f.puncture.offset_n->value);
  }
  return math::Mean(force);
}

/// From every other recording; 500 seeds against the ten others.
void SeedsScatterAsOtherRecordingsDo() {
  std::vector<FittedCurve> fitted;
  std::vector<double> own_n, others_n, drawn_n;
  for (std::size_t i = 0; i < Fitted().size(); ++i) {
    const bool is_other = i % 2 == 1;
    (is_other ? others_n : own_n).push_back(MeanInN(Fitted()[i]));
    if (!is_other) fitted.push_back(Fitted()[i]);
  }
  const forces::MeasuredForces forces =
      forces::MeasuredForcesFromJson(MeasuredJson(fitted, 1.27), "ten");
  for (std::uint64_t seed = 1; seed <= 500; ++seed) drawn_n.push_back(MeanInN(forces.Drawn(seed)));
  const double own_sd = math::StandardDeviation(own_n), drawn_sd = math::StandardDeviation(drawn_n),
               others_sd = math::StandardDeviation(others_n);
  std::printf(
      "  mean force in: fitted %.3f +- %.3f N, drawn %.3f +- %.3f N, held apart %.3f +- %.3f N\n",
      math::Mean(own_n), own_sd, math::Mean(drawn_n), drawn_sd, math::Mean(others_n), others_sd);
  EXPECT_NEAR(drawn_sd, own_sd, 0.2 * own_sd);
  EXPECT_NEAR(math::Mean(drawn_n), math::Mean(own_n), 0.05);
  // Ten recordings give an SD to 24 % (SD), a mean to a third of their SD.
  EXPECT_GT(drawn_sd, 0.5 * others_sd);
  EXPECT_LT(drawn_sd, 2.0 * others_sd);
  EXPECT_NEAR(math::Mean(drawn_n), math::Mean(others_n), 1.5 * others_sd);
}

/// One test, as each runs in a process of its own and the fits take a minute.
TEST(HumanLiver, AllModelsMeetTheirNumbers) {
  if (Recordings().empty()) GTEST_SKIP() << "test data forces/human_liver is not here";
  GaussiansFollowEveryInsertion();
  ConstantsAreAsGoodAsTheBestLines();
  PuncturesAreFoundAndFitted();
  OthersForetellAsWellAsTheirMean();
  TheMeasuredModelReplaysEveryRecording();
  NothingIsBelowItsBound();
  SeedsScatterAsOtherRecordingsDo();
  PrintTable();
}

std::vector<double> LayeredReplay(const forces::ForceTable& table, const FittedCurve& f) {
  return ReplayThroughTable(table, "liver", f.curve, f.puncture, 1.27);
}

/// Mean force while the needle has rested for so long, recorded or replayed.
struct HoldForce {
  const FittedCurve& f;
  const std::vector<double>& replay;

  double At(double from_s, double to_s, bool is_replayed) const {
    const CurvePhases& phases = f.puncture.phases;
    std::vector<double> force;
    for (std::size_t i = phases.hold.begin; i < phases.retract.begin; ++i) {
      const double rested_s = f.curve.time_s[i] - f.curve.time_s[phases.hold.begin];
      if (rested_s < from_s || rested_s >= to_s) continue;
      force.push_back(is_replayed ? replay[i - phases.advance.begin]
                                  : f.curve.force_n[i] - f.puncture.offset_n->value);
    }
    return math::Mean(force);
  }
};

/// The largest difference of what is left of the force that the hold begins with, at 1 to 50 s.
double WorstLeft(const forces::ForceTable& table, const FittedCurve& f) {
  const std::vector<double> replay = LayeredReplay(table, f);
  const HoldForce hold{f, replay};
  double worst = 0.0;
  std::printf("  %-7s recorded, replayed:", f.curve.name.c_str());
  for (const auto& [from_s, to_s] :
       {std::pair{0.0, 0.1}, {0.9, 1.1}, {4.5, 5.5}, {18.0, 22.0}, {48.0, 52.0}}) {
    const double recorded_n = hold.At(from_s, to_s, false);
    const double replayed_n = hold.At(from_s, to_s, true);
    std::printf(" %.2f %.2f N,", recorded_n, replayed_n);
    worst = std::max(worst, std::abs(recorded_n / hold.At(0.0, 0.1, false) -
                                     replayed_n / hold.At(0.0, 0.1, true)));
  }
  std::printf(" largest difference of the shares %.2f\n", worst);
  return worst;
}

/// Mean over recordings of the force in the insertion and the withdrawal by mm of depth, and in the
/// hold by the logarithm of the time (20 per decade from 0.02 s). NaN where there is none.
struct MeanForce {
  std::vector<double> in_n = std::vector<double>(90, NAN);
  std::vector<double> hold_n = std::vector<double>(70, NAN);
  std::vector<double> out_n = std::vector<double>(90, NAN);
};

/// @param force_of  a recording's force at a sample, without offset.
template <typename ForceOf>
MeanForce MeanForceOf(const std::vector<FittedCurve>& recordings, const ForceOf& force_of) {
  struct Bins {
    std::vector<double> sum, count;
  };
  const auto bins = [](std::size_t n) {
    return Bins{std::vector<double>(n), std::vector<double>(n)};
  };
  MeanForce mean;
  Bins in = bins(mean.in_n.size()), hold = bins(mean.hold_n.size()), out = bins(mean.out_n.size());
  for (std::size_t r = 0; r < recordings.size(); ++r) {
    const FittedCurve& f = recordings[r];
    const CurvePhases& phases = f.puncture.phases;
    for (std::size_t i = phases.advance.begin; i < phases.retract.end; ++i) {
      const bool is_held = i >= phases.hold.begin && i < phases.retract.begin;
      const double held_s = f.curve.time_s[i] - f.curve.time_s[phases.hold.begin];
      const double at = is_held ? 20.0 * std::log10(held_s / 0.02) : f.curve.depth_mm[i];
      Bins& into = is_held ? hold : i < phases.hold.begin ? in : out;
      if (!(at >= 0.0 && at < static_cast<double>(into.sum.size()))) continue;
      into.sum[static_cast<std::size_t>(at)] += force_of(r, i);
      into.count[static_cast<std::size_t>(at)] += 1.0;
    }
  }
  const auto fill = [](const Bins& from, std::vector<double>& to) {
    for (std::size_t n = 0; n < to.size(); ++n) {
      if (from.count[n] > 0.0) to[n] = from.sum[n] / from.count[n];
    }
  };
  fill(in, mean.in_n);
  fill(hold, mean.hold_n);
  fill(out, mean.out_n);
  return mean;
}

double RmsBetween(const std::vector<double>& a, const std::vector<double>& b) {
  std::vector<double> difference;
  for (std::size_t n = 0; n < a.size(); ++n) {
    if (!std::isnan(a[n]) && !std::isnan(b[n])) difference.push_back(a[n] - b[n]);
  }
  return math::RootMeanSquare(difference);
}

/// RMS by phase between the mean of recordings and that of a table's replays along their depths.
PhaseRms TableError(const char* name, const forces::ForceTable& table,
                    const std::vector<FittedCurve>& recordings) {
  std::vector<std::vector<double>> replays;
  for (const FittedCurve& f : recordings) replays.push_back(LayeredReplay(table, f));
  const MeanForce recorded = MeanForceOf(recordings, [&](std::size_t r, std::size_t i) {
    return recordings[r].curve.force_n[i] - recordings[r].puncture.offset_n->value;
  });
  const MeanForce replayed = MeanForceOf(recordings, [&](std::size_t r, std::size_t i) {
    return replays[r][i - recordings[r].puncture.phases.advance.begin];
  });
  const PhaseRms rms = {RmsBetween(recorded.in_n, replayed.in_n),
                        RmsBetween(recorded.hold_n, replayed.hold_n),
                        RmsBetween(recorded.out_n, replayed.out_n)};
  const auto left = [](const MeanForce& mean) { return mean.hold_n[67] / mean.hold_n[0]; };
  const auto pull_n = [](const MeanForce& mean) {
    return math::Mean(std::span(mean.out_n).first(80));
  };
  std::printf(
      "  %s: in %.3f, hold %.3f, out %.3f N; after 47 s %.2f of the force remains, recorded "
      "%.2f; withdrawal %.2f N, recorded %.2f\n",
      name, rms.insertion_n, rms.hold_n, rms.retraction_n, left(replayed), left(recorded),
      pull_n(replayed), pull_n(recorded));
  return rms;
}

void ExpectAsRecorded(const PhaseRms& rms) {
  EXPECT_LT(rms.insertion_n, 0.20);
  EXPECT_LT(rms.hold_n, 0.10);
  EXPECT_LT(rms.retraction_n, 0.12);
}

// Fitted to every other recording and written as a table, which is replayed as it is written; the
// others are what it is compared with. The row of the default table is from the same ten.
/// @param gsd  Of the ten recordings of a fit.
void ExpectTheirScatter(double gsd, const std::vector<FittedCurve>& others) {
  std::vector<const ForceCurve*> curves;
  std::vector<PunctureCurveFit> fits;
  for (const FittedCurve& f : others) {
    curves.push_back(&f.curve);
    fits.push_back(f.puncture);
  }
  const auto theirs = ScatterOfMeanForce(curves, fits);
  ASSERT_TRUE(theirs.has_value());
  std::printf("  geometric SD of the mean force: %.3f in the ten of the fit, %.3f in the others\n",
              gsd, *theirs);
  // The ratio of two standard deviations of ten each lies within these in 95 of 100 cases (F test).
  const double ratio = std::log(gsd) / std::log(*theirs);
  EXPECT_GT(ratio, 0.5);
  EXPECT_LT(ratio, 2.0);
}

TEST(HumanLiver, AFittedTableReplaysOtherRecordings) {
  const auto folders = Recordings();
  if (folders.empty()) GTEST_SKIP() << "test data forces/human_liver is not here";
  std::vector<FittedCurve> fitted, others;
  std::vector<PunctureCurveFit> punctures;
  for (std::size_t i = 0; i < folders.size(); ++i) {
    const bool is_other = i % 2 == 1;
    FittedCurve f =
        FitModelsTo(ReadForceCurve(folders[i]), {.gaussians = false, .mechanical = false});
    if (!is_other) punctures.push_back(f.puncture);
    (is_other ? others : fitted).push_back(std::move(f));
  }
  const fs::path base = fs::path(ACUS_SOURCE_DIR) / "configs/forces/default.json";
  std::vector<const ForceCurve*> curves;
  for (const FittedCurve& f : fitted) curves.push_back(&f.curve);
  const nlohmann::json document =
      FittedTable(config::ReadJson(base), "liver", curves, punctures, 1.27);
  for (const nlohmann::json& row : document.at("tissues")) {
    if (row.at("tissue") == "liver") std::printf("  %s\n", row.dump().c_str());
  }
  const forces::ForceTable table = forces::ForceTableFromJson(document, "fitted");
  TableError("fitted, on the ten of the fit", table, fitted);
  ExpectAsRecorded(TableError("fitted, on the ten others", table, others));
  const forces::ForceTable shipped = forces::ReadForceTable(base);
  ExpectAsRecorded(TableError("default.json, on the ten others", shipped, others));
  EXPECT_LT(shipped.tissue[volume::LabelOf("liver")].membrane.puncture_n, 2.0);
  ExpectTheirScatter(table.tissue[volume::LabelOf("liver")].between_patients_gsd, others);
  std::vector<double> worst;
  for (const FittedCurve& f : others) worst.push_back(WorstLeft(table, f));
  EXPECT_LT(math::Median(worst), 0.15);
  EXPECT_LT(*std::ranges::max_element(worst), 0.25);
}

}  // namespace
}  // namespace acus::fitting
