#include "acus/data/volume/header_check.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <fstream>
#include <map>
#include <optional>
#include <sstream>
#include <vector>
#include <zlib.h>

#include "acus/base/core/delimited_text.h"
#include "acus/base/core/error.h"
#include "acus/base/core/input_file.h"
#include "acus/base/core/number_text.h"
#include "acus/base/core/words.h"
#include "acus/data/volume/nifti_header.h"

namespace acus::volume {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kMostDeflateRatio = 1032;
constexpr std::size_t kMaxHeaderBytes = std::size_t{1} << 20U;
constexpr int kMaxHeaderLines = 100'000;
/// NrrdIO copies a field that it cannot understand into a message of 1,024 bytes, unchecked.
constexpr std::size_t kMaxNrrdFieldBytes = 500;
/// MetaIO copies an unknown key into 255 bytes, unchecked.
constexpr std::size_t kMaxMetaKeyBytes = 200;

/// "key = value" lines of a MetaImage up to ElementDataFile, in which no key has two values.
std::map<std::string, std::string> MetaFields(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  ACUS_REQUIRE(file, path.string(), ": cannot be read");
  std::map<std::string, std::string> fields;
  std::size_t total = 0;
  std::string line;
  for (int number = 1; number <= kMaxHeaderLines && std::getline(file, line); ++number) {
    total += line.size();
    ACUS_REQUIRE(total <= kMaxHeaderBytes, path.string(), ": the text header does not end");
    const auto at = std::min(line.find('='), line.size());
    ACUS_REQUIRE(at <= kMaxMetaKeyBytes, path.string(), ":", number, ": a key has ", at,
                 " bytes; at most ", kMaxMetaKeyBytes, " are read. The header is broken");
    if (at == line.size()) continue;
    const std::string key(Trimmed(std::string_view(line).substr(0, at)));
    const std::string value(Trimmed(std::string_view(line).substr(at + 1)));
    const auto [field, is_new] = fields.try_emplace(key, value);
    ACUS_REQUIRE(is_new || field->second == value || key == "Comment", path.string(), ":", number,
                 ": ", key, " is given as '", field->second, "' and as '", value,
                 "'; the header is broken");
    if (key == "ElementDataFile") return fields;
  }
  throw InputError(Message(path.string(),
                           ": has no 'ElementDataFile' line; it is cut off or no "
                           "MetaImage"));
}

/// "key: value" lines of an NRRD up to the first empty one.
std::map<std::string, std::string> NrrdFields(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  ACUS_REQUIRE(file, path.string(), ": cannot be read");
  std::map<std::string, std::string> fields;
  std::size_t total = 0;
  std::string line;
  for (int number = 0; number < kMaxHeaderLines && std::getline(file, line); ++number) {
    total += line.size();
    ACUS_REQUIRE(total <= kMaxHeaderBytes, path.string(), ": the text header does not end");
    const std::string_view text = Trimmed(line);
    if (text.empty()) return fields;
    const auto at = text.find(':');
    if (text.starts_with('#') || at == text.npos) continue;
    fields[std::string(Trimmed(text.substr(0, at)))] = Trimmed(text.substr(at + 1));
  }
  return fields;
}

/// All numbers of a header line. @throws InputError if a word is not a finite number.
std::vector<double> NumbersIn(const std::string& text, const fs::path& path,
                              const std::string& key) {
  std::vector<double> values;
  std::istringstream words(text);
  for (std::string word; words >> word;) {
    const auto value = ParseFinite(word);
    ACUS_REQUIRE(value, path.string(), ": ", key, ": '", word,
                 "' is not a number; the header is broken");
    values.push_back(*value);
  }
  return values;
}

void RequireVolumeSizes(const std::vector<double>& sizes, const fs::path& path) {
  ACUS_REQUIRE(sizes.size() >= 3 && sizes.size() <= 4, path.string(), ": has ", sizes.size(),
               " dimensions; a single 3-D volume is needed",
               sizes.size() < 3 ? "" : " (export one volume, or one segment layer)");
  for (const double size : sizes) {
    ACUS_REQUIRE(size >= 1.0 && size <= 65535.0 && size == std::floor(size), path.string(),
                 ": a size of ", size, " voxels is not possible; the header is broken");
  }
}

/// Inflates (zlib or gzip) at most `limit` bytes from `offset` on and counts. @throws InputError if
/// that fails.
std::uint64_t InflatedBytes(const fs::path& path, std::uint64_t offset, std::uint64_t limit) {
  std::ifstream file(path, std::ios::binary);
  file.seekg(static_cast<std::streamoff>(offset));
  z_stream stream{};
  ACUS_REQUIRE(inflateInit2(&stream, 15 + 32) == Z_OK, path.string(), ": cannot be inflated");
  std::vector<unsigned char> in(1U << 16U);
  std::vector<unsigned char> out(1U << 20U);
  std::uint64_t count = 0;
  int status = Z_OK;
  while (status == Z_OK && file) {
    const std::uint64_t chunk = std::min<std::uint64_t>(in.size(), limit);
    if (chunk == 0) break;
    file.read(reinterpret_cast<char*>(in.data()), static_cast<std::streamsize>(chunk));
    limit -= chunk;
    stream.next_in = in.data();
    stream.avail_in = static_cast<unsigned>(file.gcount());
    while (status == Z_OK && stream.avail_in > 0) {
      stream.next_out = out.data();
      stream.avail_out = static_cast<unsigned>(out.size());
      status = inflate(&stream, Z_NO_FLUSH);
      count += out.size() - stream.avail_out;
    }
  }
  inflateEnd(&stream);
  ACUS_REQUIRE(status == Z_STREAM_END, path.string(),
               ": its compressed data is cut off or broken; copy or export it again");
  return count;
}

void RequireBytes(std::uint64_t got, double needed, const fs::path& path) {
  ACUS_REQUIRE(static_cast<double>(got) >= needed, path.string(), ": has ", got,
               " bytes of voxels but its header promises ", needed,
               ", more than the file can hold; it is cut off or broken");
}

int BytesOfMetaType(const std::string& type) {
  static const std::map<std::string, int> kBytes = {
      {"MET_CHAR", 1},  {"MET_UCHAR", 1},  {"MET_SHORT", 2},     {"MET_USHORT", 2},
      {"MET_INT", 4},   {"MET_UINT", 4},   {"MET_LONG", 4},      {"MET_ULONG", 4},
      {"MET_FLOAT", 4}, {"MET_DOUBLE", 8}, {"MET_LONG_LONG", 8}, {"MET_ULONG_LONG", 8}};
  const auto found = kBytes.find(type);
  return found == kBytes.end() ? 0 : found->second;
}

/// Where the voxels begin in an .mha: after the line of ElementDataFile.
std::uint64_t DataBegin(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::string line;
  while (std::getline(file, line) && !line.starts_with("ElementDataFile")) {
  }
  return static_cast<std::uint64_t>(std::max<std::streamoff>(file.tellg(), 0));
}

/// Bytes per voxel of a NIfTI datatype code that is a plain number, or 0.
int BytesOfNiftiType(int code) {
  switch (code) {
    case 2:
    case 256:
      return 1;
    case 4:
    case 512:
      return 2;
    case 8:
    case 16:
    case 768:
      return 4;
    case 64:
    case 1024:
    case 1280:
      return 8;
    default:
      return 0;
  }
}

/// The data files of a header with one for each slice: "slice_%03d.raw 1 40 1", or LIST and their
/// names in the lines after the one that begins with `key`.
void CheckSliceFiles(const fs::path& path, const std::string& data, const std::string& key) {
  if (!data.starts_with("LIST")) {
    RequireDataBeside(path, data.substr(0, data.find(' ')));
    return;
  }
  std::ifstream file(path, std::ios::binary);
  std::string line;
  while (std::getline(file, line) && !line.starts_with(key)) {
  }
  while (std::getline(file, line)) {
    const std::string_view name = Trimmed(line);
    if (!name.empty()) RequireDataBeside(path, name);
  }
}

/// Lines "key: value" up to the first empty one; "key:=value" and comments may have any length.
void RequireShortNrrdFields(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::string line;
  for (int number = 1; std::getline(file, line) && !Trimmed(line).empty(); ++number) {
    const std::size_t colon = line.find(':');
    const bool is_free =
        line.starts_with('#') || (colon != line.npos && line.substr(colon, 2) == ":=");
    ACUS_REQUIRE(is_free || line.size() <= kMaxNrrdFieldBytes, path.string(), ":", number,
                 ": a header field has ", line.size(), " bytes; at most ", kMaxNrrdFieldBytes,
                 " are read. The header is broken");
  }
}

/// Bytes of header and data. The data file of a .nhdr must lie beside it.
double NrrdBytesOnDisk(const fs::path& path, const std::map<std::string, std::string>& fields) {
  const auto found = std::ranges::find_if(fields, [](const auto& field) {
    return field.first == "data file" || field.first == "datafile";
  });
  if (found == fields.end()) return static_cast<double>(fs::file_size(path));
  const std::string& data = found->second;
  if (data.find('%') != data.npos || data.starts_with("LIST")) {
    CheckSliceFiles(path, data, found->first);
    return static_cast<double>(MostVoxelBytes(path));
  }
  return static_cast<double>(RequireInputFile(RequireDataBeside(path, data)));
}

/// Bytes of a voxel; 1 for a type that is refused later.
int BytesOfNrrdType(const std::string& type) {
  for (const char* eight : {"double", "long long", "longlong", "int64"}) {
    if (type.find(eight) != type.npos) return 8;
  }
  if (type.find("short") != type.npos || type.find("int16") != type.npos) return 2;
  return type.find("char") != type.npos || type.find("int8") != type.npos ? 1 : 4;
}

}  // namespace

std::uint64_t MostVoxelBytes(const fs::path& path) {
  const std::string extension = path.extension().string();
  std::error_code error;
  std::uint64_t on_disk = fs::file_size(path, error);
  ACUS_REQUIRE(!error, path.string(), ": cannot be read: ", error.message());
  if (extension == ".nhdr" || extension == ".mhd") {
    const fs::path folder = path.parent_path().empty() ? fs::path(".") : path.parent_path();
    for (const auto& entry : fs::directory_iterator(folder, error)) {
      if (entry.is_regular_file(error)) on_disk += entry.file_size(error);
    }
  }
  return on_disk * (extension == ".nii" ? 1 : kMostDeflateRatio);
}

void CheckMetaImageHeader(const fs::path& path, int channels) {
  const auto fields = MetaFields(path);
  const auto text = [&](const std::string& key) {
    const auto found = fields.find(key);
    return found == fields.end() ? std::string() : found->second;
  };
  const auto dims = NumbersIn(text("NDims"), path, "NDims");
  ACUS_REQUIRE(dims.size() == 1, path.string(), ": NDims is missing; the header is broken");
  const auto sizes = NumbersIn(text("DimSize"), path, "DimSize");
  ACUS_REQUIRE(static_cast<double>(sizes.size()) == dims[0], path.string(), ": DimSize has ",
               sizes.size(), " numbers but NDims is ", dims[0]);
  RequireVolumeSizes(sizes, path);
  for (const char* key : {"ElementSpacing", "ElementSize", "Offset", "Position", "Origin"}) {
    const auto values = NumbersIn(text(key), path, key);
    ACUS_REQUIRE(values.empty() || values.size() == sizes.size(), path.string(), ": ", key,
                 " needs ", sizes.size(), " numbers, got ", values.size());
  }
  for (const char* key : {"TransformMatrix", "Rotation", "Orientation"}) {
    const auto values = NumbersIn(text(key), path, key);
    ACUS_REQUIRE(values.empty() || values.size() == sizes.size() * sizes.size(), path.string(),
                 ": ", key, " needs ", sizes.size() * sizes.size(), " numbers, got ",
                 values.size());
  }
  const std::string stated_channels = text("ElementNumberOfChannels");
  const std::string found_channels = stated_channels.empty() ? "1" : stated_channels;
  ACUS_REQUIRE(found_channels == std::to_string(channels), path.string(), ": has ", found_channels,
               " channels; a CT or label map has one, a displacement field three");
  const std::string data = text("ElementDataFile");
  const std::string extension = path.extension().string();
  ACUS_REQUIRE(extension != ".mha" || data == "LOCAL", path.string(), ": ElementDataFile is '",
               data, "'; in an .mha it must be LOCAL");
  const int bytes_each = BytesOfMetaType(text("ElementType"));
  ACUS_REQUIRE(bytes_each > 0, path.string(), ": ElementType '", text("ElementType"),
               "' is not known; the header is broken");
  double needed = bytes_each * channels;
  for (const double size : sizes) needed *= size;
  if (data.find('%') != data.npos || data.starts_with("LIST")) {  // One file per slice.
    CheckSliceFiles(path, data, "ElementDataFile");
    return RequireMemory(needed, static_cast<double>(MostVoxelBytes(path)), path.string());
  }
  const fs::path file = data == "LOCAL" ? path : RequireDataBeside(path, data);
  std::error_code error;
  ACUS_REQUIRE(fs::is_regular_file(file, error), path.string(), ": its data file ", file.string(),
               " is not there; keep the two files together");
  RequireMemory(needed, static_cast<double>(RequireInputFile(file)), path.string());
  const std::uint64_t begin = data == "LOCAL" ? DataBegin(path) : 0;
  const std::string compressed = text("CompressedData");
  if (!compressed.empty() && std::string_view("Tt1").find(compressed[0]) != std::string::npos) {
    RequireBytes((fs::file_size(file) - begin) * kMostDeflateRatio, needed, path);
    const auto stated = NumbersIn(text("CompressedDataSize"), path, "CompressedDataSize");
    const double there = static_cast<double>(fs::file_size(file) - begin);
    ACUS_REQUIRE(stated.size() <= 1 && (stated.empty() || (stated[0] >= 1 && stated[0] <= there)),
                 path.string(), ": CompressedDataSize does not fit the ", there,
                 " bytes that are there; the file is cut off or broken");
    const double limit = stated.empty() ? there : stated[0];
    RequireBytes(InflatedBytes(file, begin, static_cast<std::uint64_t>(limit)), needed, path);
  } else {
    RequireBytes(fs::file_size(file) - begin, needed, path);
  }
}

void CheckNiftiHeader(const fs::path& path, int channels, bool one_of_several) {
  const NiftiHeader header = ReadNiftiHeader(path);
  const auto num_dimensions = header.At<std::int16_t>(40);
  ACUS_REQUIRE(num_dimensions >= 1 && num_dimensions <= 7, path.string(), ": dim[0] is ",
               num_dimensions, "; 3 is needed. The header is broken");
  std::vector<double> sizes;
  for (std::size_t d = 1; d <= static_cast<std::size_t>(num_dimensions); ++d) {
    const auto size = header.At<std::int16_t>(40 + 2 * d);
    if (d <= 3 || size != 1) sizes.push_back(size);
  }
  RequireVolumeSizes(sizes, path);
  if (channels > 1) {
    ACUS_REQUIRE(sizes.size() == 4 && sizes[3] == channels, path.string(), ": does not hold ",
                 channels, " numbers for each voxel; it is not a displacement field");
    sizes.pop_back();
  }
  const double volumes = sizes.size() == 4 ? sizes.back() : 1.0;
  ACUS_REQUIRE(volumes == 1.0 || (one_of_several && NiftiVolumes(header) == volumes), path.string(),
               ": holds ", volumes, " volumes over time or channels; export a single one");
  for (std::size_t d = 1; d <= 3; ++d) {
    const auto spacing = header.At<float>(76 + 4 * d);
    ACUS_REQUIRE(std::isfinite(spacing) && std::abs(spacing) > 1e-4F && std::abs(spacing) < 1e4F,
                 path.string(), ": pixdim[", d, "] is ", spacing,
                 " mm; the header is broken or the file has no spacing");
  }
  const auto offset = header.At<float>(108);
  ACUS_REQUIRE(std::isfinite(offset) && offset >= 348.0F && offset < 1e8F, path.string(),
               ": vox_offset is ", offset, "; the header is broken");
  // The quaternion, offsets and rows of the sform: ITK's decomposition never ends on a NaN.
  for (std::size_t at = 256; at < 328; at += 4) {
    const auto value = header.At<float>(at);
    ACUS_REQUIRE(std::isfinite(value) && std::abs(value) < 1e6F, path.string(),
                 ": a number of its qform or sform is ", value, "; the header is broken");
  }
  const int bytes_each = BytesOfNiftiType(header.At<std::int16_t>(70));
  ACUS_REQUIRE(bytes_each > 0 && header.At<std::int16_t>(72) == 8 * bytes_each, path.string(),
               ": datatype ", header.At<std::int16_t>(70), " with ", header.At<std::int16_t>(72),
               " bits per voxel is not a plain number; save it as 16-bit integers");
  const double one = bytes_each * channels * sizes[0] * sizes[1] * sizes[2];
  const double needed = offset + volumes * one;
  RequireMemory(offset + one, static_cast<double>(fs::file_size(path)), path.string());
  if (path.extension() == ".gz") {
    RequireBytes(fs::file_size(path) * kMostDeflateRatio, needed, path);
    RequireBytes(InflatedBytes(path, 0, fs::file_size(path)), needed, path);
  } else {
    RequireBytes(fs::file_size(path), needed, path);
  }
}

bool NiftiIsPlaced(const fs::path& path) {
  const NiftiHeader header = ReadNiftiHeader(path);
  return header.At<std::int16_t>(252) > 0 || header.At<std::int16_t>(254) > 0;
}

void CheckNrrdHeader(const fs::path& path, int channels) {
  std::ifstream file(path, std::ios::binary);
  std::string magic(4, '\0');
  file.read(magic.data(), 4);
  ACUS_REQUIRE(file && magic == "NRRD", path.string(),
               ": does not begin with 'NRRD'; it is not an NRRD file");
  RequireShortNrrdFields(path);
  auto fields = NrrdFields(path);
  ACUS_REQUIRE(fields.contains("sizes"), path.string(),
               ": has no 'sizes' line; the header is broken");
  auto sizes = NumbersIn(fields["sizes"], path, "sizes");
  if (channels > 1) {
    ACUS_REQUIRE(sizes.size() == 4 && sizes[0] == channels, path.string(), ": does not hold ",
                 channels, " numbers for each voxel; it is not a displacement field");
    sizes.erase(sizes.begin());
  }
  RequireVolumeSizes(sizes, path);
  const double values = channels * sizes[0] * sizes[1] * sizes[2];
  RequireBytes(MostVoxelBytes(path), values, path);
  const double on_disk = NrrdBytesOnDisk(path, fields);
  RequireMemory(values * BytesOfNrrdType(fields["type"]), on_disk, path.string());
}

double NrrdMillimetresPerUnit(const fs::path& path) {
  const std::string text = NrrdFields(path)["space units"];
  std::optional<double> unit;
  for (std::size_t open = text.find('"'); open != text.npos; open = text.find('"', open)) {
    const std::size_t close = text.find('"', open + 1);
    if (close == text.npos) break;
    const std::string word = text.substr(open + 1, close - open - 1);
    open = close + 1;
    if (word.empty()) continue;
    const auto factor = UnitFactor(ParseColumnName(word).words, "mm");
    ACUS_REQUIRE(factor, path.string(), ": space units: '", word,
                 "' is no unit of length that is known; mm, cm, m and um are");
    ACUS_REQUIRE(!unit || *unit == *factor, path.string(), ": space units: ", text,
                 " are not the same; export it again");
    unit = factor;
  }
  return unit.value_or(1.0);
}

std::string NrrdSpace(const fs::path& path) {
  std::string space = NrrdFields(path)["space"];
  std::ranges::transform(space, space.begin(), [](unsigned char c) { return std::tolower(c); });
  if (const auto at = space.find("-time"); at != space.npos) space.erase(at);
  for (const auto& [letters, words] : {std::pair{"ras", "right-anterior-superior"},
                                       {"las", "left-anterior-superior"},
                                       {"lps", "left-posterior-superior"}}) {
    if (space == letters || space == words) return words;
  }
  return {};
}

int NrrdLayers(const fs::path& path) {
  constexpr double kMaxLayers = 4096.0;
  auto fields = NrrdFields(path);
  const auto sizes = NumbersIn(fields["sizes"], path, "sizes");
  const bool is_list = fields["kinds"].starts_with("list") || fields["kinds"].starts_with("vector");
  if (sizes.size() != 4 || !is_list || !(sizes[0] >= 1.0 && sizes[0] <= kMaxLayers)) return 1;
  return static_cast<int>(sizes[0]);
}

}  // namespace acus::volume
