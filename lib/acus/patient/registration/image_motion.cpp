#include "acus/patient/registration/image_motion.h"

#include <Eigen/Dense>
#include <algorithm>

#include "acus/base/core/error.h"
#include "acus/base/math/statistics.h"
#include "acus/data/session/sequence_file.h"

namespace acus::registration {
namespace {

constexpr Eigen::Index kPeakRows = 5;

Eigen::VectorXd RowMeans(const std::vector<std::uint8_t>& pixels, std::size_t width,
                         std::size_t height) {
  Eigen::VectorXd means = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(height));
  const std::size_t first = width / 4, last = std::max(first + 1, width - width / 4);
  for (std::size_t row = 0; row < height; ++row) {
    double sum = 0.0;
    for (std::size_t column = first; column < last; ++column) sum += pixels[row * width + column];
    means[static_cast<Eigen::Index>(row)] = sum / static_cast<double>(last - first);
  }
  return means;
}

double PeakRow(const Eigen::VectorXd& profile) {
  Eigen::Index best = 0;
  profile.maxCoeff(&best);
  double sum = 0.0, moment = 0.0;
  const Eigen::Index last = std::min(profile.size() - 1, best + kPeakRows);
  for (Eigen::Index row = std::max<Eigen::Index>(0, best - kPeakRows); row <= last; ++row) {
    const double weight = std::max(0.0, profile[row]);
    sum += weight;
    moment += weight * static_cast<double>(row);
  }
  return sum > 0.0 ? moment / sum : static_cast<double>(best);
}

/// The row beside the largest peak, in the direction of `step`, where the profile crosses half its
/// height; the image's border where it does not.
double EdgeRow(const Eigen::VectorXd& profile, Eigen::Index step) {
  Eigen::Index row = 0;
  const double half = 0.5 * profile.maxCoeff(&row);
  while (row + step >= 0 && row + step < profile.size() && profile[row + step] > half) row += step;
  if (row + step < 0 || row + step >= profile.size()) return static_cast<double>(row);
  const double share = (profile[row] - half) / std::max(1e-12, profile[row] - profile[row + step]);
  return static_cast<double>(row) + static_cast<double>(step) * share;
}

}  // namespace

std::vector<MotionSignal> LineMotion(const std::filesystem::path& sequence,
                                     const RunContext& context) {
  session::SequenceFile file(sequence);
  const auto& header = file.header();
  ACUS_REQUIRE(file.has_images() && header.pixel_type == session::PixelType::kUint8 &&
                   header.bytes_per_frame() == header.width * header.height,
               sequence.string(), ": grey images of 8 bits are needed to follow a line in them");
  Eigen::MatrixXd profiles(static_cast<Eigen::Index>(header.height), 0);
  MotionSignal signal;
  for (std::size_t i = 0; i < file.num_frames(); ++i) {
    context.Checkpoint("Following the line",
                       static_cast<double>(i) / static_cast<double>(file.num_frames()));
    const auto time_ns = file.TimeNs(i);
    ACUS_REQUIRE(time_ns, sequence.string(), ": frame ", i, ": has no Timestamp");
    if (!signal.time_ns.empty() && *time_ns <= signal.time_ns.back()) continue;
    signal.time_ns.push_back(*time_ns);
    profiles.conservativeResize(Eigen::NoChange, profiles.cols() + 1);
    profiles.rightCols<1>() = RowMeans(file.ReadImage(i), header.width, header.height);
  }
  MotionSignal centre = signal, upper = signal, lower = signal, plain = signal;
  for (MotionSignal* one : {&centre, &upper, &lower, &plain})
    one->values.resize(profiles.cols(), 1);
  for (Eigen::Index i = 0; i < profiles.cols(); ++i) plain.values(i, 0) = PeakRow(profiles.col(i));
  for (Eigen::Index row = 0; row < profiles.rows(); ++row) {
    std::vector<double> over_time(static_cast<std::size_t>(profiles.cols()));
    Eigen::VectorXd::Map(over_time.data(), profiles.cols()) = profiles.row(row).transpose();
    if (!over_time.empty()) profiles.row(row).array() -= math::Median(over_time);
  }
  for (Eigen::Index i = 0; i < profiles.cols(); ++i) {
    centre.values(i, 0) = PeakRow(profiles.col(i));
    upper.values(i, 0) = EdgeRow(profiles.col(i), -1);
    lower.values(i, 0) = EdgeRow(profiles.col(i), 1);
  }
  return {centre, upper, lower, plain};
}

}  // namespace acus::registration
