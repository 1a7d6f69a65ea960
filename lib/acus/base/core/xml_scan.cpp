#include "acus/base/core/xml_scan.h"

#include <exception>
#include <expat.h>
#include <limits>
#include <memory>
#include <new>

#include "acus/base/core/error.h"
#include "acus/base/core/words.h"

namespace acus::core {
namespace {

constexpr std::size_t kMaxDepth = 1000;
constexpr std::size_t kMaxAttributeBytes = std::size_t{64} << 20;

/// Collects what Expat reports. An exception must not pass through Expat, which is C: it is kept
/// until the parser has stopped.
class Scanner {
 public:
  Scanner(std::string_view text, const std::string& label)
      : text_(text), label_(label), parser_(XML_ParserCreate(nullptr), &XML_ParserFree) {
    if (parser_ == nullptr) throw std::bad_alloc();
    XML_SetUserData(parser_.get(), this);
    XML_SetElementHandler(
        parser_.get(),
        [](void* self, const char* name, const char** attributes) {
          static_cast<Scanner*>(self)->Guard([&](Scanner& s) { s.Open(name, attributes); });
        },
        [](void* self, const char*) {
          static_cast<Scanner*>(self)->Guard([](Scanner& s) { s.Close(); });
        });
    XML_SetCharacterDataHandler(parser_.get(), [](void* self, const char* part, int length) {
      static_cast<Scanner*>(self)->Guard([&](Scanner& s) {
        s.elements_[s.open_.back()].text.append(part, static_cast<std::size_t>(length));
      });
    });
    XML_SetEntityDeclHandler(parser_.get(), [](void* self, const char* name, int, const char*, int,
                                               const char*, const char*, const char*, const char*) {
      static_cast<Scanner*>(self)->Guard([&](Scanner& s) {
        s.Refuse("declares an entity", name, "write out what it stands for");
      });
    });
  }

  std::vector<XmlElement> Scan() {
    ACUS_REQUIRE(text_.size() <= std::numeric_limits<int>::max(), label_, ": is ", text_.size(),
                 " bytes of XML; at most 2 GB are read");
    const bool is_read = XML_Parse(parser_.get(), text_.data(), static_cast<int>(text_.size()),
                                   /*isFinal=*/XML_TRUE) == XML_STATUS_OK;
    if (failure_) std::rethrow_exception(failure_);
    if (!is_read) RefuseSyntax();
    return std::move(elements_);
  }

 private:
  /// Nothing once something has failed: the parser may report a little more before it stops.
  template <class F>
  void Guard(const F& handle) {
    if (failure_) return;
    try {
      handle(*this);
    } catch (...) {
      failure_ = std::current_exception();
      XML_StopParser(parser_.get(), /*resumable=*/XML_FALSE);
    }
  }

  void Open(const char* name, const char** attributes) {
    if (open_.size() >= kMaxDepth) {
      Refuse("nests its elements too deeply, at", name,
             Message("at most ", kMaxDepth, " are read"));
    }
    XmlElement element;
    element.name = name;
    element.depth = static_cast<int>(open_.size());
    for (; *attributes != nullptr; attributes += 2) {
      const std::string_view value = attributes[1];
      if (value.size() > kMaxAttributeBytes) {
        Refuse(Message("has ", value.size(), " bytes in attribute"), attributes[0],
               Message("at most ", kMaxAttributeBytes, " are read"));
      }
      element.attributes.emplace_back(attributes[0], value);
    }
    open_.push_back(elements_.size());
    elements_.push_back(std::move(element));
  }

  void Close() {
    std::string& text = elements_[open_.back()].text;
    text = std::string(Trimmed(text));
    open_.pop_back();
  }

  std::string Place() const {
    return Message(label_, ":", XML_GetCurrentLineNumber(parser_.get()));
  }

  [[noreturn]] void Refuse(const std::string& what, std::string_view name,
                           const std::string& advice) const {
    throw InputError(Message(Place(), ": the XML ", what, " '", name, "'; ", advice));
  }

  [[noreturn]] void RefuseSyntax() const {
    const XML_Error error = XML_GetErrorCode(parser_.get());
    if (error == XML_ERROR_NO_MEMORY) throw std::bad_alloc();
    const bool ends = error == XML_ERROR_NO_ELEMENTS;
    const bool may_be_cut = ends || error == XML_ERROR_UNCLOSED_TOKEN;
    const std::string what =
        ends ? "the file ends early, or has no element" : XML_ErrorString(error);
    const std::string inside =
        open_.empty() ? "" : Message(", inside <", elements_[open_.back()].name, ">");
    throw InputError(
        Message(Place(), ": is not valid XML: ", what, inside, " (column ",
                XML_GetCurrentColumnNumber(parser_.get()) + 1,
                may_be_cut ? "); is the file cut off?" : "); is it damaged, or of another kind?"));
  }

  std::string_view text_;
  const std::string& label_;
  std::unique_ptr<XML_ParserStruct, decltype(&XML_ParserFree)> parser_;
  std::vector<XmlElement> elements_;
  std::vector<std::size_t> open_;  ///< Of elements_, from the root inwards.
  std::exception_ptr failure_;
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
