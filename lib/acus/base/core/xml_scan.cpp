#include "acus/base/core/xml_scan.h"

#include <algorithm>
#include <array>

#include "acus/base/core/error.h"

namespace acus::core {
namespace {

constexpr std::size_t kMaxDepth = 1000;
constexpr std::string_view kBlank = " \t\r\n";

class Scanner {
 public:
  Scanner(std::string_view text, const std::string& label) : text_(text), label_(label) {}

  std::vector<XmlElement> Scan() {
    while (SkipToTag()) {
      if (Skip("<!--")) {
        SkipPast("-->");
      } else if (Skip("<?")) {
        SkipPast("?>");
      } else if (Skip("<![CDATA[")) {
        SkipPast("]]>");
      } else if (Skip("<!")) {
        SkipPast(">");
      } else if (Skip("</")) {
        CloseElement();
      } else {
        ++at_;
        OpenElement();
      }
    }
    Require(open_.empty() && !elements_.empty(), "the file ends early, or has no element");
    return std::move(elements_);
  }

 private:
  bool SkipToTag() {
    at_ = std::min(text_.find('<', at_), text_.size());
    return at_ < text_.size();
  }

  bool Skip(std::string_view word) {
    if (!text_.substr(at_).starts_with(word)) return false;
    at_ += word.size();
    return true;
  }

  void SkipPast(std::string_view word) {
    const std::size_t found = text_.find(word, at_);
    Require(found != text_.npos, "something is not closed");
    at_ = found + word.size();
  }

  void SkipBlank() { at_ = std::min(text_.find_first_not_of(kBlank, at_), text_.size()); }

  std::string_view Name() {
    const std::size_t end = std::min(text_.find_first_of(" \t\r\n=<>/\"'", at_), text_.size());
    const std::string_view name = text_.substr(at_, end - at_);
    Require(!name.empty(), "a name is expected");
    at_ = end;
    return name;
  }

  void OpenElement() {
    XmlElement element;
    element.name = Name();
    element.depth = static_cast<int>(open_.size());
    for (;;) {
      SkipBlank();
      if (Skip("/>")) break;
      if (Skip(">")) {
        Require(open_.size() < kMaxDepth, "the elements are nested too deeply");
        open_.push_back(element.name);
        break;
      }
      std::string key(Name());
      SkipBlank();
      Require(Skip("="), "an attribute has no value");
      SkipBlank();
      element.attributes.emplace_back(std::move(key), Value());
    }
    elements_.push_back(std::move(element));
  }

  void CloseElement() {
    const std::string_view name = Name();
    SkipBlank();
    Require(!open_.empty() && open_.back() == name && Skip(">"), "an element is closed wrongly");
    open_.pop_back();
  }

  std::string Value() {
    Require(at_ < text_.size() && (text_[at_] == '"' || text_[at_] == '\''),
            "the value of an attribute must stand in quotes");
    const std::size_t end = text_.find(text_[at_], at_ + 1);
    Require(end != text_.npos, "a quote is not closed");
    const std::string_view raw = text_.substr(at_ + 1, end - at_ - 1);
    at_ = end + 1;
    return Unescaped(raw);
  }

  static std::string Unescaped(std::string_view raw) {
    static constexpr std::array<std::pair<std::string_view, char>, 5> kEntities = {
        {{"amp", '&'}, {"lt", '<'}, {"gt", '>'}, {"quot", '"'}, {"apos", '\''}}};
    std::string text;
    text.reserve(raw.size());
    for (std::size_t i = 0; i < raw.size(); ++i) {
      const std::size_t end = raw[i] == '&' ? raw.find(';', i) : raw.npos;
      const std::string_view name = end == raw.npos ? "" : raw.substr(i + 1, end - i - 1);
      const auto entity =
          std::ranges::find(kEntities, name, &std::pair<std::string_view, char>::first);
      if (entity == kEntities.end()) {
        text += raw[i];  // Also what is not an entity that we know: file names hold plain '&'.
      } else {
        text += entity->second;
        i = end;
      }
    }
    return text;
  }

  void Require(bool holds, const char* what) const {
    if (holds) return;
    const auto line =
        1 + std::count(text_.begin(), text_.begin() + std::min(at_, text_.size()), '\n');
    throw InputError(Message(label_, ":", line, ": is not valid XML: ", what,
                             "; is the file cut off or of another kind?"));
  }

  std::string_view text_;
  const std::string& label_;
  std::size_t at_ = 0;
  std::vector<XmlElement> elements_;
  std::vector<std::string> open_;
};

}  // namespace

std::optional<std::string> XmlElement::Attribute(std::string_view key) const {
  for (const auto& [given, value] : attributes) {
    if (given == key) return value;
  }
  return {};
}

std::vector<XmlElement> ScanXml(std::string_view text, const std::string& label) {
  return Scanner(text, label).Scan();
}

}  // namespace acus::core
