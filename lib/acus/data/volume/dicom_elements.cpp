#include "acus/data/volume/dicom_elements.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <string_view>

#include "acus/base/core/error.h"
#include "acus/base/core/input_file.h"
#include "acus/base/core/words.h"

namespace acus::volume {
namespace {

constexpr std::uintmax_t kMaxDicomBytes = std::uintmax_t{4} << 30U;

}  // namespace

bool DicomLooksExplicit(DicomBytes bytes, std::size_t at) {
  if (at + 6 > bytes.size()) return false;
  const auto capital = [&](std::size_t n) { return bytes[n] >= 'A' && bytes[n] <= 'Z'; };
  return capital(at + 4) && capital(at + 5);
}

DicomHead ReadDicomHead(DicomBytes bytes, std::size_t at, bool is_explicit) {
  static constexpr std::string_view kLong = "OB OD OF OL OV OW SQ SV UC UN UR UT UV";
  DicomHead head{.tag = DicomTag(bytes, at), .type = {}, .length = 0, .size = 8};
  if (!is_explicit || !DicomLooksExplicit(bytes, at)) {
    head.length = DicomU32(bytes, at + 4);
    return head;
  }
  head.type = {static_cast<char>(bytes[at + 4]), static_cast<char>(bytes[at + 5])};
  if (kLong.find(head.type) == kLong.npos) {
    head.length = DicomU16(bytes, at + 6);
    return head;
  }
  head.size = 12;
  if (at + head.size <= bytes.size()) head.length = DicomU32(bytes, at + 8);
  return head;
}

std::string DicomValues::Text(std::uint32_t tag) const {
  const auto found = values.find(tag);
  if (found == values.end()) return "";
  std::string text(found->second.begin(), found->second.end());
  while (!text.empty() && (text.back() == '\0' || text.back() == ' ')) text.pop_back();
  return text.substr(std::min(text.find_first_not_of(' '), text.size()));
}

int DicomValues::Short(std::uint32_t tag, int missing) const {
  const auto found = values.find(tag);
  if (found == values.end() || found->second.size() < 2) return missing;
  return found->second[0] | found->second[1] << 8;
}

std::vector<double> DicomValues::Decimals(std::uint32_t tag, std::size_t count) const {
  std::vector<double> numbers;
  const std::string text = Text(tag) + "\\";
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = text.find('\\', begin);
    begin = std::min(text.find_first_not_of(" +", begin), end);
    double value = 0.0;
    const auto [stop, error] = std::from_chars(text.data() + begin, text.data() + end, value);
    const bool whole = error == std::errc() && Trimmed({stop, text.data() + end}).empty();
    if (!whole || !std::isfinite(value)) return {};
    numbers.push_back(value);
    begin = end + 1;
  }
  return numbers.size() == count ? numbers : std::vector<double>();
}

std::vector<std::uint8_t> ReadDicomBytes(const std::filesystem::path& path) {
  std::vector<std::uint8_t> bytes(RequireInputFile(path, kMaxDicomBytes));
  std::ifstream file(path, std::ios::binary);
  file.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  ACUS_REQUIRE(file.gcount() == static_cast<std::streamsize>(bytes.size()), path.string(),
               ": cannot be read; is it readable for you?");
  return bytes;
}

}  // namespace acus::volume
