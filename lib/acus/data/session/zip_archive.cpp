#include "acus/data/session/zip_archive.h"

#include <utility>
#include <zip.h>

#include "acus/base/core/error.h"
#include "acus/base/core/input_file.h"

namespace acus::session {
namespace {

constexpr zip_int64_t kMaxFiles = 1'000'000;

}  // namespace

class ZipArchive::State {
 public:
  explicit State(const std::filesystem::path& path) : label_(path.string()) {
    RequireInputFile(path);
    int error = 0;
    zip_ = zip_open(path.c_str(), ZIP_RDONLY, &error);
    ACUS_REQUIRE(zip_ != nullptr, label_, ": is not a zip archive (.mrb), or is damaged");
    ListNames();
  }

  State(std::vector<std::uint8_t> bytes, std::string label)
      : label_(std::move(label)), bytes_(std::move(bytes)) {
    zip_source_t* source = zip_source_buffer_create(bytes_.data(), bytes_.size(), 0, nullptr);
    ACUS_REQUIRE(source != nullptr, label_, ": cannot be read");
    zip_ = zip_open_from_source(source, ZIP_RDONLY, nullptr);
    if (zip_ == nullptr) zip_source_free(source);
    ACUS_REQUIRE(zip_ != nullptr, label_, ": is not a zip archive (.mrb), or is damaged");
    ListNames();
  }

  ~State() {
    if (zip_ != nullptr) zip_discard(zip_);
  }
  State(const State&) = delete;
  State& operator=(const State&) = delete;

  std::vector<std::uint8_t> Read(const std::string& name, std::uint64_t max_bytes) const {
    zip_stat_t stat;
    zip_stat_init(&stat);
    ACUS_REQUIRE(zip_stat(zip_, name.c_str(), 0, &stat) == 0 && (stat.valid & ZIP_STAT_SIZE) != 0,
                 label_, ": has no file '", name, "'");
    ACUS_REQUIRE(stat.size <= max_bytes, label_, ": '", name, "' has ", stat.size,
                 " bytes; at most ", max_bytes, " are read");
    const std::unique_ptr<zip_file_t, int (*)(zip_file_t*)> file(zip_fopen(zip_, name.c_str(), 0),
                                                                 &zip_fclose);
    ACUS_REQUIRE(file != nullptr, label_, ": '", name,
                 "' cannot be opened; the archive is damaged ", "or encrypted");
    std::vector<std::uint8_t> content(stat.size);
    // One byte more than there should be: only at the end is the checksum held against the content.
    std::uint8_t beyond = 0;
    const bool whole = zip_fread(file.get(), content.data(), content.size()) ==
                           static_cast<zip_int64_t>(content.size()) &&
                       zip_fread(file.get(), &beyond, 1) == 0;
    ACUS_REQUIRE(whole, label_, ": '", name, "' is damaged (", zip_file_strerror(file.get()),
                 "); copy the archive again");
    return content;
  }

  const std::vector<std::string>& names() const { return names_; }

 private:
  void ListNames() {
    const zip_int64_t count = zip_get_num_entries(zip_, 0);
    const bool acceptable = count >= 0 && count <= kMaxFiles;
    if (!acceptable) {
      zip_discard(std::exchange(zip_, nullptr));
      throw InputError(
          Message(label_, ": has ", count, " files; at most ", kMaxFiles, " are read"));
    }
    for (zip_int64_t i = 0; i < count; ++i) {
      const char* name = zip_get_name(zip_, static_cast<zip_uint64_t>(i), 0);
      if (name != nullptr) names_.emplace_back(name);
    }
  }

  std::string label_;
  std::vector<std::uint8_t> bytes_;  ///< Of an archive in memory; zip_ reads from it.
  zip_t* zip_ = nullptr;
  std::vector<std::string> names_;
};

ZipArchive::ZipArchive(const std::filesystem::path& path) : state_(std::make_unique<State>(path)) {}
ZipArchive::ZipArchive(std::vector<std::uint8_t> bytes, const std::string& label)
    : state_(std::make_unique<State>(std::move(bytes), label)) {}
ZipArchive::~ZipArchive() = default;
ZipArchive::ZipArchive(ZipArchive&&) noexcept = default;
ZipArchive& ZipArchive::operator=(ZipArchive&&) noexcept = default;

const std::vector<std::string>& ZipArchive::names() const {
  return state_->names();
}

std::vector<std::uint8_t> ZipArchive::Read(const std::string& name, std::uint64_t max_bytes) const {
  return state_->Read(name, max_bytes);
}

}  // namespace acus::session
