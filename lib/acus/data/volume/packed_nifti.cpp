#include "acus/data/volume/packed_nifti.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <bzlib.h>
#include <cctype>
#include <fstream>
#include <functional>
#include <string>
#include <unistd.h>
#include <vector>
#include <zlib.h>

#include "acus/base/core/error.h"
#include "acus/base/core/input_file.h"

namespace acus::volume {
namespace {

namespace fs = std::filesystem;

using TakeBlock = std::function<void(const char* data, std::size_t size)>;

constexpr std::size_t kPackedBlockBytes = 1U << 20U;

struct Bzip2Stream : bz_stream {
  Bzip2Stream() : bz_stream{} {}
  ~Bzip2Stream() { BZ2_bzDecompressEnd(this); }
  Bzip2Stream(const Bzip2Stream&) = delete;
  Bzip2Stream& operator=(const Bzip2Stream&) = delete;

  /// Begins the next stream, with the remaining input.
  int Begin() {
    BZ2_bzDecompressEnd(this);
    state = nullptr;
    return BZ2_bzDecompressInit(this, 0, 0);
  }
};

/// All streams of a bzip2 file, one after the other, as parallel programs write them.
void UnpackBzip2(const fs::path& path, const TakeBlock& take) {
  std::ifstream file(path, std::ios::binary);
  std::vector<char> in(kPackedBlockBytes), out(kPackedBlockBytes);
  Bzip2Stream stream;
  int status = BZ_STREAM_END;
  while (true) {
    if (stream.avail_in == 0) {
      file.read(in.data(), static_cast<std::streamsize>(in.size()));
      stream.next_in = in.data();
      stream.avail_in = static_cast<unsigned>(file.gcount());
      if (stream.avail_in == 0) break;
    }
    if (status == BZ_STREAM_END) status = stream.Begin();
    stream.next_out = out.data();
    stream.avail_out = static_cast<unsigned>(out.size());
    if (status == BZ_OK) status = BZ2_bzDecompress(&stream);
    ACUS_REQUIRE(status == BZ_OK || status == BZ_STREAM_END, path.string(),
                 ": its bzip2 data are damaged; copy or export it again");
    take(out.data(), out.size() - stream.avail_out);
  }
  ACUS_REQUIRE(status == BZ_STREAM_END, path.string(),
               ": its bzip2 data end early; the file is cut off. Copy it again");
}

/// A gzip file, or one that is not compressed.
void UnpackGzip(const fs::path& path, const TakeBlock& take) {
  const std::unique_ptr<gzFile_s, int (*)(gzFile)> file(gzopen(path.c_str(), "rb"), &gzclose);
  ACUS_REQUIRE(file != nullptr, path.string(), ": cannot be read");
  std::vector<char> block(kPackedBlockBytes);
  int got = 0;
  while ((got = gzread(file.get(), block.data(), static_cast<unsigned>(block.size()))) > 0) {
    take(block.data(), static_cast<std::size_t>(got));
  }
  ACUS_REQUIRE(got == 0, path.string(), ": its gzip data are damaged; copy or export it again");
}

enum class Packing { kNone, kGzip, kBzip2 };

Packing PackingOf(const fs::path& path) {
  std::array<char, 3> begin{};
  std::ifstream(path, std::ios::binary).read(begin.data(), begin.size());
  if (begin[0] == '\x1f' && begin[1] == '\x8b') return Packing::kGzip;
  return std::string(begin.data(), 3) == "BZh" ? Packing::kBzip2 : Packing::kNone;
}

}  // namespace

std::unique_ptr<Temporary> UnpackedNifti(const fs::path& path) {
  std::string name = path.filename().string();
  std::ranges::transform(name, name.begin(), [](unsigned char c) { return std::tolower(c); });
  const bool is_plain = name.ends_with(".nii");
  const bool is_gzip = name.ends_with(".nii.gz");
  if (!is_plain && !is_gzip && !name.ends_with(".nii.bz2")) return nullptr;
  const Packing packing = PackingOf(path);
  if ((is_plain && packing == Packing::kNone) || (is_gzip && packing == Packing::kGzip)) {
    return nullptr;
  }
  static std::atomic<int> count{0};
  auto copy = std::make_unique<Temporary>(
      fs::temp_directory_path() /
      Message(".acus-unpacked-", getpid(), "-", count.fetch_add(1), ".nii"));
  std::ofstream out(copy->path(), std::ios::binary);
  const double most =
      std::min(InputMemoryBytes(), std::max(2e9, 100.0 * static_cast<double>(fs::file_size(path))));
  double written = 0.0;
  const auto take = [&](const char* data, std::size_t size) {
    written += static_cast<double>(size);
    ACUS_REQUIRE(written <= most, path.string(), ": becomes more than ", most / 1e9,
                 " GB when it is unpacked; --memory-gb sets another limit");
    out.write(data, static_cast<std::streamsize>(size));
    ACUS_REQUIRE(out, path.string(), ": cannot be unpacked to ", fs::temp_directory_path().string(),
                 "; is the disk full?");
  };
  packing == Packing::kBzip2 ? UnpackBzip2(path, take) : UnpackGzip(path, take);
  out.close();
  ACUS_REQUIRE(out, path.string(), ": cannot be unpacked to ", fs::temp_directory_path().string(),
               "; is the disk full?");
  return copy;
}

}  // namespace acus::volume
