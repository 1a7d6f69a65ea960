#include "acus/base/core/provenance.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <openssl/evp.h>
#include <vector>

#include "acus/base/core/error.h"
#include "acus/base/core/input_file.h"
#include "acus/base/core/shown_path.h"

namespace acus {
namespace {

namespace fs = std::filesystem;

class Sha256 {
 public:
  Sha256() : context_(EVP_MD_CTX_new(), &EVP_MD_CTX_free) {
    ACUS_ASSERT(context_ != nullptr);
    ACUS_ASSERT(EVP_DigestInit_ex(context_.get(), EVP_sha256(), nullptr) == 1);
  }

  void Add(const char* bytes, std::size_t count) {
    ACUS_ASSERT(EVP_DigestUpdate(context_.get(), bytes, count) == 1);
  }

  void AddFile(const fs::path& path) {
    RequireInputFile(path);
    std::ifstream file(path, std::ios::binary);
    ACUS_REQUIRE(file, path.string(), ": cannot be read");
    std::vector<char> buffer(1 << 18);
    while (file) {
      file.read(buffer.data(), static_cast<std::streamsize>(buffer.size()));
      Add(buffer.data(), static_cast<std::size_t>(file.gcount()));
    }
  }

  std::string Hex() {
    std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
    unsigned int size = 0;
    ACUS_ASSERT(EVP_DigestFinal_ex(context_.get(), digest.data(), &size) == 1);
    static constexpr char kDigits[] = "0123456789abcdef";
    std::string hex;
    for (unsigned int i = 0; i < size; ++i) {
      hex += kDigits[digest[i] >> 4U];
      hex += kDigits[digest[i] & 15U];
    }
    return hex;
  }

 private:
  std::unique_ptr<EVP_MD_CTX, decltype(&EVP_MD_CTX_free)> context_;
};

}  // namespace

std::string Sha256OfPath(const fs::path& path) {
  Sha256 hash;
  std::error_code error;
  if (!fs::is_directory(path, error)) {
    hash.AddFile(path);
    return hash.Hex();
  }
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(path)) {
    if (entry.is_regular_file()) files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  for (const auto& file : files) {
    const std::string name = fs::relative(file, path).generic_string();
    hash.Add(name.data(), name.size() + 1);
    hash.AddFile(file);
  }
  return hash.Hex();
}

std::string Sha256OfText(const std::string& text) {
  Sha256 hash;
  hash.Add(text.data(), text.size());
  return hash.Hex();
}

void Provenance::AddInput(const fs::path& path) {
  std::string name = ShownPath(path);
  const std::string hash = Sha256OfPath(path);
  // Without their folders, two files may have one name.
  for (int i = 2; input_sha256.contains(name) && input_sha256[name] != hash && !FoldersAreShown();
       ++i) {
    name = Message(ShownPath(path), " (", i, ")");
  }
  input_sha256[name] = hash;
}

nlohmann::json Provenance::ToJson() const {
  return {{"program", program},
          {"version", version},
          {"command_line", command_line},
          {"seed", seed},
          {"input_sha256", input_sha256}};
}

std::string Provenance::OneLine() const {
  return ToJson().dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

}  // namespace acus
