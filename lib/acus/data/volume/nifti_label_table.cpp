// NIfTI-1: its header is followed by extensions (size, code, text) up to vox_offset.
#include "acus/data/volume/nifti_label_table.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <memory>
#include <string_view>
#include <zlib.h>

#include "acus/base/core/error.h"
#include "acus/base/core/number_text.h"
#include "acus/base/core/xml_scan.h"

namespace acus::volume {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kNiftiHeaderBytes = 352;  // With the four bytes that announce extensions.
constexpr std::size_t kMaxExtensionBytes = std::size_t{16} << 20U;

/// A number of the header; its bytes are in reverse order on a machine of the other kind.
template <typename T>
T NumberAt(std::string_view bytes, std::size_t at, bool swapped) {
  std::array<char, sizeof(T)> raw{};
  std::copy_n(bytes.begin() + static_cast<std::ptrdiff_t>(at), sizeof(T), raw.begin());
  if (swapped) std::ranges::reverse(raw);
  T value;
  std::memcpy(&value, raw.data(), sizeof(T));
  return value;
}

/// Everything before the voxels; empty if there are no extensions, or more than a table can need.
std::string HeaderWithExtensions(const fs::path& path, bool& swapped) {
  const std::unique_ptr<gzFile_s, int (*)(gzFile)> file(gzopen(path.c_str(), "rb"), &gzclose);
  ACUS_REQUIRE(file != nullptr, path.string(), ": cannot be read");
  std::string bytes(kNiftiHeaderBytes, '\0');
  const auto read = [&](std::size_t from) {
    const auto count = static_cast<unsigned>(bytes.size() - from);
    return gzread(file.get(), &bytes[from], count) == static_cast<int>(count);
  };
  if (!read(0) || bytes[348] == 0) return "";
  swapped = NumberAt<std::int32_t>(bytes, 0, false) != 348;
  const auto voxels_begin = static_cast<double>(NumberAt<float>(bytes, 108, swapped));
  if (!(voxels_begin > static_cast<double>(kNiftiHeaderBytes)) ||
      voxels_begin > static_cast<double>(kMaxExtensionBytes)) {
    return "";
  }
  bytes.resize(static_cast<std::size_t>(voxels_begin));
  return read(kNiftiHeaderBytes) ? bytes : "";
}

ValueNames TableIn(std::string_view xml, const std::string& label) {
  ValueNames names;
  for (const core::XmlElement& element : core::ScanXml(xml, label)) {
    if (element.name != "Label") continue;
    const std::string key = element.Attribute("Key").value_or("");
    const auto value = ParseNumber<std::int32_t>(key);
    ACUS_REQUIRE(value, label, ": the Key '", key, "' of label '", element.text,
                 "' is not an integer; export the file again");
    if (*value != 0) names[*value] = {.text = element.text, .codes = {}};
  }
  return names;
}

}  // namespace

ValueNames NiftiLabelTable(const fs::path& path) {
  bool swapped = false;
  const std::string header = HeaderWithExtensions(path, swapped);
  std::string_view rest = header;
  rest.remove_prefix(std::min(kNiftiHeaderBytes, rest.size()));
  while (rest.size() > 8) {
    const auto size = NumberAt<std::int32_t>(rest, 0, swapped);
    if (size <= 8 || static_cast<std::size_t>(size) > rest.size()) break;
    std::string_view text = rest.substr(8, static_cast<std::size_t>(size) - 8);
    rest.remove_prefix(static_cast<std::size_t>(size));
    // The end is padded with zeros to a multiple of 16 bytes.
    text = text.substr(0, text.find('\0'));
    if (text.find("<LabelTable") != text.npos) {
      return TableIn(text, path.string() + " (label table in its header)");
    }
  }
  return {};
}

}  // namespace acus::volume
