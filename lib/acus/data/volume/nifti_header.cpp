#include "acus/data/volume/nifti_header.h"

#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <algorithm>
#include <atomic>
#include <cmath>
#include <fstream>
#include <optional>
#include <unistd.h>
#include <zlib.h>

#include "acus/base/core/error.h"
#include "acus/base/core/text_table.h"

namespace acus::volume {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kBytesOfVersion2 = 540;
constexpr double kReadByItk = 2e-6;        ///< Cosine between axes that ITK takes as 0.
constexpr double kMostSkewDeg = 1.0;       ///< More is no rounding.
constexpr double kSamePlaceVoxels = 0.1;   ///< Forms that differ by less are one.
constexpr double kSameFormSpacing = 0.01;  ///< Relative.

/// Lengths that the header gives in metres or micrometres are converted to mm.
void ConvertToMm(NiftiHeader& header) {
  constexpr std::uint8_t kLengthBits = 7, kMetres = 1, kMm = 2, kMicrometres = 3;
  const std::uint8_t units = header.bytes[123] & kLengthBits;
  if (units != kMetres && units != kMicrometres) return;
  header.mm_per_unit = units == kMetres ? 1e3 : 1e-3;
  const auto convert = [&](std::size_t from, std::size_t end) {
    for (std::size_t at = from; at < end; at += 4) {
      header.Set(at, static_cast<float>(header.At<float>(at) * header.mm_per_unit));
    }
  };
  convert(80, 92);    // pixdim.
  convert(268, 280);  // The origin of the qform.
  convert(280, 328);  // The rows of the sform.
  header.bytes[123] = static_cast<std::uint8_t>((header.bytes[123] & ~kLengthBits) | kMm);
}

/// A number of the header of NIfTI-2.
template <typename T>
T WideAt(const std::array<std::uint8_t, kBytesOfVersion2>& bytes, std::size_t offset,
         bool swapped) {
  std::array<std::uint8_t, sizeof(T)> raw{};
  for (std::size_t i = 0; i < sizeof(T); ++i) {
    raw[i] = bytes[offset + (swapped ? sizeof(T) - 1 - i : i)];
  }
  T value;
  std::memcpy(&value, raw.data(), sizeof(T));
  return value;
}

/// Offsets as in nifti1.h and nifti2.h.
NiftiHeader FromVersion2(const std::array<std::uint8_t, kBytesOfVersion2>& wide, bool swapped,
                         const fs::path& path) {
  NiftiHeader header;
  header.swapped = swapped;
  header.is_version_2 = true;
  const auto real = [&](std::size_t from, std::size_t to, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) {
      header.Set(to + 4 * i, static_cast<float>(WideAt<double>(wide, from + 8 * i, swapped)));
    }
  };
  const auto whole = [&](std::int64_t value, std::size_t to, const char* what) {
    ACUS_REQUIRE(value >= -32768 && value <= 32767, path.string(), ": ", what, " is ", value,
                 "; at most 32767 are read");
    header.Set(to, static_cast<std::int16_t>(value));
  };
  header.Set<std::int32_t>(0, 348);
  for (std::size_t i = 0; i < 8; ++i) {
    whole(WideAt<std::int64_t>(wide, 16 + 8 * i, swapped), 40 + 2 * i, "a size");
  }
  header.Set(70, WideAt<std::int16_t>(wide, 12, swapped));
  header.Set(72, WideAt<std::int16_t>(wide, 14, swapped));
  real(80, 56, 3);
  real(104, 76, 8);
  const auto offset = WideAt<std::int64_t>(wide, 168, swapped);
  header.Set(108, static_cast<float>(std::clamp<std::int64_t>(offset, 0, 1'000'000'000)));
  real(176, 112, 2);
  real(192, 124, 2);
  whole(WideAt<std::int32_t>(wide, 344, swapped), 252, "qform_code");
  whole(WideAt<std::int32_t>(wide, 348, swapped), 254, "sform_code");
  real(352, 256, 6);
  real(400, 280, 12);
  header.bytes[123] = static_cast<std::uint8_t>(WideAt<std::int32_t>(wide, 500, swapped) & 0xFF);
  whole(WideAt<std::int32_t>(wide, 504, swapped), 68, "intent_code");
  std::copy_n(wide.begin() + 240, 80, header.bytes.begin() + 148);  // The description.
  std::memcpy(&header.bytes[344], "n+1", 4);
  ConvertToMm(header);
  return header;
}

using Form = Eigen::Matrix<double, 3, 4>;

Form SformOf(const NiftiHeader& header) {
  Form form;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column) {
      form(row, column) = header.At<float>(280 + 16 * static_cast<std::size_t>(row) +
                                           4 * static_cast<std::size_t>(column));
    }
  }
  return form;
}

Form QformOf(const NiftiHeader& header) {
  const Eigen::Vector3d vector(header.At<float>(256), header.At<float>(260), header.At<float>(264));
  const double w = std::sqrt(std::max(0.0, 1.0 - vector.squaredNorm()));
  Eigen::Matrix3d axes =
      Eigen::Quaterniond(w, vector.x(), vector.y(), vector.z()).normalized().toRotationMatrix();
  if (header.At<float>(76) < 0.0F) axes.col(2) *= -1.0;
  Form form;
  for (int d = 0; d < 3; ++d) {
    form.col(d) = axes.col(d) * std::abs(header.At<float>(80 + 4 * static_cast<std::size_t>(d)));
    form(d, 3) = header.At<float>(268 + 4 * static_cast<std::size_t>(d));
  }
  return form;
}

/// The largest distance between the places of a corner voxel.
double CornerDistance(const Form& a, const Form& b, const Eigen::Array3d& size) {
  double largest = 0.0;
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Array3d at =
        (size - 1.0) * Eigen::Array3d(corner & 1, corner >> 1 & 1, corner >> 2);
    const Eigen::Vector4d index(at[0], at[1], at[2], 1.0);
    largest = std::max(largest, ((a - b) * index).norm());
  }
  return largest;
}

/// The form to go by, and whether another one places the voxels elsewhere.
struct ChosenForm {
  Form form;
  bool differs = false;
};

std::optional<ChosenForm> Choose(const NiftiHeader& header, const fs::path& path,
                                 std::vector<std::string>& notes) {
  const auto q_code = header.At<std::int16_t>(252);
  const auto s_code = header.At<std::int16_t>(254);
  if (q_code <= 0 && s_code <= 0) return {};
  if (s_code <= 0) return ChosenForm{.form = QformOf(header)};
  if (q_code <= 0) return ChosenForm{.form = SformOf(header)};
  const Form q = QformOf(header);
  const Form s = SformOf(header);
  const Eigen::Array3d q_mm = q.leftCols<3>().colwise().norm().transpose();
  const Eigen::Array3d s_mm = s.leftCols<3>().colwise().norm().transpose();
  ACUS_REQUIRE(((q_mm / s_mm - 1.0).abs() < kSameFormSpacing).all(), path.string(),
               ": its qform has voxels of ", q_mm.transpose(), " mm and its sform of ",
               s_mm.transpose(),
               " mm; one of them is wrong. Export it again, or set the code of "
               "the wrong one to 0");
  Eigen::Array3d size;
  for (std::size_t d = 0; d < 3; ++d) {
    size[static_cast<Eigen::Index>(d)] = header.At<std::int16_t>(42 + 2 * d);
  }
  const double apart_mm = CornerDistance(q, s, size);
  const bool take_q = q_code == 1 && s_code != 1;
  if (apart_mm <= kSamePlaceVoxels * s_mm.minCoeff()) return ChosenForm{.form = s};
  notes.push_back(Message("qform and sform place it differently, by up to ",
                          RoundedText(apart_mm, 3), " mm; the ", take_q ? "qform" : "sform",
                          " is used", take_q ? ", which is in scanner coordinates" : ""));
  return ChosenForm{.form = take_q ? q : s, .differs = true};
}

/// Writes a form without skew as qform, alone.
void SetForm(NiftiHeader& header, const Form& form) {
  const Eigen::Matrix3d linear = form.leftCols<3>();
  const Eigen::Vector3d spacing = linear.colwise().norm().transpose();
  const Eigen::Matrix3d unit = linear * spacing.cwiseInverse().asDiagonal();
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(unit, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Matrix3d axes = svd.matrixU() * svd.matrixV().transpose();
  const bool is_mirrored = axes.determinant() < 0.0;
  if (is_mirrored) axes.col(2) *= -1.0;
  Eigen::Quaterniond rotation(axes);
  if (rotation.w() < 0.0) rotation.coeffs() *= -1.0;
  header.Set(76, is_mirrored ? -1.0F : 1.0F);
  const Eigen::Vector3d vector = rotation.vec();
  for (std::size_t d = 0; d < 3; ++d) {
    const auto at = static_cast<Eigen::Index>(d);
    header.Set(80 + 4 * d, static_cast<float>(spacing[at]));
    header.Set(256 + 4 * d, static_cast<float>(vector[at]));
    header.Set(268 + 4 * d, static_cast<float>(form(at, 3)));
  }
  header.Set<std::int16_t>(252, 1);
  header.Set<std::int16_t>(254, 0);
}

/// The largest cosine between two axes.
double SkewOf(const Form& form, const fs::path& path) {
  const Eigen::Matrix3d linear = form.leftCols<3>();
  const Eigen::Vector3d spacing = linear.colwise().norm().transpose();
  ACUS_REQUIRE(spacing.minCoeff() > 1e-4, path.string(), ": its voxel axes have the lengths ",
               spacing.transpose(), " mm; the header is broken");
  const Eigen::Matrix3d unit = linear * spacing.cwiseInverse().asDiagonal();
  Eigen::Matrix3d gram = unit.transpose() * unit;
  gram.diagonal().setZero();
  return gram.cwiseAbs().maxCoeff();
}

Eigen::Array3d PixdimOf(const NiftiHeader& header) {
  return {header.At<float>(80), header.At<float>(84), header.At<float>(88)};
}

/// @throws InputError if pixdim has other spacings than the form: one of them was not changed when
///     the volume was resampled.
void RequireSameSpacing(const NiftiHeader& header, const Form& form, const fs::path& path) {
  const Eigen::Array3d stated_mm = PixdimOf(header).abs();
  const Eigen::Array3d form_mm = form.leftCols<3>().colwise().norm().transpose();
  ACUS_REQUIRE(((stated_mm / form_mm - 1.0).abs() < kSameFormSpacing).all(), path.string(),
               ": its pixdim has voxels of ", stated_mm.transpose(), " mm and its sform of ",
               form_mm.transpose(), " mm; one of them is wrong. Export it again");
}

/// Makes the header one of the part alone. Returns the bytes of the part, and those before it.
std::pair<z_off_t, z_off_t> SetPart(NiftiHeader& header, const NiftiPart& part) {
  z_off_t bytes = header.At<std::int16_t>(72) / 8 * part.channels;
  for (std::size_t d = 1; d <= 3; ++d) bytes *= header.At<std::int16_t>(40 + 2 * d);
  header.Set<std::int16_t>(40, part.channels == 1 ? 3 : 5);
  for (std::size_t d = 4; d <= 7; ++d) header.Set<std::int16_t>(40 + 2 * d, 1);
  if (part.channels > 1) {
    constexpr std::int16_t kVector = 1007;
    header.Set(50, static_cast<std::int16_t>(part.channels));
    header.Set(68, kVector);
  }
  return {bytes, bytes * part.volume};
}

std::unique_ptr<Temporary> CopyWith(NiftiHeader header, const NiftiPart& part,
                                    const fs::path& path) {
  static std::atomic<int> count{0};
  auto copy = std::make_unique<Temporary>(
      fs::temp_directory_path() / Message(".acus-", getpid(), "-", count.fetch_add(1), ".nii"));
  const auto [size, before] = SetPart(header, part);
  const auto begin = static_cast<z_off_t>(header.At<float>(108)) + before;
  header.Set(108, 352.0F);
  std::fill(header.bytes.begin() + 348, header.bytes.end(), std::uint8_t{0});
  gzFile in = gzopen(path.c_str(), "rb");  // Reads plain files too.
  ACUS_REQUIRE(in != nullptr, path.string(), ": cannot be read");
  std::ofstream out(copy->path(), std::ios::binary);
  out.write(reinterpret_cast<const char*>(header.bytes.data()),
            static_cast<std::streamsize>(header.bytes.size()));
  std::vector<char> block(1U << 20U);
  z_off_t left = gzseek(in, begin, SEEK_SET) == begin ? size : -1;
  while (left > 0) {
    const z_off_t wanted = std::min<z_off_t>(left, static_cast<z_off_t>(block.size()));
    const int got = gzread(in, block.data(), static_cast<unsigned>(wanted));
    if (got <= 0) break;
    out.write(block.data(), got);
    left -= got;
  }
  gzclose(in);
  out.close();
  ACUS_REQUIRE(left == 0 && out, path.string(), ": cannot be copied to ",
               fs::temp_directory_path().string(), "; is the disk full?");
  return copy;
}

}  // namespace

NiftiHeader ReadNiftiHeader(const fs::path& path) {
  std::array<std::uint8_t, kBytesOfVersion2> bytes{};
  gzFile file = gzopen(path.c_str(), "rb");  // Reads plain files too.
  ACUS_REQUIRE(file != nullptr, path.string(), ": cannot be read");
  const int got = gzread(file, bytes.data(), static_cast<unsigned>(bytes.size()));
  gzclose(file);
  ACUS_REQUIRE(got >= 348, path.string(), ": is cut off or no NIfTI file (", std::max(got, 0),
               " bytes of a 348-byte header)");
  const bool as_version_2 = std::memcmp(&bytes[4], "n+2", 3) == 0;
  if (as_version_2 && got == static_cast<int>(kBytesOfVersion2)) {
    const bool swapped = WideAt<std::int32_t>(bytes, 0, false) != 540;
    return FromVersion2(bytes, swapped, path);
  }
  NiftiHeader header;
  std::copy_n(bytes.begin(), std::min<std::size_t>(static_cast<std::size_t>(got), 352),
              header.bytes.begin());
  if (header.At<std::int32_t>(0) != 348) header.swapped = true;
  ACUS_REQUIRE(header.At<std::int32_t>(0) == 348 && std::memcmp(&header.bytes[344], "n+1", 3) == 0,
               path.string(), ": is not a single-file NIfTI (.nii or .nii.gz)");
  ConvertToMm(header);
  return header;
}

int NiftiVolumes(const NiftiHeader& header) {
  if (header.At<std::int16_t>(40) < 4) return 1;
  return std::max<int>(1, header.At<std::int16_t>(48));
}

std::unique_ptr<Temporary> ReadableNifti(const fs::path& path, const NiftiPart& part,
                                         std::vector<std::string>& notes) {
  NiftiHeader header = ReadNiftiHeader(path);
  const auto chosen = Choose(header, path, notes);
  const double skew = chosen ? SkewOf(chosen->form, path) : 0.0;
  const double skew_deg = std::asin(std::min(1.0, skew)) * 180.0 / M_PI;
  ACUS_REQUIRE(skew_deg <= kMostSkewDeg, path.string(), ": its voxel axes are up to ", skew_deg,
               " degrees from perpendicular (at most ", kMostSkewDeg,
               " are read); resample it to a rectangular grid first (for example in 3D Slicer)");
  const int volumes = NiftiVolumes(header);
  if (part.channels > 1 && volumes > 1) {
    notes.push_back("its vectors are its fourth dimension; they are taken as mm in LPS, as ITK's");
  }
  if (chosen) RequireSameSpacing(header, chosen->form, path);
  const bool has_lone_intercept = header.At<float>(112) == 0.0F && header.At<float>(116) != 0.0F;
  const bool is_readable = !header.is_version_2 && skew <= kReadByItk &&
                           !(chosen && chosen->differs) && volumes == 1 && !has_lone_intercept &&
                           header.mm_per_unit == 1.0 && (PixdimOf(header) > 0.0).all();
  if (is_readable) return nullptr;
  if (header.mm_per_unit != 1.0) {
    notes.push_back(Message("its lengths are in ", header.mm_per_unit > 1.0 ? "m" : "um",
                            ", as its header says; they are converted to mm"));
  }
  if (has_lone_intercept) {
    notes.push_back(Message("its slope is 0, so that its values are as stored; the intercept of ",
                            header.At<float>(116), " does not count"));
    header.Set(116, 0.0F);
  }
  for (std::size_t at = 80; at < 92; at += 4) header.Set(at, std::abs(header.At<float>(at)));
  if (skew > kReadByItk) {
    notes.push_back(Message("its voxel axes are up to ", skew_deg,
                            " degrees from perpendicular; the nearest rotation is used"));
  }
  if (chosen) SetForm(header, chosen->form);
  return CopyWith(header, part, path);
}

}  // namespace acus::volume
