#include "acus/assess/tuning/series.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "acus/assess/regression/comparison/image_difference.h"
#include "acus/base/core/atomic_file.h"
#include "acus/base/core/error.h"
#include "acus/base/core/provenance.h"

namespace acus::tuning {
namespace {

constexpr std::string_view kMagic = "acus-tradeoff-series/1\n";
constexpr std::size_t kSumSize = 64;

/// Numbers and bytes in their representation in memory: for reading by the machine that wrote it.
class Packer {
 public:
  template <typename T>
  void operator()(const T& value) {
    text_.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
  template <typename T>
  void operator()(const std::vector<T>& values) {
    (*this)(static_cast<std::uint64_t>(values.size()));
    text_.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
  }
  std::string& text() { return text_; }

 private:
  std::string text_;
};

/// The inverse of Packer. The check sum has been verified: sizes are right.
class Unpacker {
 public:
  explicit Unpacker(std::string_view text) : text_(text) {}
  template <typename T>
  void operator()(T& value) {
    ACUS_REQUIRE(text_.size() >= sizeof value, "series: ends too early");
    std::memcpy(&value, text_.data(), sizeof value);
    text_.remove_prefix(sizeof value);
  }
  template <typename T>
  void operator()(std::vector<T>& values) {
    std::uint64_t count = 0;
    (*this)(count);
    ACUS_REQUIRE(count <= text_.size() / sizeof(T), "series: ends too early");
    values.resize(count);
    if (count != 0) std::memcpy(values.data(), text_.data(), count * sizeof(T));
    text_.remove_prefix(count * sizeof(T));
  }

 private:
  std::string_view text_;
};

/// All of a series, in the order of the file.
template <typename Archive, typename AnySeries>
void VisitFields(Archive& archive, AnySeries& series) {
  archive(series.force_n);
  archive(series.first_s);
  archive(series.event_s);
  archive(series.width);
  archive(series.height);
  archive(series.pixels);
}

double LargestN(const Series& series) {
  double largest_n = 0.0;
  for (const auto& [x, y, z, px, py, pz] : series.force_n) {
    largest_n = std::max({largest_n, std::hypot(x, y, z), std::hypot(px, py, pz)});
  }
  return largest_n;
}

void CompareForces(const Series& run, const Series& reference, double around_event_s,
                   Measured& out) {
  double sum = 0.0;
  int count = 0;
  out.force_largest_n = 0.0;
  out.force_felt_n = LargestN(run);
  auto event = reference.event_s.begin();
  for (std::size_t n = 0; n < run.force_n.size(); ++n) {
    const double time_s = reference.first_s + 1e-3 * kCommonStepMs * static_cast<double>(n);
    while (event != reference.event_s.end() && *event < time_s - around_event_s - 1e-9) ++event;
    if (event != reference.event_s.end() && *event <= time_s + around_event_s + 1e-9) continue;
    double square = 0.0;
    for (std::size_t a = 0; a < 6; ++a) {
      const double off_n = run.force_n[n][a] - reference.force_n[n][a];
      square += off_n * off_n;
    }
    sum += square;
    ++count;
    out.force_largest_n = std::max(out.force_largest_n, std::sqrt(square));
  }
  out.force_rms_n = std::sqrt(sum / std::max(1, count));
}

void CompareImages(const Series& run, const Series& reference, Measured& out) {
  const std::size_t size = static_cast<std::size_t>(run.width) * run.height;
  double sum = 0.0;
  double ssim = 0.0;
  for (int n = 0; n < run.num_images(); ++n) {
    const auto view = [&](const Series& series) {
      return comparison::GrayView{
          series.width, series.height,
          std::span(series.pixels).subspan(size * static_cast<std::size_t>(n), size)};
    };
    const auto a = view(run);
    const auto b = view(reference);
    const double mean_square = comparison::MeanSquaredError(a, b);
    sum += mean_square;
    ssim += mean_square == 0.0 ? 1.0 : comparison::Ssim(a, b);
  }
  out.image_rms_grey = std::sqrt(sum / run.num_images());
  out.image_ssim = ssim / run.num_images();
}

}  // namespace

int Series::num_images() const {
  if (width == 0 || height == 0) return 0;
  return static_cast<int>(pixels.size() / (static_cast<std::size_t>(width) * height));
}

void Compare(const Series& run, const Series& reference, double around_event_s, Measured& out) {
  ACUS_REQUIRE(run.force_n.size() == reference.force_n.size(),
               "two settings have forces at different moments: ", run.force_n.size(), " and ",
               reference.force_n.size());
  ACUS_REQUIRE(run.width == reference.width && run.height == reference.height &&
                   run.num_images() == reference.num_images(),
               "two settings make images of different size or number: ", run.num_images(), " of ",
               run.width, " x ", run.height, " and ", reference.num_images(), " of ",
               reference.width, " x ", reference.height);
  if (!run.force_n.empty()) CompareForces(run, reference, around_event_s, out);
  if (run.num_images() > 0) CompareImages(run, reference, out);
}

void WriteSeries(const std::filesystem::path& path, const Series& series) {
  Packer body;
  VisitFields(body, series);
  std::string text = std::string(kMagic) + Sha256OfText(body.text());
  text += body.text();
  WriteTextFile(path, text);
}

std::optional<Series> ReadSeries(const std::filesystem::path& path) {
  if (!std::filesystem::is_regular_file(path)) return std::nullopt;
  const std::string text = ReadTextFile(path);
  const std::size_t begin = kMagic.size() + kSumSize;
  if (text.size() < begin || !text.starts_with(kMagic)) return std::nullopt;
  const std::string body = text.substr(begin);
  if (Sha256OfText(body) != text.substr(kMagic.size(), kSumSize)) return std::nullopt;
  Series series;
  Unpacker unpacker(body);
  VisitFields(unpacker, series);
  return series;
}

}  // namespace acus::tuning
