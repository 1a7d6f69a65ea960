#include "acus/data/volume/dicom_elements.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <string_view>
#include <zlib.h>

#include "acus/base/core/error.h"
#include "acus/base/core/input_file.h"
#include "acus/base/core/words.h"

namespace acus::volume {
namespace {

constexpr std::uintmax_t kMaxDicomBytes = std::uintmax_t{4} << 30U;

/// Where the data set of a deflated file begins, after the meta header; 0 if it is not deflated.
std::size_t DeflatedBegin(DicomBytes bytes) {
  std::size_t at = 132;
  bool is_deflated = false;
  while (at + 8 <= bytes.size() && DicomU16(bytes, at) == 2) {
    const DicomHead head = ReadDicomHead(bytes, at, true);
    const std::size_t begin = at + head.size;
    if (begin > bytes.size() || head.length > bytes.size() - begin) return 0;
    if (head.tag == kDicomTransferSyntax) {
      const std::string_view syntax = kDicomDeflated;
      is_deflated = head.length >= syntax.size() &&
                    std::equal(syntax.begin(), syntax.end(), bytes.begin() + begin);
    }
    at = begin + head.length;
  }
  return is_deflated ? at : 0;
}

/// PS3.5 A.5: the bytes from `begin` on are deflated without a head.
void Inflate(std::vector<std::uint8_t>& bytes, std::size_t begin,
             const std::filesystem::path& path) {
  z_stream stream{};
  ACUS_REQUIRE(inflateInit2(&stream, -15) == Z_OK, path.string(), ": cannot be inflated");
  std::vector<std::uint8_t> out(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(begin));
  std::vector<std::uint8_t> block(1U << 20U);
  stream.next_in = bytes.data() + begin;
  stream.avail_in = static_cast<unsigned>(std::min<std::size_t>(bytes.size() - begin, 0xFFFFFFFFU));
  int status = Z_OK;
  while (status == Z_OK) {
    stream.next_out = block.data();
    stream.avail_out = static_cast<unsigned>(block.size());
    status = inflate(&stream, Z_NO_FLUSH);
    out.insert(out.end(), block.begin(),
               block.end() - static_cast<std::ptrdiff_t>(stream.avail_out));
    if (static_cast<double>(out.size()) > InputMemoryBytes()) break;
    if (status == Z_OK && stream.avail_in == 0 && stream.avail_out > 0) break;
  }
  inflateEnd(&stream);
  RequireMemory(static_cast<double>(out.size()), static_cast<double>(bytes.size()), path.string());
  ACUS_REQUIRE(status == Z_STREAM_END, path.string(),
               ": its deflated data ends too early or is broken; copy or export it again");
  bytes = std::move(out);
}

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

int DicomValues::Long(std::uint32_t tag, int missing) const {
  const auto found = values.find(tag);
  if (found == values.end() || found->second.size() < 4) return missing;
  return static_cast<int>(std::min(DicomU32(found->second, 0), 1'000'000U));
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
  if (const std::size_t begin = DeflatedBegin(bytes); begin > 0) Inflate(bytes, begin, path);
  return bytes;
}

}  // namespace acus::volume
