#include "acus/data/mesh/surface_formats.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdint>
#include <cstring>
#include <optional>
#include <span>

#include "acus/base/core/csv.h"
#include "acus/base/core/delimited_text.h"
#include "acus/data/mesh/surface_builder.h"
#include "acus/data/mesh/text_scanner.h"

namespace acus::mesh {
namespace {

constexpr std::size_t kStlHeader = 84;
constexpr std::size_t kStlTriangle = 50;

float FloatAt(std::string_view bytes, std::size_t offset) {
  float value = 0.0F;
  std::memcpy(&value, bytes.data() + offset, sizeof value);
  return value;
}

Surface ParseBinaryStl(std::string_view bytes, const std::string& label) {
  SurfaceBuilder builder;
  for (std::size_t at = kStlHeader; at + kStlTriangle <= bytes.size(); at += kStlTriangle) {
    std::array<int, 3> corner{};
    for (std::size_t c = 0; c < 3; ++c) {
      std::array<float, 3> x{};
      for (std::size_t d = 0; d < 3; ++d) {
        x[d] = FloatAt(bytes, at + 12 + 12 * c + 4 * d);
        ACUS_REQUIRE(std::isfinite(x[d]), label, ": triangle ", (at - kStlHeader) / kStlTriangle,
                     " has a coordinate that is not a finite number");
      }
      corner[c] = builder.AddSharedNode(x[0], x[1], x[2]);
    }
    builder.AddTriangle(corner[0], corner[1], corner[2]);
  }
  return builder.Finish(label);
}

bool IsWord(std::string_view text, std::string_view word) {
  return text.size() == word.size() &&
         std::ranges::equal(text, word, {}, [](unsigned char c) { return std::tolower(c); });
}

Surface ParseTextStl(std::string_view bytes, const std::string& label) {
  SurfaceBuilder builder;
  TextScanner lines(bytes, label);
  std::vector<int> corners;
  bool is_ended = false;
  while (lines.NextLine()) {
    const std::string_view word = lines.words()[0];
    if (IsWord(word, "vertex")) {
      corners.push_back(builder.AddSharedNode(lines.Number(1), lines.Number(2), lines.Number(3)));
    } else if (IsWord(word, "endfacet")) {
      ACUS_REQUIRE(corners.size() == 3, lines.Where(), ": a facet has ", corners.size(),
                   " corners; STL allows 3");
      builder.AddTriangle(corners[0], corners[1], corners[2]);
      corners.clear();
    } else if (IsWord(word, "solid") || IsWord(word, "endsolid")) {
      is_ended = IsWord(word, "endsolid");
    } else {
      ACUS_REQUIRE(IsWord(word, "facet") || IsWord(word, "outer") || IsWord(word, "endloop"),
                   lines.Where(), ": '", word.substr(0, 20),
                   "' is not a word of STL text; is the file damaged?");
    }
  }
  ACUS_REQUIRE(is_ended && corners.empty(), label, ": the text ends before 'endsolid': cut off");
  return builder.Finish(label);
}

/// mm per unit that a comment declares, as "# Units: mm" or "# unit = meter".
std::optional<double> UnitInComment(std::span<const std::string_view> words) {
  for (std::size_t i = 0; i + 1 < words.size(); ++i) {
    const std::string key = ParseColumnName(words[i]).words;
    if (!key.starts_with("unit")) continue;
    // The last: "in" may be a word before the unit, as in "Units are in centimeters".
    std::optional<double> last;
    for (std::size_t k = i + 1; k < words.size(); ++k) {
      const auto factor = UnitFactor(ParseColumnName(words[k]).words, "mm");
      if (factor) last = factor;
    }
    return last;
  }
  return {};
}

void AppendBytes(std::string& out, const void* data, std::size_t size) {
  out.append(static_cast<const char*>(data), size);
}

}  // namespace

Surface ParseStl(std::string_view bytes, const std::string& label) {
  ACUS_REQUIRE(!bytes.empty(), label, ": the file is empty");
  if (bytes.size() >= kStlHeader) {
    std::uint32_t count = 0;
    std::memcpy(&count, bytes.data() + 80, sizeof count);
    const std::uint64_t expected = kStlHeader + std::uint64_t{count} * kStlTriangle;
    if (expected == bytes.size()) return ParseBinaryStl(bytes, label);
    ACUS_REQUIRE(IsWord(bytes.substr(0, 5), "solid"), label, ": the header announces ", count,
                 " triangles (", expected, " bytes), but the file has ", bytes.size(),
                 expected > bytes.size() ? " bytes: cut off or not STL" : " bytes: not STL");
  }
  ACUS_REQUIRE(IsWord(bytes.substr(0, 5), "solid"), label, ": neither text nor binary STL");
  return ParseTextStl(bytes, label);
}

Surface ParseObj(std::string_view bytes, const std::string& label) {
  static constexpr std::array<std::string_view, 14> kIgnored = {
      "vn", "vt", "vp", "g", "o", "s", "usemtl", "mtllib", "l", "p", "cstype", "deg", "end", "mg"};
  static constexpr std::array<std::string_view, 7> kOfNumbers = {"v", "vn", "vt", "vp",
                                                                 "f", "l",  "p"};
  SurfaceBuilder builder;
  TextScanner lines(bytes, label);
  std::vector<long long> corners;
  double mm_per_unit = 1.0;
  while (lines.NextLine()) {
    const std::string_view word = lines.words()[0];
    const bool has_numbers = std::ranges::find(kOfNumbers, word) != kOfNumbers.end();
    if (has_numbers) lines.JoinContinuedLines();
    if (word == "v") {
      builder.AddNode(lines.Number(1), lines.Number(2), lines.Number(3));
    } else if (word == "f") {
      corners.clear();
      for (std::size_t i = 1; i < lines.words().size(); ++i) {
        const long long number = lines.Whole(i);  // From 1; negative: from the newest node back.
        ACUS_REQUIRE(number != 0, lines.Where(), ": node number 0; OBJ counts from 1");
        corners.push_back(number > 0 ? number - 1 : builder.num_nodes() + number);
      }
      builder.AddPolygon(corners, lines.Where());
    } else if (word.starts_with('#')) {
      mm_per_unit = UnitInComment(lines.words()).value_or(mm_per_unit);
    } else {
      bool is_known = false;
      for (const std::string_view ignored : kIgnored) is_known = is_known || word == ignored;
      ACUS_REQUIRE(is_known, lines.Where(), ": '", word.substr(0, 20),
                   "' is not a word of OBJ; is the file damaged?");
    }
  }
  Surface surface = builder.Finish(label);
  if (mm_per_unit != 1.0) surface.nodes_mm *= mm_per_unit;
  return surface;
}

std::string FormatStl(const Surface& surface) {
  std::string out = "Acus surface, mm, LPS";
  out.resize(80, ' ');
  const auto count = static_cast<std::uint32_t>(surface.triangles.cols());
  AppendBytes(out, &count, sizeof count);
  for (Eigen::Index t = 0; t < surface.triangles.cols(); ++t) {
    Eigen::Matrix3d corner;
    for (int c = 0; c < 3; ++c) corner.col(c) = surface.nodes_mm.col(surface.triangles(c, t));
    const Eigen::Vector3d normal =
        (corner.col(1) - corner.col(0)).cross(corner.col(2) - corner.col(0)).normalized();
    const Eigen::Vector3f normal_f = normal.cast<float>();
    const Eigen::Matrix3f corner_f = corner.cast<float>();
    AppendBytes(out, normal_f.data(), 12);
    AppendBytes(out, corner_f.data(), 36);
    out.append(2, '\0');
  }
  return out;
}

std::string FormatObj(const Surface& surface) {
  std::string out = "# Acus surface, mm, LPS\n";
  for (Eigen::Index n = 0; n < surface.nodes_mm.cols(); ++n) {
    out += 'v';
    for (int d = 0; d < 3; ++d) out += ' ' + NumberText(surface.nodes_mm(d, n));
    out += '\n';
  }
  for (Eigen::Index t = 0; t < surface.triangles.cols(); ++t) {
    out += 'f';
    for (int c = 0; c < 3; ++c) out += ' ' + std::to_string(surface.triangles(c, t) + 1);
    out += '\n';
  }
  return out;
}

std::string FormatPly(const Surface& surface) {
  std::string out = Message(
      "ply\nformat binary_little_endian 1.0\ncomment Acus surface, mm, LPS\nelement vertex ",
      surface.nodes_mm.cols(), "\nproperty double x\nproperty double y\nproperty double z\n",
      "element face ", surface.triangles.cols(),
      "\nproperty list uchar int vertex_indices\nend_header\n");
  AppendBytes(out, surface.nodes_mm.data(), sizeof(double) * surface.nodes_mm.size());
  for (Eigen::Index t = 0; t < surface.triangles.cols(); ++t) {
    out += '\3';
    AppendBytes(out, surface.triangles.col(t).data(), 12);
  }
  return out;
}

}  // namespace acus::mesh
