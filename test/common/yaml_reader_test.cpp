#include "sinew/common/yaml_reader.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "common/complaint.h"

namespace sinew {
namespace {

YamlReader readText(const std::string& text) {
  return YamlReader::fromText(text, "some/robot.yaml");
}

TEST(YamlReader, ReadsEveryKindOfValue) {
  const YamlReader yaml = readText(
      "number: -1.5e-3\npositive: 2\ninteger: -4\nflag: yes\ntext: a word\nchoice: blue\nvec3: [1, 2.5, -3e1]\n"
      "points: [[0, 0, 1], [0, 2, 0]]\nintegers: [3, 1]\ntexts: [x, '12']\nmap: {inner: 6}\nmaps: [{a: 1}, {a: 2}]\n");
  EXPECT_EQ(yaml.number("number"), -1.5e-3);
  EXPECT_EQ(yaml.positive("positive"), 2);
  EXPECT_EQ(yaml.integer("integer", -10, 10), -4);
  EXPECT_TRUE(yaml.flagOr("flag", false));
  EXPECT_EQ(yaml.text("text"), "a word");
  EXPECT_EQ(yaml.choiceOr("choice", {"red", "blue"}, 0), 1);
  EXPECT_EQ(yaml.vec3("vec3"), Vec3(1, 2.5, -30));
  EXPECT_EQ(yaml.vec3List("points"), (std::vector<Vec3>{Vec3(0, 0, 1), Vec3(0, 2, 0)}));
  EXPECT_EQ(yaml.integerList("integers", 0, 3), (std::vector<int>{3, 1}));
  EXPECT_EQ(yaml.textList("texts"), (std::vector<std::string>{"x", "12"}));
  EXPECT_EQ(readText("a: [[x, y], []]").textLists("a"), (std::vector<std::vector<std::string>>{{"x", "y"}, {}}));
  EXPECT_TRUE(yaml.isList("texts"));
  EXPECT_FALSE(yaml.isList("map"));
  EXPECT_EQ(yaml.map("map").number("inner"), 6);
  ASSERT_EQ(yaml.maps("maps").size(), 2U);
  EXPECT_EQ(yaml.maps("maps")[1].number("a"), 2);
  EXPECT_EQ(complaintOf([&] { yaml.refuseUnknownKeys(); }), "");
}

TEST(YamlReader, FallsBackOnlyWhereAKeyIsMissingOrEmpty) {
  const YamlReader yaml = readText("present: 3\nempty:\n");
  for (const char* key : {"missing", "empty"}) {
    EXPECT_FALSE(yaml.has(key));
    EXPECT_EQ(yaml.numberOr(key, 1.5), 1.5);
    EXPECT_EQ(yaml.positiveOr(key, 2.5), 2.5);
    EXPECT_EQ(yaml.integerOr(key, 4, 0, 9), 4);
    EXPECT_TRUE(yaml.flagOr(key, true));
    EXPECT_EQ(yaml.textOr(key, "word"), "word");
    EXPECT_EQ(yaml.choiceOr(key, {"a", "b"}, 1), 1);
    EXPECT_EQ(yaml.vec3Or(key, Vec3(1, 2, 3)), Vec3(1, 2, 3));
    EXPECT_TRUE(yaml.maps(key).empty());
  }
  EXPECT_TRUE(yaml.has("present"));
  EXPECT_EQ(yaml.numberOr("present", 1.5), 3);
  EXPECT_EQ(yaml.positiveOr("present", 1.5), 3);
  EXPECT_EQ(yaml.integerOr("present", 1, 0, 9), 3);
}

TEST(YamlReader, TakesInfinityWhereThereIsNoLimit) {
  const YamlReader yaml = readText("up: .inf\ndown: -.inf\n");
  EXPECT_EQ(yaml.number("up"), YamlReader::kInfinity);
  EXPECT_EQ(yaml.number("up", 0), YamlReader::kInfinity);
  EXPECT_EQ(yaml.number("down"), -YamlReader::kInfinity);
  EXPECT_NE(complaintOf([&] { yaml.number("up", 0, 10); }), "");
  EXPECT_NE(complaintOf([&] { yaml.number("down", 0); }), "");
  EXPECT_NE(complaintOf([&] { yaml.positive("up"); }), "");
}

TEST(YamlReader, LimitsAreInclusive) {
  const YamlReader yaml = readText("n: 2\n");
  EXPECT_EQ(yaml.number("n", 2, 2), 2);
  EXPECT_EQ(yaml.integer("n", 2, 2), 2);
  EXPECT_NE(complaintOf([&] { yaml.number("n", 2.001, 3); }), "");
  EXPECT_NE(complaintOf([&] { yaml.integer("n", 0, 1); }), "");
}

struct Complaint {
  const char* text;
  std::function<void(const YamlReader&)> read;
  const char* expected;  ///< after the name of the file
};

class YamlComplaint : public testing::TestWithParam<Complaint> {};

TEST_P(YamlComplaint, NamesFileKeyValueAndWhatWouldBeRight) {
  const YamlReader yaml = readText(GetParam().text);
  EXPECT_EQ(complaintOf([&] { GetParam().read(yaml); }), std::string("some/robot.yaml: ") + GetParam().expected);
}

INSTANTIATE_TEST_SUITE_P(
    Numbers, YamlComplaint,
    testing::Values(
        Complaint{"b: 1", [](const YamlReader& y) { y.number("a"); }, "a: found nothing, expected a number"},
        Complaint{"a:", [](const YamlReader& y) { y.number("a"); }, "a: found an empty value, expected a number"},
        Complaint{"a: 5 mm", [](const YamlReader& y) { y.number("a", 0); }, "a: found '5 mm', expected a number >= 0"},
        Complaint{"a: 1,5", [](const YamlReader& y) { y.number("a", -YamlReader::kInfinity, 3); },
                  "a: found '1,5', expected a number <= 3"},
        Complaint{"a: .nan", [](const YamlReader& y) { y.number("a"); }, "a: found '.nan', expected a number"},
        Complaint{"a: 0.5", [](const YamlReader& y) { y.number("a", -0.99, 0.4999); },
                  "a: found '0.5', expected a number from -0.99 to 0.4999"},
        Complaint{"a: [1]", [](const YamlReader& y) { y.number("a"); }, "a: found [1], expected a number"},
        Complaint{"a: 0", [](const YamlReader& y) { y.positive("a"); }, "a: found '0', expected a number > 0"},
        Complaint{"a: 1.5", [](const YamlReader& y) { y.integer("a", 1, 9); },
                  "a: found '1.5', expected a whole number from 1 to 9"},
        Complaint{"a: 99999999999", [](const YamlReader& y) { y.integerOr("a", 1, 1, 9); },
                  "a: found '99999999999', expected a whole number from 1 to 9"}));

INSTANTIATE_TEST_SUITE_P(
    Others, YamlComplaint,
    testing::Values(
        Complaint{"a: perhaps", [](const YamlReader& y) { y.flagOr("a", true); },
                  "a: found 'perhaps', expected true or false"},
        Complaint{"a: [x]", [](const YamlReader& y) { y.text("a"); }, "a: found [x], expected a text"},
        Complaint{"a: ''", [](const YamlReader& y) { y.text("a"); }, "a: found '', expected a text"},
        Complaint{"a: green",
                  [](const YamlReader& y) {
                    y.choiceOr("a", {"red", "blue"}, 0);
                  },
                  "a: found 'green', expected one of red, blue"},
        Complaint{"a: [1, 2]", [](const YamlReader& y) { y.vec3("a"); },
                  "a: found [1, 2], expected [x, y, z], three finite numbers"},
        Complaint{"a: [1, .inf, 2]", [](const YamlReader& y) { y.vec3("a"); },
                  "a: found [1, .inf, 2], expected [x, y, z], three finite numbers"},
        Complaint{"a: 7", [](const YamlReader& y) { y.vec3List("a"); }, "a: found '7', expected a list of [x, y, z]"},
        Complaint{"a: [[1, 2, 3], [4, 5]]", [](const YamlReader& y) { y.vec3List("a"); },
                  "a[1]: found [4, 5], expected [x, y, z]"},
        Complaint{"a: [2, -1]", [](const YamlReader& y) { y.integerList("a", 0, 9); },
                  "a[1]: found '-1', expected a list of whole numbers from 0 to 9"},
        Complaint{"a: [x, [y]]", [](const YamlReader& y) { y.textList("a"); },
                  "a: found [x, [y]], expected a list of texts"},
        Complaint{"a: [[x], y]", [](const YamlReader& y) { y.textLists("a"); },
                  "a: found [[x], y], expected a list of lists of texts"},
        Complaint{"a: [[x, [y]]]", [](const YamlReader& y) { y.textLists("a"); },
                  "a: found [[x, [y]]], expected a list of lists of texts"},
        Complaint{"a: 1", [](const YamlReader& y) { y.map("a"); }, "a: found '1', expected a mapping"},
        Complaint{"a: {b: 1}", [](const YamlReader& y) { y.maps("a"); },
                  "a: found {b: 1}, expected a list of mappings"},
        Complaint{"a: [{b: 1}, 2]", [](const YamlReader& y) { y.maps("a"); }, "a[1]: found '2', expected a mapping"}));

INSTANTIATE_TEST_SUITE_P(
    Nested, YamlComplaint,
    testing::Values(Complaint{"a: {b: {c: x}}", [](const YamlReader& y) { y.map("a").map("b").number("c"); },
                              "a.b.c: found 'x', expected a number"},
                    Complaint{"cables: [{}, {}, {tension: {max: -2}}]",
                              [](const YamlReader& y) { y.maps("cables")[2].map("tension").positive("max"); },
                              "cables[2].tension.max: found '-2', expected a number > 0"},
                    Complaint{"cables: [{points: [[0, 0, 0], x]}]",
                              [](const YamlReader& y) { y.maps("cables")[0].vec3List("points"); },
                              "cables[0].points[1]: found 'x', expected [x, y, z]"},
                    Complaint{"a: {good: 1, godo: 2}",
                              [](const YamlReader& y) {
                                const YamlReader a = y.map("a");
                                a.numberOr("good", 0);
                                a.refuseUnknownKeys();
                              },
                              "a.godo: found an unknown key, expected only these keys: good"},
                    Complaint{"a: 1\nb: 2\na: 3",
                              [](const YamlReader& y) {
                                y.number("a");
                                y.number("b");
                                y.refuseUnknownKeys();
                              },
                              "a: found the key twice, expected each key once"}));

TEST(YamlReader, CutsAVeryLongValue) {
  std::string items = "0";
  for (int i = 1; i < 100; ++i) items += ", " + std::to_string(i);
  const std::string complaint = complaintOf([&] { readText("a: [" + items + "]").number("a"); });
  EXPECT_NE(complaint.find("..., expected a number"), std::string::npos) << complaint;
  EXPECT_LT(complaint.size(), 140U);
}

TEST(YamlReader, RefusesWhatIsNoMappingOrNoYaml) {
  EXPECT_NE(complaintOf([] { readText("- 1\n- 2\n"); }).find("expected a mapping of keys"), std::string::npos);
  EXPECT_NE(complaintOf([] { readText(""); }).find("found an empty value"), std::string::npos);
  EXPECT_NE(complaintOf([] { readText("a: [1, 2\n"); }).find("expected valid YAML"), std::string::npos);
  EXPECT_EQ(complaintOf([] { YamlReader::fromFile("no/such.yaml"); }),
            "no/such.yaml: found no readable file, expected a YAML file");
  EXPECT_NE(complaintOf([] { YamlReader::fromFile(SINEW_SOURCE_DIR); }).find("found a folder"), std::string::npos);
}

TEST(YamlReader, PathsAreRelativeToTheirFile) {
  EXPECT_EQ(readText("mesh: a/b.msh").path("mesh"), "some/a/b.msh");
  EXPECT_EQ(readText("mesh: /a/b.msh").path("mesh"), "/a/b.msh");
  EXPECT_EQ(YamlReader::fromText("mesh: b.msh", "robot.yaml").path("mesh"), "b.msh");
}

}  // namespace
}  // namespace sinew
