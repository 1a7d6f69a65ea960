// The elements of an XML file with their attributes: as much of XML as MRML scenes and PLUS
// configurations use.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace acus::core {

struct XmlElement {
  std::string name;
  int depth = 0;  ///< 0 for the root.
  std::vector<std::pair<std::string, std::string>> attributes;
  std::string text;  ///< Directly inside, without the blanks around it.

  std::optional<std::string> Attribute(std::string_view key) const;
};

/// All elements in order of appearance, at least one; attributes as XML normalises them: line ends
/// and tabs are blanks. Nothing outside the text is read.
///
/// @throws InputError at label:line if the text is not well-formed XML, declares entities of its
/// own (a few of them can stand for gigabytes), is more than 1000 elements deep, has an attribute
/// above 64 MiB or is above 2 GB.
std::vector<XmlElement> ScanXml(std::string_view text, const std::string& label);

}  // namespace acus::core
