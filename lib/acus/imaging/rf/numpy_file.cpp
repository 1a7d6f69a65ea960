#include "acus/imaging/rf/numpy_file.h"

#include <bit>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/error.h"

namespace acus::rf {
namespace {

static_assert(std::endian::native == std::endian::little);

/// The header of a file, filled up so that the numbers begin at a multiple of 64 bytes.
std::string Header(const std::string& type, const std::string& shape) {
  std::string text =
      "{'descr': '" + type + "', 'fortran_order': False, 'shape': (" + shape + "), }";
  constexpr std::size_t kMagicBytes = 10;
  while ((kMagicBytes + text.size() + 1) % 64 != 0) text += ' ';
  text += '\n';
  std::string out("\x93NUMPY\x01\x00", 8);
  out += static_cast<char>(text.size() % 256);
  out += static_cast<char>(text.size() / 256);
  return out + text;
}

template <typename T>
void Write(const std::filesystem::path& path, const std::string& header,
           const std::vector<T>& values) {
  std::string bytes = header;
  bytes.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
  WriteTextFile(path, bytes);
}

}  // namespace

void WriteNumpy(const std::filesystem::path& path, const ChannelData& data) {
  Write(path, Header("<f4", Message(data.transmits, ", ", data.elements, ", ", data.samples)),
        data.values);
}

void WriteNumpy(const std::filesystem::path& path, const IqImage& image) {
  Write(path, Header("<c8", Message(image.grid.rows, ", ", image.grid.columns)), image.values);
}

}  // namespace acus::rf
