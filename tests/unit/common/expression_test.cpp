#include "common/reading/expression.h"

#include <gmock/gmock.h>

#include <cmath>
#include <numbers>

namespace concord {
namespace {

using ::testing::HasSubstr;

constexpr double kDegree = std::numbers::pi / 180.0;

std::string expression_complaint(const std::string& expression, const Parameters& parameters = {}) {
  try {
    (void)parameters.evaluate(expression);
  } catch (const ExpressionError& error) {
    return error.what();
  }
  return "none";
}

TEST(Expression, ReadsDegreesWithAndWithoutAProductSign) {
  const Parameters none;
  EXPECT_DOUBLE_EQ(none.evaluate("20 deg"), 20.0 * kDegree);
  EXPECT_DOUBLE_EQ(none.evaluate("20deg"), 20.0 * kDegree);
  EXPECT_DOUBLE_EQ(none.evaluate("20*deg"), 20.0 * kDegree);
  EXPECT_DOUBLE_EQ(none.evaluate("-1.5e1 deg"), -15.0 * kDegree);
  EXPECT_DOUBLE_EQ(none.evaluate("(10 + 20) deg"), 30.0 * kDegree);
  EXPECT_DOUBLE_EQ(none.evaluate("deg"), kDegree);
  EXPECT_DOUBLE_EQ(none.evaluate("3. deg"), 3.0 * kDegree);
}

TEST(Expression, RefusesAUnitOfAUnit) { EXPECT_NE(expression_complaint("20 deg deg"), "none"); }

TEST(Expression, KnowsFunctionsAndPi) {
  const Parameters none;
  EXPECT_DOUBLE_EQ(none.evaluate("2*pi"), 2.0 * std::numbers::pi);
  EXPECT_DOUBLE_EQ(none.evaluate("sin(30 deg) + sqrt(9)^2"), 9.5);
  EXPECT_DOUBLE_EQ(none.evaluate("atan2(1, -1)"), std::atan2(1.0, -1.0));
  EXPECT_DOUBLE_EQ(none.evaluate("cos(1) + tan(0.5) + asin(0.3) + acos(0.2) + atan(2) + exp(0.1) + ln(3) + abs(-4)"),
                   std::cos(1.0) + std::tan(0.5) + std::asin(0.3) + std::acos(0.2) + std::atan(2.0) + std::exp(0.1) +
                       std::log(3.0) + 4.0);
  EXPECT_DOUBLE_EQ(none.evaluate("min(3, 1, 2) + 10 * max(1, 7)"), 71.0);
}

TEST(Expression, KnowsNoNumberOrFunctionBesides) {
  for (const char* other : {"_pi", "_e", "log(10)", "rint(2.5)", "sinh(1)", "sum(1, 2)"}) {
    EXPECT_NE(expression_complaint(other), "none") << other;
  }
}

TEST(Parameters, ResolveInAnyOrder) {
  std::vector<Diagnostic> complaints;
  const Parameters parameters({{"a", "2*b + c", {}}, {"b", "L/2", {}}, {"c", 5.0, {}}, {"L", "sin(30 deg)", {}}},
                              complaints);
  EXPECT_TRUE(complaints.empty());
  EXPECT_DOUBLE_EQ(parameters.evaluate("a"), 5.5);
  EXPECT_DOUBLE_EQ(parameters.evaluate("a deg"), 5.5 * kDegree);
  const Parameters named({{"phi1", 0.5, {}}, {"phi1deg", 30.0, {}}, {"_2deg", 7.0, {}}}, complaints);
  EXPECT_DOUBLE_EQ(named.evaluate("phi1deg + _2deg"), 37.0);  // names of their own, and no products
  EXPECT_DOUBLE_EQ(named.evaluate("phi1 deg + 1e1deg"), 10.5 * kDegree);
}

TEST(Parameters, NameACircleAndStaySilentAboutItsConsequences) {
  std::vector<Diagnostic> complaints;
  const Parameters parameters({{"a", "b + 1", {}}, {"b", "2*c", {}}, {"c", "b^2", {}}, {"d", "a", {}}}, complaints);
  ASSERT_EQ(complaints.size(), 1U);
  EXPECT_EQ(complaints.front().message, "parameter 'c': goes round in a circle: b -> c -> b");
  EXPECT_EQ(expression_complaint("d", parameters), "");
}

TEST(Parameters, MayReferToEachOtherAsDeepAsTheyLike) {
  constexpr int kMany = 30000;
  std::vector<ParameterDefinition> chain{{"p0", "p1 + 2", {}}};
  for (int k = 1; k < kMany; ++k) {
    chain.push_back({"p" + std::to_string(k), "p" + std::to_string(k + 1) + " + 2", {}});
  }
  chain.push_back({"p" + std::to_string(kMany), 5.0, {}});
  std::vector<Diagnostic> complaints;
  EXPECT_DOUBLE_EQ(Parameters(chain, complaints).evaluate("p0"), 5.0 + 2.0 * kMany);
  EXPECT_TRUE(complaints.empty());
  chain.back().value = "3*p7";
  const Parameters circle(chain, complaints);
  ASSERT_EQ(complaints.size(), 1U);
  EXPECT_EQ(complaints.front().message,
            "parameter 'p30000': goes round in a circle: p7 -> p8 -> p9 -> p10 -> p11 -> ... -> p29996 -> p29997 -> "
            "p29998 -> p29999 -> p30000 -> p7");
  EXPECT_EQ(expression_complaint("p0", circle), "");
}

TEST(Parameters, OfTheIncludingFileAreBehindTheOwnOnes) {
  std::vector<Diagnostic> complaints;
  const Parameters outer({{"a", 2.0, {}}, {"b", 3.0, {}}}, complaints);
  const Parameters inner({{"b", "a*5", {}}, {"c", "d", {}}}, complaints, outer);
  EXPECT_DOUBLE_EQ(inner.evaluate("a + b"), 12.0);
  EXPECT_DOUBLE_EQ(outer.evaluate("a + b"), 5.0);
  ASSERT_EQ(complaints.size(), 1U);
  EXPECT_EQ(complaints.front().message, "parameter 'c': unknown name 'd' in 'd': known parameters: a, b, c");
}

TEST(Expression, HasLimits) {
  EXPECT_EQ(expression_complaint(std::string(10001, '1')),
            "an expression of 10001 characters is too long: at most 10000 are allowed");
  const std::string open(4000, '(');
  EXPECT_DOUBLE_EQ(Parameters{}.evaluate(open + "7" + std::string(4000, ')')), 7.0);
  EXPECT_EQ(expression_complaint(open), "cannot read '" + std::string(120, '(') +
                                            "...': Unexpected end of expression "
                                            "at position 4001");
  std::vector<Diagnostic> complaints;
  const Parameters parameters({{"L", 2.0, {}}}, complaints);
  EXPECT_EQ(expression_complaint("20L", parameters), "cannot read '20L': Unexpected value \"L\" found at position 2");
}

TEST(Parameters, RefuseNamesThatMeanSomethingElse) {
  std::vector<Diagnostic> complaints;
  const Parameters parameters({{"pi", 3.0, {}}, {"cos", 1.0, {}}, {"a-b", 1.0, {}}}, complaints);
  ASSERT_EQ(complaints.size(), 3U);
  EXPECT_EQ(complaints[0].message, "parameter 'pi': the name already means something in expressions: choose another");
  EXPECT_EQ(complaints[2].message,
            "parameter 'a-b': the name must consist of letters, digits and underscores, not a digit first");
}

TEST(Expression, SaysWhatIsWrong) {
  std::vector<Diagnostic> complaints;
  const Parameters parameters({{"length", 2.0, {}}}, complaints);
  EXPECT_EQ(expression_complaint("lenght*2", parameters),
            "unknown name 'lenght' in 'lenght*2': did you mean 'length'?");
  EXPECT_EQ(expression_complaint("x"), "unknown name 'x' in 'x': there are no parameters");
  EXPECT_EQ(expression_complaint("1, 2"), "'1, 2' must be one number");
  EXPECT_EQ(expression_complaint("(1"), "cannot read '(1': Missing parenthesis");
  EXPECT_EQ(expression_complaint(""), "cannot read '': Expression is empty");
  EXPECT_EQ(expression_complaint("length = 3", parameters),
            "cannot read 'length = 3': there is no operator '=' here, only + - * / ^ and parentheses");
  for (const char* other : {"1<2", "1?2:3", "1&&1", "1==1", "!1"}) {
    EXPECT_THAT(expression_complaint(other), ::testing::HasSubstr("only + - * / ^ and parentheses")) << other;
  }
  EXPECT_EQ(expression_complaint("cos (0)"),
            "unknown name 'cos' in 'cos (0)': it is a function, whose argument stands in parentheses right behind it");
}

TEST(Expression, SaysHowItIsWrittenHere) {
  const std::pair<const char*, const char*> cases[] = {
      {"\u22121", "write '-'"},       {"2 \u2013 1", "write '-'"},
      {"2 \u00d7 3", "written '*'"},  {"2**3", "written '^'"},
      {"3\u00b2", "written '^2'"},    {"20\u00b0", "written 'deg'"},
      {"20 \u00b0", "written 'deg'"}, {"2 \u03c0", "write 'pi'"},
      {"5 %", "0.05 for 5 %"},        {"1\u00a0+ 2", "usual"},
      {"log(2)", "is 'ln'"},          {"0.5 * rad", "in radians"},
      {"pow(2, 3)", "written '^'"},   {"90 * degrees", "written 'deg'"},
      {"2 * PI", "write 'pi'"},       {"1.2 * kg", "SI units"}};
  for (const auto& [expression, hint] : cases)
    EXPECT_THAT(expression_complaint(expression), HasSubstr(hint)) << expression;
}

TEST(Expression, WritesNumbersThatAreNotFinite) {
  EXPECT_EQ(not_finite_text(std::sqrt(-1.0)), "nan");
  EXPECT_EQ(not_finite_text(-1.0 / 0.0), "-inf");
}

}  // namespace
}  // namespace concord
