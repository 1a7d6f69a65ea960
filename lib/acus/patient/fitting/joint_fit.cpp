#include "acus/patient/fitting/joint_fit.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

#include "acus/base/core/error.h"
#include "acus/base/math/distributions.h"
#include "acus/base/math/statistics.h"
#include "acus/patient/fitting/depth_bins.h"
#include "acus/patient/fitting/joint_contact.h"
#include "acus/patient/fitting/least_squares.h"
#include "acus/patient/fitting/shared_fit.h"

namespace acus::fitting {
namespace {

constexpr int kKnots[] = {2, 3, 4, 6, 8, 10, 12, 16, 20, 30, 40, 60};
constexpr double kFinestMm = 1.0;  // Least distance of knots.
constexpr double kStepS = 0.02;    // Means over so long.
constexpr double kBinMm = 0.1;
constexpr std::size_t kMostBins = 20000;

using Recordings = std::vector<JointRecording>;

double MedianOver(const Recordings& recordings,
                  const std::function<double(const MechanicalModel&)>& value) {
  std::vector<double> values;
  for (const JointRecording& r : recordings) values.push_back(value(r.fit->constant));
  return math::Median(values);
}

/// All but the profiles: medians. The depths that all reach.
MechanicalModel MedianModel(const Recordings& recordings) {
  const auto median = [&](auto member) {
    return MedianOver(recordings, [&](const MechanicalModel& m) { return m.*member; });
  };
  MechanicalModel model;
  model.buildup_in_mm = median(&MechanicalModel::buildup_in_mm);
  model.buildup_out_mm = median(&MechanicalModel::buildup_out_mm);
  model.reference_mm_per_s = median(&MechanicalModel::reference_mm_per_s);
  model.surface_mm = median(&MechanicalModel::surface_mm);
  // Shares and times belong together: those of the recordings with the usual number of branches.
  std::array<int, MechanicalModel::kMostBranches + 1> having{};
  for (const JointRecording& r : recordings) {
    ++having[static_cast<std::size_t>(r.fit->relaxing_branches)];
  }
  const auto usual = std::ranges::max_element(having) - having.begin();
  Recordings alike = recordings;
  std::erase_if(alike, [&](const JointRecording& r) { return r.fit->relaxing_branches != usual; });
  for (std::size_t k = 0; k < MechanicalModel::kMostBranches; ++k) {
    model.relaxing_share[k] =
        MedianOver(alike, [k](const MechanicalModel& m) { return m.relaxing_share[k]; });
    model.relaxation_s[k] =
        MedianOver(alike, [k](const MechanicalModel& m) { return m.relaxation_s[k]; });
  }
  double sum = 0.0;
  for (const double share : model.relaxing_share) sum += share;
  for (double& share : model.relaxing_share) share /= std::max(1.0, sum);
  return model;
}

std::vector<double> EvenKnots(double first_mm, double last_mm, int count) {
  std::vector<double> knots;
  for (int k = 0; k < count; ++k) {
    knots.push_back(first_mm + (last_mm - first_mm) * k / (count - 1));
  }
  return knots;
}

/// One recording's least squares for one set of knots: normal matrix, right side, squares, per row.
struct Normal {
  Eigen::MatrixXd matrix;
  Eigen::VectorXd right;
  double squares = 0.0;

  double Squares(const std::vector<double>& forces) const {
    const Eigen::Map<const Eigen::VectorXd> f(forces.data(),
                                              static_cast<Eigen::Index>(forces.size()));
    return std::max(0.0, squares - 2.0 * f.dot(right) + f.dot(matrix * f));
  }
};

Normal NormalOf(const StrainedRows& rows, const std::vector<double>& knots) {
  const Eigen::MatrixXd columns = ProfileColumns(rows, knots);
  const auto n = static_cast<double>(rows.depth_mm.size());
  const Eigen::Map<const Eigen::VectorXd> force(rows.force_n.data(),
                                                static_cast<Eigen::Index>(rows.force_n.size()));
  return {columns.transpose() * columns / n, columns.transpose() * force / n,
          force.squaredNorm() / n};
}

std::vector<double> Solve(const std::vector<Normal>& normals, std::size_t without) {
  Eigen::MatrixXd matrix =
      Eigen::MatrixXd::Zero(normals[0].matrix.rows(), normals[0].matrix.cols());
  Eigen::VectorXd right = Eigen::VectorXd::Zero(matrix.rows());
  for (std::size_t k = 0; k < normals.size(); ++k) {
    if (k == without) continue;
    matrix += normals[k].matrix;
    right += normals[k].right;
  }
  return SolveProfile(matrix, right);
}

/// A profile with one number of knots, and how badly each recording is foretold by the others.
struct Choice {
  ResistanceProfile profile;
  std::vector<double> left;  ///< Logarithm of the mean square, by recording.
};

Choice ChoiceOf(const std::vector<StrainedRows>& rows, const std::vector<double>& knots) {
  std::vector<Normal> normals;
  for (const StrainedRows& r : rows) normals.push_back(NormalOf(r, knots));
  Choice choice{{knots, Solve(normals, rows.size())}, {}};
  for (std::size_t k = 0; k < rows.size() && rows.size() > 1; ++k) {
    choice.left.push_back(std::log(normals[k].Squares(Solve(normals, k)) + 1e-12));
  }
  return choice;
}

/// Is `other` as good as `best`? Not if the paired differences say otherwise with 95 %.
bool IsAsGood(const Choice& other, const Choice& best) {
  if (best.left.size() < 3) return false;
  std::vector<double> worse;
  for (std::size_t k = 0; k < best.left.size(); ++k) worse.push_back(other.left[k] - best.left[k]);
  const double mean = math::Mean(worse);
  double squares = 0.0;
  for (const double w : worse) squares += (w - mean) * (w - mean);
  const auto n = static_cast<double>(worse.size());
  return mean <= math::StudentQuantile(0.95, n - 1.0) * std::sqrt(squares / (n - 1.0) / n);
}

/// The profile of one direction. Of all numbers of knots that foretell as well as the best one, the
/// finest: it is closest to what all have in common, and fails no single recording.
ResistanceProfile JointProfile(const std::vector<StrainedRows>& rows, int knots) {
  double first_mm = rows[0].depth_mm[0];
  double last_mm = first_mm;
  for (const StrainedRows& r : rows) {
    const auto [low, high] = std::ranges::minmax(r.depth_mm);
    first_mm = std::min(first_mm, low);
    last_mm = std::max(last_mm, high);
  }
  std::vector<Choice> choices;
  for (const int count : kKnots) {
    if (knots >= 2 ? count != knots : (rows.size() < 3 && count > 2)) continue;
    const bool is_fine = (last_mm - first_mm) / (count - 1) < kFinestMm;
    if (knots == 0 && is_fine && !choices.empty()) continue;
    choices.push_back(ChoiceOf(rows, EvenKnots(first_mm, last_mm, count)));
  }
  ACUS_ASSERT(!choices.empty());
  const auto best = std::ranges::min_element(
      choices, {}, [](const Choice& c) { return c.left.empty() ? 0.0 : math::Mean(c.left); });
  std::size_t chosen = static_cast<std::size_t>(best - choices.begin());
  for (std::size_t c = chosen + 1; c < choices.size(); ++c) {
    if (IsAsGood(choices[c], *best)) chosen = c;
  }
  return std::move(choices[chosen].profile);
}

/// Mean of other recordings' curves, each read at its nearest bins.
class MeanCurve {
 public:
  void Add(std::vector<double> x, std::vector<double> force) {
    if (x.size() >= 2) curves_.push_back({std::move(x), std::move(force)});
  }

  double At(double x) const {
    double sum = 0.0;
    for (const auto& [at, force] : curves_) {
      const auto above = std::upper_bound(at.begin(), at.end(), x);
      const std::size_t k =
          std::clamp<std::size_t>(static_cast<std::size_t>(above - at.begin()), 1, at.size() - 1);
      const double along = std::clamp((x - at[k - 1]) / (at[k] - at[k - 1]), 0.0, 1.0);
      sum += force[k - 1] + along * (force[k] - force[k - 1]);
    }
    return sum / static_cast<double>(curves_.size());
  }

  bool empty() const { return curves_.empty(); }

 private:
  std::vector<std::pair<std::vector<double>, std::vector<double>>> curves_;
};

double RmsAbout(const MeanCurve& mean, const std::vector<double>& x, const ForceCurve& curve,
                const SampleRange& range) {
  if (mean.empty() || range.size() == 0) return 0.0;
  double squares = 0.0;
  for (std::size_t i = range.begin; i < range.end; ++i) {
    const double left = mean.At(x[i]) - curve.force_n[i];
    squares += left * left;
  }
  return std::sqrt(squares / static_cast<double>(range.size()));
}

std::vector<double> SinceHold(const ForceCurve& curve, const CurvePhases& phases) {
  std::vector<double> since = curve.time_s;
  const double begin_s = curve.time_s[phases.advance.end - 1];
  for (double& t : since) t -= begin_s;
  return since;
}

PhaseRms MeanCurveRms(const JointRecording& left_out, const Recordings& others) {
  MeanCurve in;
  MeanCurve hold;
  MeanCurve out;
  for (const JointRecording& r : others) {
    DepthBins bins = BinByDepth(*r.curve, r.phases->advance, kBinMm, kMostBins);
    in.Add(bins.depth_mm, bins.force_n);
    bins = BinByDepth(*r.curve, r.phases->retract, kBinMm, kMostBins);
    out.Add(bins.depth_mm, bins.force_n);
    ForceCurve thin = Thinned(*r.curve, HoldRange(*r.phases), kStepS);
    for (double& t : thin.time_s) t -= r.curve->time_s[r.phases->advance.end - 1];
    hold.Add(thin.time_s, thin.force_n);
  }
  const ForceCurve& curve = *left_out.curve;
  const CurvePhases& phases = *left_out.phases;
  return {RmsAbout(in, curve.depth_mm, curve, phases.advance),
          RmsAbout(hold, SinceHold(curve, phases), curve, HoldRange(phases)),
          RmsAbout(out, curve.depth_mm, curve, phases.retract)};
}

/// Profiles that go with the model's build-up and relaxation.
void SetJointProfiles(const Recordings& recordings, int knots, MechanicalModel& joint) {
  std::vector<StrainedRows> in;
  std::vector<StrainedRows> out;
  for (const JointRecording& r : recordings) {
    MechanicalModel model = joint;
    model.offset_n = r.fit->constant.offset_n;
    model.drift_n_per_s = r.fit->constant.drift_n_per_s;
    model.start_s = r.fit->constant.start_s;
    in.push_back(PhaseRows(model, *r.curve, *r.phases, true, kStepS));
    out.push_back(PhaseRows(model, *r.curve, *r.phases, false, kStepS));
  }
  const auto is_short = [](const StrainedRows& rows) { return rows.depth_mm.size() < 20; };
  std::erase_if(in, is_short);
  std::erase_if(out, is_short);
  if (in.empty()) throw NoAnswerError("no recording has a usable insertion");
  joint.in = JointProfile(in, knots);
  joint.out = out.empty() ? joint.in : JointProfile(out, knots);
}

Recordings Usable(std::span<const JointRecording> recordings) {
  Recordings usable;
  for (const JointRecording& r : recordings) {
    if (r.IsUsable()) usable.push_back(r);
  }
  return usable;
}

}  // namespace

bool JointRecording::IsUsable() const {
  return fit->converged && phases->advance.size() > 60 && phases->retract.size() > 60;
}

JointModel FitJoint(std::span<const JointRecording> all, int knots) {
  const Recordings recordings = Usable(all);
  ACUS_ASSERT(!recordings.empty() && (knots == 0 || knots >= 2));
  MechanicalModel model = MedianModel(recordings);
  SetJointProfiles(recordings, knots, model);
  if (recordings.size() >= 2) {
    FitJointContact(recordings, model);
    SetJointProfiles(recordings, knots, model);
  }
  JointModel joint{std::move(model), 0, 0};
  joint.knots_in = static_cast<int>(joint.model.in.depth_mm.size());
  joint.knots_out = static_cast<int>(joint.model.out.depth_mm.size());
  return joint;
}

std::vector<Prediction> LeaveOneOut(std::span<const JointRecording> all) {
  const Recordings recordings = Usable(all);
  std::vector<Prediction> predictions;
  if (recordings.size() < 3) return predictions;
  for (std::size_t k = 0; k < recordings.size(); ++k) {
    Recordings others = recordings;
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(k));
    const JointRecording& left_out = recordings[k];
    const auto rms = [&](int knots) {
      MechanicalModel model = FitJoint(others, knots).model;
      model.offset_n = left_out.fit->constant.offset_n;
      model.start_s = left_out.fit->constant.start_s;
      return ReplayRms(model, *left_out.curve, *left_out.phases);
    };
    predictions.push_back({left_out.curve->name, rms(0), rms(2), MeanCurveRms(left_out, others)});
  }
  return predictions;
}

}  // namespace acus::fitting
