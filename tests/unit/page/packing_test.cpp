#include "compare/page/packing.h"

#include <gtest/gtest.h>

namespace concord::compare::page {
namespace {

TEST(Packing, Base64IsThatOfRfc4648) {
  EXPECT_EQ(base64(""), "");
  EXPECT_EQ(base64("f"), "Zg==");
  EXPECT_EQ(base64("fo"), "Zm8=");
  EXPECT_EQ(base64("foo"), "Zm9v");
  EXPECT_EQ(base64("foobar"), "Zm9vYmFy");
  EXPECT_EQ(base64(std::string_view("\x00\xff\x10", 3)), "AP8Q");
}

TEST(Packing, NumbersAreSinglePrecisionLowByteFirst) {
  EXPECT_EQ(packed({1.0, -2.5}), base64(std::string_view("\x00\x00\x80\x3f\x00\x00\x20\xc0", 8)));
  EXPECT_EQ(packed({1e300}), base64(std::string_view("\x00\x00\x80\x7f", 4)));  // infinite
}

TEST(Packing, NothingEndsAScriptOrStartsMarkup) {
  const std::string safe = safe_in_script("{\"a\":\"</script><b>&\xe2\x80\xa8\"}");
  EXPECT_EQ(safe, "{\"a\":\"\\u003c/script\\u003e\\u003cb\\u003e\\u0026\\u2028\"}");
  EXPECT_EQ(escape_html("<a href=\"x\">'&"), "&lt;a href=&quot;x&quot;&gt;&#39;&amp;");
}

}  // namespace
}  // namespace concord::compare::page
