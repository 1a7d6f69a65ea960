// A recorded surrogate of breathing: a belt, a spirometer, a point on the skin.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "acus/physics/breathing/breath.h"

namespace acus::breathing {

/// How to read a file of a signal.
struct SignalFileOptions {
  /// Column of a CSV with a header; or the number, from 0, of one without. Empty: the first that
  /// is not the time.
  std::string column;
  /// Samples per second, for files without times; 0: the file says so itself.
  double rate_hz = 0.0;
};

/// A signal at equal steps.
struct BreathSignal {
  double start_s = 0.0;
  double step_s = 0.0;
  std::vector<double> level;

  double duration_s() const { return step_s * static_cast<double>(level.size() - 1); }
};

/// Reads CSV with a column time_s, or numbers in columns (spaces or commas) without a header whose
/// rate is in a comment ("Sampling Rate (Hz):= 1000") or in the options.
/// @throws InputError if the file is not readable, has fewer than 16 samples, values that are not
///     finite, times that do not increase or leave gaps, or a signal that never changes.
BreathSignal ReadBreathSignal(const std::filesystem::path& path, const SignalFileOptions& options);

struct RecordedBreathSettings {
  /// Standard deviation of the Gaussian that smooths the signal and makes its derivative.
  double smoothing_s = 0.15;
  /// After its end, the recording begins again, faded over two seconds; otherwise it is held.
  bool repeat = false;
};

/// A recording as breath at any time. The cycle runs from one inspiration (a maximum of the
/// signal) to the next.
class RecordedBreath {
 public:
  /// @throws InputError if fewer than two breaths are found.
  RecordedBreath(const BreathSignal& signal, const RecordedBreathSettings& settings);

  /// Time 0 is the recording's beginning. Linear between samples. Allocates nothing.
  Breath At(double time_s) const noexcept;

  int num_breaths() const { return static_cast<int>(peaks_.size()) - 1; }
  double duration_s() const { return step_s_ * static_cast<double>(level_.size() - 1); }
  /// Mean length of a breath.
  double period_s() const {
    return step_s_ * static_cast<double>(peaks_.back() - peaks_.front()) / num_breaths();
  }
  /// With this recording's median levels at the ends of inspiration and expiration as 1 and 0.
  Breath Normalised(const Breath& breath) const noexcept;

  /// Median levels at the ends of inspiration and of expiration.
  double inspiration_level() const { return inspiration_level_; }
  double expiration_level() const { return expiration_level_; }

 private:
  void FindBreaths();
  double CycleAt(double sample) const noexcept;

  double step_s_ = 0.0;
  bool repeat_ = false;
  std::vector<double> level_;
  std::vector<double> level_per_s_;
  std::vector<std::size_t> peaks_;  ///< Samples of end inspiration.
  double inspiration_level_ = 1.0;
  double expiration_level_ = 0.0;
};

}  // namespace acus::breathing
