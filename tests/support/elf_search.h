// What an ELF file says about where the loader looks for its libraries.
#pragma once

#include <cstring>
#include <elf.h>
#include <filesystem>
#include <link.h>
#include <stdexcept>
#include <string>
#include <vector>

#include "acus/base/core/atomic_file.h"

namespace acus::testing_support {

struct ElfSearch {
  std::vector<std::string> folders;    ///< Entries of DT_RPATH and DT_RUNPATH; may be empty.
  std::vector<std::string> libraries;  ///< DT_NEEDED.
};

/// A dynamic section, read from the bytes of a file of this machine's word size.
class ElfFile {
 public:
  explicit ElfFile(const std::filesystem::path& path)
      : path_(path.string()), bytes_(ReadTextFile(path)) {}

  bool is_elf() const { return bytes_.starts_with(std::string(ELFMAG, SELFMAG)); }

  /// @throws std::runtime_error if it is damaged, or linked statically.
  ElfSearch Search() const {
    std::vector<ElfW(Addr)> folders;
    std::vector<ElfW(Addr)> libraries;
    ElfW(Addr) texts = 0;
    for (const ElfW(Dyn) & entry : DynamicSection()) {
      if (entry.d_tag == DT_STRTAB) texts = OffsetOf(entry.d_un.d_ptr);
      if (entry.d_tag == DT_NEEDED) libraries.push_back(entry.d_un.d_val);
      if (entry.d_tag == DT_RPATH || entry.d_tag == DT_RUNPATH) folders.push_back(entry.d_un.d_val);
    }
    ElfSearch search;
    for (const auto offset : libraries) search.libraries.push_back(TextAt(texts + offset));
    for (const auto offset : folders) {
      std::string text = TextAt(texts + offset) + ":";
      for (std::size_t end; (end = text.find(':')) != text.npos; text.erase(0, end + 1)) {
        search.folders.push_back(text.substr(0, end));
      }
    }
    return search;
  }

 private:
  template <typename Record>
  Record At(std::size_t offset) const {
    if (offset > bytes_.size() || bytes_.size() - offset < sizeof(Record)) {
      throw std::runtime_error(path_ + ": ends too early");
    }
    Record record;
    std::memcpy(&record, bytes_.data() + offset, sizeof record);
    return record;
  }
  std::string TextAt(std::size_t offset) const {
    const std::size_t end = bytes_.find('\0', offset);
    if (end == bytes_.npos) throw std::runtime_error(path_ + ": a name does not end");
    return bytes_.substr(offset, end - offset);
  }
  std::vector<ElfW(Phdr)> Segments() const {
    const auto header = At<ElfW(Ehdr)>(0);
    std::vector<ElfW(Phdr)> segments;
    for (std::size_t i = 0; i < header.e_phnum; ++i) {
      segments.push_back(At<ElfW(Phdr)>(header.e_phoff + i * header.e_phentsize));
    }
    return segments;
  }
  std::vector<ElfW(Dyn)> DynamicSection() const {
    for (const ElfW(Phdr) & segment : Segments()) {
      if (segment.p_type != PT_DYNAMIC) continue;
      std::vector<ElfW(Dyn)> entries;
      for (std::size_t i = 0; i < segment.p_filesz / sizeof(ElfW(Dyn)); ++i) {
        entries.push_back(At<ElfW(Dyn)>(segment.p_offset + i * sizeof(ElfW(Dyn))));
        if (entries.back().d_tag == DT_NULL) break;
      }
      return entries;
    }
    throw std::runtime_error(path_ + ": has no dynamic section");
  }
  /// Where in the file lies what is at `address` in memory.
  std::size_t OffsetOf(ElfW(Addr) address) const {
    for (const ElfW(Phdr) & segment : Segments()) {
      const bool is_here = segment.p_type == PT_LOAD && address >= segment.p_vaddr &&
                           address - segment.p_vaddr < segment.p_filesz;
      if (is_here) return segment.p_offset + (address - segment.p_vaddr);
    }
    throw std::runtime_error(path_ + ": an address lies outside of the file");
  }

  std::string path_;
  std::string bytes_;
};

}  // namespace acus::testing_support
