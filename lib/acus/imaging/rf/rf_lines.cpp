#include "acus/imaging/rf/rf_lines.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/error.h"

namespace acus::rf {
namespace {

std::string MetaHeader(const PixelGrid& grid, double scale) {
  return Message(
      "ObjectType = Image\nNDims = 3\nAnatomicalOrientation = RAI\n",
      "BinaryData = True\nBinaryDataByteOrderMSB = False\nCompressedData = False\n",
      "DimSize = ", grid.rows, " ", grid.columns, " 1\n", "ElementSpacing = ", grid.step_mm.y(),
      " ", grid.step_mm.x(), " 1\n", "Offset = 0 0 0\n", "TransformMatrix = 1 0 0 0 1 0 0 0 1\n",
      "Kinds = domain domain list\n",
      "UltrasoundImageOrientation = FM\nUltrasoundImageType = RF_REAL\n", "RfScale = ", scale,
      "\nSeq_Frame0000_Timestamp = 0\n", "Seq_Frame0000_ImageStatus = OK\n",
      "ElementType = MET_SHORT\nElementDataFile = LOCAL\n");
}

}  // namespace

void WriteRfLines(const std::filesystem::path& path, const IqImage& image) {
  ACUS_REQUIRE(!image.values.empty(), path.string(), ": there are no RF lines to write");
  float largest = 0.0F;
  for (const auto& value : image.values) largest = std::max(largest, std::abs(value.real()));
  const double scale = largest > 0.0F ? largest / 32767.0 : 1.0;
  std::vector<std::int16_t> lines;
  lines.reserve(image.values.size());
  for (int column = 0; column < image.grid.columns; ++column) {
    for (int row = 0; row < image.grid.rows; ++row) {
      lines.push_back(static_cast<std::int16_t>(std::lround(image.At(column, row).real() / scale)));
    }
  }
  std::string bytes = MetaHeader(image.grid, scale);
  bytes.append(reinterpret_cast<const char*>(lines.data()), 2 * lines.size());
  WriteTextFile(path, bytes);
}

}  // namespace acus::rf
