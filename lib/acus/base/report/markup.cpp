#include "acus/base/report/markup.h"

#include <array>
#include <cstdint>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/error.h"

namespace acus::report {
namespace {

constexpr std::string_view kReplacementCharacter = "\xEF\xBF\xBD";

unsigned ByteAt(std::string_view text, std::size_t i) {
  return static_cast<unsigned char>(text[i]);
}

/// Length of the well-formed UTF-8 sequence at `begin` (Unicode 15, table 3-7), or 0.
std::size_t SequenceLength(std::string_view text, std::size_t begin) {
  const unsigned lead = ByteAt(text, begin);
  if (lead < 0x80) return 1;
  const std::size_t length = lead >= 0xC2 && lead <= 0xDF   ? 2
                             : lead >= 0xE0 && lead <= 0xEF ? 3
                             : lead >= 0xF0 && lead <= 0xF4 ? 4
                                                            : 0;
  if (length == 0 || begin + length > text.size()) return 0;
  for (std::size_t i = 1; i < length; ++i) {
    if ((ByteAt(text, begin + i) & 0xC0U) != 0x80) return 0;
  }
  const unsigned second = ByteAt(text, begin + 1);
  const bool overlong = (lead == 0xE0 && second < 0xA0) || (lead == 0xF0 && second < 0x90);
  const bool outside = (lead == 0xED && second > 0x9F) || (lead == 0xF4 && second > 0x8F);
  return overlong || outside ? 0 : length;
}

std::string Base64(std::string_view bytes) {
  static constexpr std::string_view kAlphabet =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::array<unsigned, 3> in{};
    for (std::size_t k = 0; k < 3 && i + k < bytes.size(); ++k) in[k] = ByteAt(bytes, i + k);
    const unsigned word = in[0] << 16U | in[1] << 8U | in[2];
    for (unsigned k = 0; k < 4; ++k) text += kAlphabet[word >> (18U - 6U * k) & 63U];
  }
  if (bytes.size() % 3 > 0) text.back() = '=';
  if (bytes.size() % 3 == 1) text[text.size() - 2] = '=';
  return text;
}

}  // namespace

std::string Escaped(std::string_view text) {
  std::string escaped;
  escaped.reserve(text.size());
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t length = SequenceLength(text, i);
    if (length != 1) {
      escaped += length == 0 ? kReplacementCharacter : text.substr(i, length);
      i += length == 0 ? 1 : length;
      continue;
    }
    const char c = text[i++];
    switch (c) {
      case '&':
        escaped += "&amp;";
        break;
      case '<':
        escaped += "&lt;";
        break;
      case '>':
        escaped += "&gt;";
        break;
      case '"':
        escaped += "&quot;";
        break;
      case '\'':
        escaped += "&#39;";
        break;
      default:
        escaped += (c >= ' ' && c != '\x7F') || c == '\n' || c == '\t' ? c : ' ';
    }
  }
  return escaped;
}

int NumCharacters(std::string_view text) {
  int count = 0;
  for (std::size_t i = 0; i < text.size(); ++i) count += (ByteAt(text, i) & 0xC0U) != 0x80;
  return count;
}

std::string PngDataUri(const std::filesystem::path& png) {
  const std::string bytes = ReadTextFile(png);
  ACUS_REQUIRE(bytes.starts_with("\x89PNG\r\n\x1A\n"), png.string(), ": is not a PNG image");
  return "data:image/png;base64," + Base64(bytes);
}

}  // namespace acus::report
