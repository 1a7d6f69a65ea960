// PLY (Turk 1994): a header that declares elements and properties, then text or binary records.
#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>

#include "acus/data/mesh/surface_builder.h"
#include "acus/data/mesh/surface_formats.h"
#include "acus/data/mesh/text_scanner.h"

namespace acus::mesh {
namespace {

struct Property {
  std::string name;
  int value_type = 0;
  int count_type = -1;  ///< >= 0: a list, whose length has this type.
};
struct Element {
  std::string name;
  std::uint64_t count = 0;
  std::vector<Property> properties;
};

constexpr std::array<std::array<std::string_view, 2>, 8> kTypeNames = {{{"char", "int8"},
                                                                        {"uchar", "uint8"},
                                                                        {"short", "int16"},
                                                                        {"ushort", "uint16"},
                                                                        {"int", "int32"},
                                                                        {"uint", "uint32"},
                                                                        {"float", "float32"},
                                                                        {"double", "float64"}}};
constexpr std::array<std::size_t, 8> kTypeSizes = {1, 1, 2, 2, 4, 4, 4, 8};

int TypeOf(std::string_view name, const TextScanner& lines) {
  for (std::size_t t = 0; t < kTypeNames.size(); ++t) {
    if (name == kTypeNames[t][0] || name == kTypeNames[t][1]) return static_cast<int>(t);
  }
  throw InputError(Message(lines.Where(), ": '", name, "' is not a PLY type"));
}

Property ParseProperty(const TextScanner& lines) {
  const auto& words = lines.words();
  Property out;
  const bool is_list = words.size() >= 2 && words[1] == "list";
  ACUS_REQUIRE(words.size() == (is_list ? 5U : 3U), lines.Where(), ": incomplete property");
  if (is_list) out.count_type = TypeOf(words[2], lines);
  out.value_type = TypeOf(words[is_list ? 3 : 1], lines);
  out.name = words.back();
  ACUS_REQUIRE(out.count_type < 6, lines.Where(), ": a list length cannot be a decimal number");
  return out;
}

/// Values of the body one after the other, whatever the encoding.
class Values {
 public:
  Values(std::string_view body, bool is_text, bool is_swapped, std::string label)
      : body_(body),
        is_text_(is_text),
        is_swapped_(is_swapped),
        label_(label),
        text_(body, label) {}

  double Next(int type) {
    const double value = is_text_ ? NextText() : NextBinary(type);
    ACUS_REQUIRE(std::isfinite(value), label_, ": a value in the body is not a finite number");
    return value;
  }
  std::size_t bytes_left() const { return body_.size() - (is_text_ ? 0 : at_); }

 private:
  double NextText() {
    if (word_ >= text_.words().size()) {
      ACUS_REQUIRE(text_.NextLine(), label_, ": the body ends too early: cut off");
      word_ = 0;
    }
    return text_.Number(word_++);
  }
  template <typename T>
  double Read() {
    std::array<char, sizeof(T)> raw{};
    std::memcpy(raw.data(), body_.data() + at_, sizeof(T));
    if (is_swapped_) std::reverse(raw.begin(), raw.end());
    at_ += sizeof(T);
    return static_cast<double>(std::bit_cast<T>(raw));
  }
  double NextBinary(int type) {
    ACUS_REQUIRE(body_.size() - at_ >= kTypeSizes[type], label_,
                 ": the body ends too early: cut off");
    switch (type) {
      case 0:
        return Read<std::int8_t>();
      case 1:
        return Read<std::uint8_t>();
      case 2:
        return Read<std::int16_t>();
      case 3:
        return Read<std::uint16_t>();
      case 4:
        return Read<std::int32_t>();
      case 5:
        return Read<std::uint32_t>();
      case 6:
        return Read<float>();
      default:
        return Read<double>();
    }
  }

  std::string_view body_;
  bool is_text_;
  bool is_swapped_;
  std::string label_;
  TextScanner text_;
  std::size_t word_ = 0;
  std::size_t at_ = 0;
};

struct Header {
  bool is_text = false;
  bool is_swapped = false;
  std::vector<Element> elements;
  std::size_t size = 0;
};

Header ParseHeader(std::string_view bytes, const std::string& label) {
  TextScanner lines(bytes, label);
  ACUS_REQUIRE(lines.NextLine() && lines.words()[0] == "ply", label, ": not a PLY file");
  Header out;
  while (lines.NextLine()) {
    const auto& words = lines.words();
    if (words[0] == "end_header") {
      out.size = std::min(lines.position(), bytes.size());
      return out;
    }
    if (words[0] == "format") {
      ACUS_REQUIRE(
          words.size() >= 2 && (words[1] == "ascii" || words[1] == "binary_little_endian" ||
                                words[1] == "binary_big_endian"),
          lines.Where(), ": unknown PLY encoding");
      out.is_text = words[1] == "ascii";
      out.is_swapped = words[1] == "binary_big_endian";
    } else if (words[0] == "element") {
      ACUS_REQUIRE(words.size() == 3 && lines.Whole(2) >= 0, lines.Where(), ": incomplete element");
      out.elements.push_back(
          {std::string(words[1]), static_cast<std::uint64_t>(lines.Whole(2)), {}});
    } else if (words[0] == "property") {
      ACUS_REQUIRE(!out.elements.empty(), lines.Where(), ": a property before any element");
      out.elements.back().properties.push_back(ParseProperty(lines));
    } else {
      ACUS_REQUIRE(words[0] == "comment" || words[0] == "obj_info", lines.Where(), ": '",
                   words[0].substr(0, 20), "' is not a word of a PLY header");
    }
  }
  throw InputError(Message(label, ": the PLY header has no end: cut off"));
}

void ReadElement(const Element& element, Values& values, SurfaceBuilder& builder,
                 const std::string& label) {
  const std::uint64_t least = std::max<std::uint64_t>(1, element.properties.size());
  ACUS_REQUIRE(element.count <= values.bytes_left() / least + 1, label, ": announces ",
               element.count, " of '", element.name, "', more than the file has room for");
  std::vector<long long> list;
  for (std::uint64_t row = 0; row < element.count; ++row) {
    Eigen::Vector3d x = Eigen::Vector3d::Zero();
    for (const Property& property : element.properties) {
      if (property.count_type < 0) {
        const double value = values.Next(property.value_type);
        if (property.name.size() == 1 && property.name[0] >= 'x' && property.name[0] <= 'z') {
          x[property.name[0] - 'x'] = value;
        }
        continue;
      }
      const double length = values.Next(property.count_type);
      ACUS_REQUIRE(length >= 0 && length <= static_cast<double>(values.bytes_left()), label,
                   ": a list of ", length, " values is longer than the file");
      const bool is_face = element.name == "face" && property.name.starts_with("vert");
      list.clear();
      for (double i = 0; i < length; ++i) {
        const double value = values.Next(property.value_type);
        ACUS_REQUIRE(!is_face || (value >= 0 && value < 2147483647.0), label, ": face ", row,
                     " names node ", value);
        if (is_face) list.push_back(static_cast<long long>(value));
      }
      if (is_face) builder.AddPolygon(list, Message(label, ": face ", row));
    }
    if (element.name == "vertex") builder.AddNode(x[0], x[1], x[2]);
  }
}

}  // namespace

Surface ParsePly(std::string_view bytes, const std::string& label) {
  const Header header = ParseHeader(bytes, label);
  Values values(bytes.substr(header.size), header.is_text, header.is_swapped, label);
  SurfaceBuilder builder;
  for (const Element& element : header.elements) ReadElement(element, values, builder, label);
  return builder.Finish(label);
}

}  // namespace acus::mesh
