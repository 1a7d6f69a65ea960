// Which file may be loaded as a vendor's library: code that whoever filled the working directory,
// or a folder that all may write, cannot exchange.
#pragma once

#include <filesystem>
#include <string>

namespace acus {

/// `library` of a devices file, as far as the word itself goes: an absolute path, or a name without
/// a slash, which the system's search finds. The loader's own placeholders ($ORIGIN) are refused.
/// @param where  file and place, for the message.  @throws InputError
void CheckLibraryWord(const std::string& library, const std::string& where);

/// The file that an absolute path leads to, links followed. It is a regular file; it and each
/// folder above it belong to root or to the user who runs this; and neither their group nor others
/// may write them. A folder with the sticky bit, such as /tmp, may be written by all: there, no
/// user can exchange what belongs to another one.
/// @param where  file and place, or the product, for the message.  @throws InputError
std::filesystem::path TrustedFile(const std::string& path, const std::string& where);

}  // namespace acus
