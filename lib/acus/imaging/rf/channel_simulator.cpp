#include "acus/imaging/rf/channel_simulator.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "acus/base/core/error.h"
#include "acus/base/core/parallel.h"

namespace acus::rf {
namespace {

using Complexf = std::complex<float>;

constexpr double kNearestMm = 0.1;
/// Pieces of work of one transmission. Fixed, so that sums have one order.
constexpr int kPieces = 16;

/// The path between an element and a scatterer.
struct Leg {
  double time_us = 0.0;
  double weight = 0.0;  ///< Directivity, spreading, attenuation beyond that of the band.
};

/// What one transmission sends back from one scatterer, as one piece of work reuses it.
class EchoWriter {
 public:
  EchoWriter(const Array& array, const PulseTable& table, const ChannelOptions& options,
             const TransmitTiming& timing)
      : array_(array), table_(table), options_(options), timing_(timing) {
    const int tail =
        static_cast<int>(std::ceil(options.transmit_tail_us * options.sampling_mhz)) + 2;
    length_ = table.length() + tail;
    legs_.resize(array.elements.size());
    real_.resize(static_cast<std::size_t>(length_) + 4);
    imaginary_.resize(real_.size());
    delayed_.resize(static_cast<std::size_t>(options.phases + 1) * length_);
  }

  /// Adds the echo to the traces of all elements; `out` holds elements x samples.
  void Add(const Scatterer& scatterer, float* out) {
    FindLegs(scatterer.position_mm);
    Transmit();
    Delay(static_cast<float>(scatterer.amplitude));
    for (std::size_t e = 0; e < legs_.size(); ++e) {
      if (legs_[e].weight > 0.0) Receive(legs_[e], out + e * options_.samples);
    }
  }

 private:
  void FindLegs(const Eigen::Vector2d& place_mm) {
    double shortest_mm = 1e300;
    for (const Element& element : array_.elements) {
      shortest_mm = std::min(shortest_mm, (place_mm - element.position_mm).norm());
    }
    band_ = table_.BandOf(2.0 * shortest_mm);
    const double frequency_mhz = table_.FrequencyOf(band_);
    const double neper_per_mm =
        frequency_mhz * NeperPerMhz(options_.attenuation_db_per_cm_mhz, 1.0);
    const double reference_mm = 0.5 * table_.PathOf(band_);
    for (std::size_t e = 0; e < legs_.size(); ++e) {
      const Eigen::Vector2d path_mm = place_mm - array_.elements[e].position_mm;
      const double length_mm = path_mm.norm();
      const double cos_angle =
          length_mm > 0.0 ? array_.elements[e].normal.dot(path_mm) / length_mm : 1.0;
      legs_[e].time_us = length_mm / options_.sound_speed_mm_per_us;
      legs_[e].weight = Directivity(array_.element_width_mm, frequency_mhz,
                                    options_.sound_speed_mm_per_us, cos_angle) /
                        std::max(length_mm, kNearestMm) *
                        std::exp(-neper_per_mm * (length_mm - reference_mm));
    }
  }

  double ArrivalUs(std::size_t e) const { return timing_.element_us()[e] + legs_[e].time_us; }

  /// The sum of all elements' waves at the scatterer, as an envelope from start_ on.
  void Transmit() {
    double first_us = 1e300;
    for (std::size_t e = 0; e < legs_.size(); ++e) first_us = std::min(first_us, ArrivalUs(e));
    start_us_ = std::floor((first_us - table_.half_length_us()) * options_.sampling_mhz) /
                options_.sampling_mhz;
    std::ranges::fill(real_, 0.0F);
    std::ranges::fill(imaginary_, 0.0F);
    for (std::size_t e = 0; e < legs_.size(); ++e) {
      const double late = (ArrivalUs(e) - first_us) / options_.transmit_tail_us;
      if (late >= 1.0 || legs_[e].weight <= 0.0) continue;
      const double taper = late < 0.5 ? 1.0 : 0.5 * (1.0 - std::cos(2.0 * std::numbers::pi * late));
      AddWave(ArrivalUs(e) - start_us_, taper * legs_[e].weight);
    }
  }

  void AddWave(double arrival_us, double weight) {
    const double at = (arrival_us - table_.half_length_us()) * options_.sampling_mhz;
    auto first = static_cast<int>(at);
    auto phase = static_cast<int>(std::lround((at - first) * table_.phases()));
    if (phase == table_.phases()) {
      phase = 0;
      ++first;
    }
    const auto envelope = table_.Envelope(band_, phase);
    const auto turn =
        Complexf(std::polar(weight, -2.0 * std::numbers::pi * table_.carrier_mhz() * arrival_us));
    float* re = real_.data() + first + 1;
    float* im = imaginary_.data() + first + 1;
    for (int j = 0; j < table_.length(); ++j) {
      re[j] += turn.real() * envelope[j].real() - turn.imag() * envelope[j].imag();
      im[j] += turn.real() * envelope[j].imag() + turn.imag() * envelope[j].real();
    }
  }

  /// The wave with its carrier, at all fractions of a sample: cubic (Lagrange) in the envelope.
  void Delay(float amplitude) {
    for (int phase = 0; phase <= options_.phases; ++phase) {
      const double x = 1.0 - static_cast<double>(phase) / options_.phases;
      const auto c0 = static_cast<float>(-x * (x - 1.0) * (x - 2.0) / 6.0);
      const auto c1 = static_cast<float>((x + 1.0) * (x - 1.0) * (x - 2.0) / 2.0);
      const auto c2 = static_cast<float>(-(x + 1.0) * x * (x - 2.0) / 2.0);
      const auto c3 = static_cast<float>((x + 1.0) * x * (x - 1.0) / 6.0);
      float* out = delayed_.data() + static_cast<std::size_t>(phase) * length_;
      const double step = 2.0 * std::numbers::pi * table_.carrier_mhz() / options_.sampling_mhz;
      // (k - phase / phases) samples after the start; sample k lies between real_[k] and [k + 1].
      std::complex<double> carrier = std::polar(1.0, step * (x - 1.0));
      const std::complex<double> turn = std::polar(1.0, step);
      for (int k = 0; k < length_; ++k) {
        const float* re = real_.data() + std::max(0, k - 1);
        const float* im = imaginary_.data() + std::max(0, k - 1);
        const float a = c0 * re[0] + c1 * re[1] + c2 * re[2] + c3 * re[3];
        const float b = c0 * im[0] + c1 * im[1] + c2 * im[2] + c3 * im[3];
        out[k] = k == 0 ? 0.0F
                        : amplitude * (static_cast<float>(carrier.real()) * a -
                                       static_cast<float>(carrier.imag()) * b);
        carrier *= turn;
      }
    }
  }

  void Receive(const Leg& leg, float* trace) const {
    const double at = (start_us_ + leg.time_us - options_.start_us) * options_.sampling_mhz;
    if (!(at > -length_ - 1.0 && at < options_.samples)) return;
    const double whole = std::floor(at);
    const double phase = (at - whole) * options_.phases;
    const int lower = std::min(static_cast<int>(phase), options_.phases - 1);
    const auto b = static_cast<float>(leg.weight * (phase - lower));
    const float a = static_cast<float>(leg.weight) - b;
    const auto first = static_cast<int>(whole);
    const float* w0 = delayed_.data() + static_cast<std::size_t>(lower) * length_;
    const float* w1 = w0 + length_;
    const int begin = std::max(0, -first);
    const int end = std::min(length_, options_.samples - first);
    for (int k = begin; k < end; ++k) trace[first + k] += a * w0[k] + b * w1[k];
  }

  const Array& array_;
  const PulseTable& table_;
  const ChannelOptions& options_;
  const TransmitTiming& timing_;
  int length_ = 0;
  int band_ = 0;
  double start_us_ = 0.0;
  std::vector<Leg> legs_;
  std::vector<float> real_;  ///< Sample k of the envelope is at k + 1.
  std::vector<float> imaginary_;
  std::vector<float> delayed_;  ///< phases + 1 waves of length_.
};

void RequireIn(double value, double low, double high, const char* what) {
  ACUS_REQUIRE(value >= low && value <= high, "channel data: ", what, " is ", value,
               "; it must be between ", low, " and ", high);
}

}  // namespace

ChannelSimulator::ChannelSimulator(Array array, const Pulse& pulse, std::vector<Transmit> transmits,
                                   const ChannelOptions& options)
    : array_(std::move(array)), pulse_(pulse), transmits_(std::move(transmits)), options_(options) {
  ACUS_REQUIRE(!array_.elements.empty() && !transmits_.empty(),
               "channel data: ", array_.elements.size(), " elements and ", transmits_.size(),
               " transmissions; at least one of each is needed");
  RequireIn(options.sound_speed_mm_per_us, 0.1, 10.0, "the speed of sound in mm/us");
  RequireIn(options.attenuation_db_per_cm_mhz, 0.0, 20.0, "the attenuation in dB/(cm MHz)");
  RequireIn(pulse.frequency_mhz, 0.1, 100.0, "the centre frequency in MHz");
  RequireIn(pulse.fractional_bandwidth, 0.05, 1.5, "the fractional bandwidth");
  RequireIn(pulse.burst_cycles, 0.0, 32.0, "the burst in cycles");
  RequireIn(options.sampling_mhz, 2.0 * pulse.frequency_mhz, 1000.0, "the sampling rate in MHz");
  RequireIn(options.samples, 16, 1 << 20, "the number of samples");
  RequireIn(options.start_us, -1e4, 1e4, "the start in us");
  RequireIn(options.transmit_tail_us, 0.1, 100.0, "the tail of the transmission in us");
  RequireIn(options.phases, 1, 64, "the number of phases");
  RequireIn(options.pulse_half_us, 0.05, 20.0, "half of the length of the pulse in us");
}

ChannelData ChannelSimulator::Empty() const {
  ChannelData data{options_.samples,
                   static_cast<int>(array_.elements.size()),
                   static_cast<int>(transmits_.size()),
                   options_.sampling_mhz,
                   options_.start_us,
                   {}};
  data.Allocate();
  return data;
}

void ChannelSimulator::Add(const std::vector<Scatterer>& scatterers, int num_threads,
                           ChannelData& data) const {
  for (std::size_t i = 0; i < scatterers.size(); ++i) {
    ACUS_REQUIRE(scatterers[i].position_mm.allFinite() && std::isfinite(scatterers[i].amplitude),
                 "scatterer ", i, ": its place or amplitude is not a finite number");
  }
  const double longest_us = options_.start_us + options_.samples / options_.sampling_mhz;
  const PulseTable table(
      pulse_, {.sampling_mhz = options_.sampling_mhz,
               .attenuation_db_per_cm_mhz = options_.attenuation_db_per_cm_mhz,
               .longest_path_mm = std::max(0.0, longest_us * options_.sound_speed_mm_per_us),
               .half_length_us = options_.pulse_half_us});
  const std::size_t size = static_cast<std::size_t>(data.elements) * data.samples;
  std::vector<std::vector<float>> pieces(kPieces, std::vector<float>(size));
  for (int t = 0; t < data.transmits; ++t) {
    const TransmitTiming timing(array_, transmits_[static_cast<std::size_t>(t)],
                                options_.sound_speed_mm_per_us);
    ParallelFor(kPieces, num_threads, [&](int piece) {
      std::vector<float>& sum = pieces[static_cast<std::size_t>(piece)];
      std::ranges::fill(sum, 0.0F);
      EchoWriter writer(array_, table, options_, timing);
      for (std::size_t i = piece; i < scatterers.size(); i += kPieces) {
        writer.Add(scatterers[i], sum.data());
      }
    });
    float* out = data.values.data() + data.Offset(t, 0);
    for (const std::vector<float>& sum : pieces) {
      for (std::size_t i = 0; i < size; ++i) out[i] += sum[i];
    }
  }
}

}  // namespace acus::rf
