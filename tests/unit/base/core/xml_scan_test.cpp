#include "acus/base/core/xml_scan.h"

#include <gmock/gmock.h>

#include "acus/base/core/error.h"

namespace acus::core {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

void ExpectRefused(const std::string& text, const char* message) {
  EXPECT_THAT([&] { ScanXml(text, "t.xml"); }, ThrowsMessage<InputError>(HasSubstr(message)))
      << text.substr(0, 200);
}

TEST(Xml, ReadsElementsInOrderWithDepthAndAttributes) {
  const auto elements = ScanXml(
      "<?xml version='1.0'?><a x='1'><!-- <c/> --><b "
      "y=\"&lt;&quot;&amp;&gt;&apos;&#65;\"/>text</a>",
      "t");
  ASSERT_EQ(elements.size(), 2U);
  EXPECT_EQ(elements[0].name, "a");
  EXPECT_EQ(elements[0].depth, 0);
  EXPECT_EQ(elements[1].name, "b");
  EXPECT_EQ(elements[1].depth, 1);
  EXPECT_EQ(elements[0].Attribute("x"), "1");
  EXPECT_EQ(elements[0].Attribute("y"), std::nullopt);
  EXPECT_EQ(elements[1].Attribute("y"), "<\"&>'A");
}

TEST(Xml, KeepsTheTextDirectlyInsideAnElementWithoutBlanksAroundIt) {
  const auto elements = ScanXml("<a> one <b><![CDATA[x < y]]></b> two\n</a>", "t");
  EXPECT_EQ(elements[0].text, "one  two");
  EXPECT_EQ(elements[1].text, "x < y");
}

TEST(Xml, LineEndsAndTabsInAttributesAreBlanks) {
  const auto elements = ScanXml("<a x='1 0\r\n\t0 1\n'/>", "t");
  EXPECT_EQ(elements[0].Attribute("x"), "1 0  0 1 ");
}

TEST(Xml, ReadsTextOfTheDeclaredEncodingAsUtf8) {
  const auto elements = ScanXml("<?xml version='1.0' encoding='ISO-8859-1'?><a x='\xE4'/>", "t");
  EXPECT_EQ(elements[0].Attribute("x"), "\xC3\xA4");
  ExpectRefused("<a x='\xE4'/>", "t.xml:1: is not valid XML");
}

TEST(Xml, NamesLineAndTroubleOfWhatIsNotXml) {
  ExpectRefused("", "t.xml:1: is not valid XML: the file ends early, or has no element");
  ExpectRefused("<a>\n<b>\n</a>",
                "t.xml:3: is not valid XML: mismatched tag, inside <b> (column 3)");
  ExpectRefused("<a>", "ends early, or has no element, inside <a>");
  ExpectRefused("</a>", "not well-formed");
  ExpectRefused("<a x></a>", "not well-formed");
  ExpectRefused("<a x=1></a>", "not well-formed");
  ExpectRefused("<a x='1></a>", "not well-formed");
  ExpectRefused("<a x='1", "unclosed token");
  ExpectRefused("<a x='1' x='2'/>", "duplicate attribute");
  ExpectRefused("<a><!-- </a>", "unclosed token, inside <a>");
  ExpectRefused("< a/>", "not well-formed");
  ExpectRefused("<a/>\n<b/>", "t.xml:2: is not valid XML: junk after document element");
  ExpectRefused("<a x='&nbsp;'/>", "undefined entity");
}

TEST(Xml, RefusesTooManyNestedElements) {
  std::string deep;
  for (int i = 0; i < 1000; ++i) deep += "<a>";
  std::string closed = deep;
  for (int i = 0; i < 1000; ++i) closed += "</a>";
  EXPECT_EQ(ScanXml(closed, "t").size(), 1000U);
  ExpectRefused(deep + "\n<b/>", "t.xml:2: the XML nests its elements too deeply, at 'b'");
}

TEST(Xml, RefusesEntitiesOfItsOwn) {
  // Ten levels of ten copies: a kilobyte that stands for ten gigabytes.
  std::string text = "<!DOCTYPE a [\n<!ENTITY e0 'ha'>\n";
  for (int i = 1; i < 10; ++i) {
    text += "<!ENTITY e" + std::to_string(i) + " '";
    for (int k = 0; k < 10; ++k) text += "&e" + std::to_string(i - 1) + ";";
    text += "'>\n";
  }
  ExpectRefused(text + "]><a x='&e9;'/>", "t.xml:2: the XML declares an entity 'e0'; write out");
  ExpectRefused("<!DOCTYPE a [<!ENTITY f SYSTEM 'other.xml'>]><a>&f;</a>",
                "declares an entity 'f'");
  EXPECT_EQ(ScanXml("<!DOCTYPE a><a/>", "t").size(), 1U);
}

TEST(Xml, RefusesAttributesAboveTheirBound) {
  std::string text = "<a x='";
  text.append((std::size_t{64} << 20) + 1, 'y');
  ExpectRefused(text + "'/>", "t.xml:1: the XML has 67108865 bytes in attribute 'x'; at most");
}

}  // namespace
}  // namespace acus::core
