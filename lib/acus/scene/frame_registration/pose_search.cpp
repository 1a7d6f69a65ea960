#include "acus/scene/frame_registration/pose_search.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/core/optim.hpp>
#include <vector>

#include "acus/base/core/error.h"
#include "acus/base/core/parallel.h"
#include "acus/base/core/random.h"

namespace acus::frame_registration {
namespace {

/// Residuals of adjacent grey levels are correlated, since the model does not contain their cause:
/// this share of the independent values counts. Chosen so that the stated standard deviations agree
/// with the errors on recorded frames (docs/models/frame_registration.md).
constexpr double kCountingShare = 0.3;
constexpr std::size_t kKeptCoarse = 12;
constexpr std::size_t kKeptFine = 4;
/// A frame of which less is explained shows something else.
constexpr double kLeastSimilarity = 0.02;
/// Steps of the second derivatives, in mm and deg: wide enough to average over voxels and pixels.
constexpr double kDerivativeStep = 1.0;
/// A pose with at least this log posterior relative to the best one's fits about as well.
constexpr double kRivalLog = 2.0;
constexpr double kRivalMm = 2.0;

using Matrix6 = Eigen::Matrix<double, 6, 6>;

struct Candidate {
  PoseChange change = PoseChange::Zero();
  double log_posterior = 0.0;
};

bool IsBetter(const Candidate& a, const Candidate& b) {
  return a.log_posterior > b.log_posterior;
}

/// Log posterior of a change of the start at one resolution, up to a constant.
class Posterior {
 public:
  Posterior(FrameSimilarity similarity, const Eigen::Isometry3d& start, double pivot_mm,
            double values, const SearchSettings& settings)
      : similarity_(std::move(similarity)),
        start_(start),
        pivot_mm_(pivot_mm),
        values_(values),
        settings_(settings) {}

  double Similarity(const PoseChange& change) {
    return similarity_.At(Changed(start_, change, pivot_mm_));
  }

  double At(const PoseChange& change) {
    const double residual = std::max(1e-6, 1.0 - Similarity(change));
    return -0.5 * (values_ * std::log(residual) +
                   change.head<3>().squaredNorm() / (settings_.start_mm * settings_.start_mm) +
                   change.tail<3>().squaredNorm() / (settings_.start_deg * settings_.start_deg));
  }

 private:
  FrameSimilarity similarity_;
  Eigen::Isometry3d start_;
  double pivot_mm_;
  double values_;
  SearchSettings settings_;
};

struct Minimised : cv::MinProblemSolver::Function {
  explicit Minimised(Posterior* of) : posterior(of) {}
  int getDims() const override { return 6; }
  double calc(const double* change) const override {
    return -posterior->At(Eigen::Map<const PoseChange>(change));
  }
  Posterior* posterior;
};

void Refine(Posterior& posterior, double step, int iterations, Candidate& candidate) {
  const auto solver = cv::DownhillSolver::create(cv::makePtr<Minimised>(&posterior));
  solver->setInitStep(cv::Mat(6, 1, CV_64F, cv::Scalar(step)));
  solver->setTermCriteria({cv::TermCriteria::MAX_ITER + cv::TermCriteria::EPS, iterations, 1e-4});
  cv::Mat change(1, 6, CV_64F);
  Eigen::Map<PoseChange>(change.ptr<double>()) = candidate.change;
  candidate.log_posterior = -solver->minimize(change);
  candidate.change = Eigen::Map<const PoseChange>(change.ptr<double>());
}

/// Calls work(posterior, candidate) for all; each posterior works on some of them. The results do
/// not depend on the number of posteriors.
template <typename Work>
void ForAll(std::vector<Posterior>& posteriors, std::vector<Candidate>& candidates,
            const Work& work) {
  const auto count = static_cast<int>(posteriors.size());
  ParallelFor(count, count, [&](int piece) {
    for (std::size_t n = static_cast<std::size_t>(piece); n < candidates.size();
         n += posteriors.size()) {
      work(posteriors[static_cast<std::size_t>(piece)], candidates[n]);
    }
  });
  std::ranges::stable_sort(candidates, IsBetter);
}

std::vector<Candidate> RandomCandidates(const SearchSettings& settings, std::uint64_t seed) {
  std::vector<Candidate> out(static_cast<std::size_t>(settings.samples));
  RandomStream random(seed, "poses of a frame");
  for (std::size_t n = 1; n < out.size(); ++n) {  // The first is the start itself.
    for (int k = 0; k < 6; ++k) {
      out[n].change[k] = random.Normal() * (k < 3 ? settings.start_mm : settings.start_deg);
    }
  }
  return out;
}

/// Gradient and negative second derivatives of the log posterior at a change.
struct Slopes {
  PoseChange gradient;
  Matrix6 curvature;
};

/// By central differences along each axis and each pair of axes.
Slopes SlopesAt(std::vector<Posterior>& posteriors, const PoseChange& middle) {
  std::vector<PoseChange> steps = {PoseChange::Zero()};
  for (int i = 0; i < 6; ++i) {
    for (int j = i; j < 6; ++j) {
      PoseChange step = PoseChange::Zero();
      step[i] = step[j] = kDerivativeStep;
      steps.push_back(step);
      steps.emplace_back(-step);
    }
  }
  std::vector<double> values(steps.size());
  const auto count = static_cast<int>(posteriors.size());
  ParallelFor(count, count, [&](int piece) {
    const auto first = static_cast<std::size_t>(piece);
    for (std::size_t n = first; n < steps.size(); n += posteriors.size()) {
      values[n] = posteriors[first].At(middle + steps[n]);
    }
  });
  Slopes out;
  Matrix6 along;
  std::size_t next = 1;
  for (int i = 0; i < 6; ++i) {
    for (int j = i; j < 6; ++j, next += 2) {
      along(i, j) =
          (2.0 * values[0] - values[next] - values[next + 1]) / (kDerivativeStep * kDerivativeStep);
      if (i == j) out.gradient[i] = (values[next] - values[next + 1]) / (2.0 * kDerivativeStep);
    }
  }
  for (int i = 0; i < 6; ++i) {
    for (int j = i; j < 6; ++j) {
      out.curvature(i, j) = out.curvature(j, i) =
          i == j ? along(i, i) : 0.5 * (along(i, j) - along(i, i) - along(j, j));
    }
  }
  return out;
}

/// Inverse of the curvature, where no direction is less certain than it was at the start.
Matrix6 CovarianceOf(const Matrix6& curvature, const SearchSettings& settings) {
  PoseChange start_sd;
  start_sd << Eigen::Vector3d::Constant(settings.start_mm),
      Eigen::Vector3d::Constant(settings.start_deg);
  const Matrix6 scaled = start_sd.asDiagonal() * curvature * start_sd.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Matrix6> solver(scaled);
  const PoseChange variances = solver.eigenvalues().cwiseMax(1.0).cwiseInverse();
  return start_sd.asDiagonal() * solver.eigenvectors() * variances.asDiagonal() *
         solver.eigenvectors().transpose() * start_sd.asDiagonal();
}

/// The covariance at the best candidate, after one Newton step of it: the simplex converges slowly
/// in directions of low curvature.
Matrix6 Finish(std::vector<Posterior>& posteriors, const SearchSettings& settings,
               Candidate& best) {
  const Slopes slopes = SlopesAt(posteriors, best.change);
  const Matrix6 covariance = CovarianceOf(slopes.curvature, settings);
  Candidate next{.change = best.change + covariance * slopes.gradient};
  next.log_posterior = posteriors.front().At(next.change);
  if (IsBetter(next, best)) best = next;
  return covariance;
}

std::optional<double> RivalOf(const std::vector<Candidate>& sorted) {
  std::optional<double> rival;
  for (const Candidate& other : sorted) {
    if (other.log_posterior < sorted.front().log_posterior - kRivalLog) continue;
    const double mm = (other.change - sorted.front().change).head<2>().norm();
    if (mm > kRivalMm && mm > rival.value_or(0.0)) rival = mm;
  }
  return rival;
}

void Check(const SearchSettings& settings, const Eigen::Isometry3d& start) {
  ACUS_REQUIRE(settings.start_mm > 0.0 && settings.start_deg > 0.0,
               "the start's standard deviations are ", settings.start_mm, " mm and ",
               settings.start_deg, " deg; both must be above 0");
  ACUS_REQUIRE(settings.samples >= 1, "the number of poses to try is ", settings.samples,
               "; it must be at least 1");
  ACUS_REQUIRE(start.matrix().allFinite(), "the start has a value that is not finite");
}

}  // namespace

Eigen::Isometry3d Changed(const Eigen::Isometry3d& start, const PoseChange& change,
                          double pivot_mm) {
  const Eigen::Vector3d turn = change.tail<3>() * std::numbers::pi / 180.0;
  const Eigen::Translation3d to_pivot(0.0, pivot_mm, 0.0);
  Eigen::Isometry3d out = start * Eigen::Translation3d(change.head<3>()) * to_pivot;
  if (turn.norm() > 0.0) out = out * Eigen::AngleAxisd(turn.norm(), turn.normalized());
  return out * to_pivot.inverse();
}

std::array<bool, 6> FramePose::determined(const SearchSettings& settings) const {
  std::array<bool, 6> out{};
  for (int k = 0; k < 6; ++k) {
    out[static_cast<std::size_t>(k)] =
        sd[k] < 0.5 * (k < 3 ? settings.start_mm : settings.start_deg);
  }
  return out;
}

FramePose FindFramePose(const image::GrayImage& recorded, const acoustics::Probe& probe,
                        const SimulatedTissue& simulated, const Eigen::Isometry3d& start,
                        const SearchSettings& settings, const RunContext& context) {
  Check(settings, start);
  const double pivot_mm = 0.5 * probe.depth_mm;
  double values = 0.0;
  const auto posteriors_at = [&](const Resolution& resolution) {
    std::vector<Posterior> out;
    for (int n = 0; n < context.num_threads; ++n) {
      FrameSimilarity similarity(recorded, probe, simulated, resolution);
      if (values == 0.0) values = kCountingShare * similarity.independent_values();
      out.emplace_back(std::move(similarity), start, pivot_mm, values, settings);
    }
    return out;
  };
  std::vector<Posterior> fine = posteriors_at(FineResolution(probe));
  context.Checkpoint("trying poses", 0.0);
  std::vector<Posterior> coarse = posteriors_at(CoarseResolution(probe));
  std::vector<Candidate> candidates = RandomCandidates(settings, context.seed);
  ForAll(coarse, candidates, [](Posterior& p, Candidate& c) { c.log_posterior = p.At(c.change); });
  candidates.resize(std::min(candidates.size(), kKeptCoarse));
  context.Checkpoint("refining poses", 0.4);
  ForAll(coarse, candidates, [](Posterior& p, Candidate& c) { Refine(p, 1.5, 150, c); });
  candidates.resize(std::min(candidates.size(), kKeptFine));
  context.Checkpoint("refining poses", 0.7);
  ForAll(fine, candidates, [](Posterior& p, Candidate& c) {
    Refine(p, 2.0, 300, c);
    Refine(p, 1.0, 300, c);
    Refine(p, 0.3, 200, c);  // A simplex may shrink too early: it starts again.
  });
  context.Checkpoint("uncertainty", 0.95);
  FramePose out;
  out.covariance = Finish(fine, settings, candidates.front());
  out.change = candidates.front().change;
  out.ct_from_probe = Changed(start, out.change, pivot_mm);
  out.similarity = fine.front().Similarity(out.change);
  out.start_similarity = fine.front().Similarity(PoseChange::Zero());
  if (out.similarity < kLeastSimilarity) {
    throw NoAnswerError(Message("the best simulated image explains ", out.similarity,
                                " of the frame's local variance, less than ", kLeastSimilarity,
                                "; check the start, the probe, and that the patient has "
                                "tissue there (--background for a surface of bone alone)"));
  }
  out.sd = out.covariance.diagonal().cwiseSqrt();
  out.rival_mm = RivalOf(candidates);
  return out;
}

}  // namespace acus::frame_registration
