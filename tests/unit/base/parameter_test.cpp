#include "base/parameter.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace metrolux::core {
namespace {

using testing::HasSubstr;

enum class Color { Red, Green };

struct Group {
    double width = 0.5;
    template <class V>
    void visit(V&& v) {
        v({"width", "breadth"}, width, Range::between(0, 1), "how wide");
    }
};

struct Example {
    Group group;
    int count = 0;
    bool on = true;
    Color color = Color::Green;
    std::string letters = "abc";
    template <class V>
    void visit(V&& v) {
        v(group);
        v("count", count, Range::between(0, 9).zeroIs("as many as fit"), "how many");
        v("on", on, Flag{}, "whether");
        v("color", color, Choices<Color>{{{"red", Color::Red}, {"green", Color::Green}}}, "which");
        v("letters", letters, Letters{"abc"}, "some");
    }
};

std::string errorOf(ParameterSet& set, const std::string& name, const ParameterValue& value) {
    try {
        set.set(name, value);
    } catch (const Error& error) {
        return error.what();
    }
    return "";
}

TEST(Parameters, AreListedWithDefaultsRangesAndHelp) {
    const std::vector<ParameterInfo> list = parametersOf<Example>();
    ASSERT_EQ(list.size(), 5u);
    EXPECT_EQ(list[0].name, "width");
    EXPECT_EQ(list[0].alias, "breadth");
    EXPECT_EQ(list[0].type, ParameterType::Real);
    EXPECT_EQ(list[0].defaultValue, ParameterValue(0.5));
    EXPECT_EQ(list[0].least, 0);
    EXPECT_EQ(list[0].most, 1);
    EXPECT_EQ(list[0].help, "how wide");
    EXPECT_EQ(list[0].expected, "a number from 0 to 1");
    EXPECT_EQ(list[1].type, ParameterType::Integer);
    EXPECT_EQ(list[1].defaultText(), "0: as many as fit");
    EXPECT_EQ(list[2].type, ParameterType::Boolean);
    EXPECT_EQ(list[3].type, ParameterType::Text);
    EXPECT_EQ(list[3].choices, (std::vector<std::string>{"red", "green"}));
    EXPECT_EQ(list[3].placeholder, "red|green");
    EXPECT_EQ(list[4].expected, "some of the letters a, b, c");
}

TEST(Parameters, AreSetFromTextAndFromTypedValues) {
    const std::vector<ParameterInfo> list = parametersOf<Example>();
    ParameterSet set(list);
    EXPECT_EQ(set.as<Example>().group.width, 0.5) << "the default";
    set.set("width", 0.25);
    set.set("count", "7");
    set.set("on", "false");
    set.set("color", "red");
    set.set("letters", "ca");
    const Example e = set.as<Example>();
    EXPECT_EQ(e.group.width, 0.25);
    EXPECT_EQ(e.count, 7);
    EXPECT_FALSE(e.on);
    EXPECT_EQ(e.color, Color::Red);
    EXPECT_EQ(e.letters, "ac") << "one form for all orders";
    EXPECT_EQ(set.get("count"), ParameterValue(7)) << "in the parameter's own type";
    set.set("width", 1);
    EXPECT_EQ(set.get("width"), ParameterValue(1.0)) << "whole numbers are numbers";
    EXPECT_EQ(set.as<Group>().width, 1) << "a part of the parameters";
    EXPECT_EQ(set.findByAnyName("breadth"), set.find("width"));
    EXPECT_EQ(set.find("breadth"), nullptr);
}

TEST(Parameters, WrongValuesNameTheParameterWhatWasFoundAndWhatWasExpected) {
    const std::vector<ParameterInfo> list = parametersOf<Example>();
    ParameterSet set(list);
    EXPECT_EQ(errorOf(set, "width", 1.5), "width: found '1.5', expected a number from 0 to 1");
    for (const ParameterValue& bad : {ParameterValue("1x"), ParameterValue(""), ParameterValue(true),
                                      ParameterValue(-1), ParameterValue("nan"), ParameterValue("inf")})
        EXPECT_THAT(errorOf(set, "width", bad), HasSubstr("expected a number from 0 to 1")) << toText(bad);
    for (const ParameterValue& bad : {ParameterValue(2.5), ParameterValue("2.5"), ParameterValue(10),
                                      ParameterValue("99999999999999999999"), ParameterValue(false)})
        EXPECT_THAT(errorOf(set, "count", bad), HasSubstr("expected a whole number from 0 to 9"));
    EXPECT_EQ(errorOf(set, "on", "maybe"), "on: found 'maybe', expected true or false");
    EXPECT_EQ(errorOf(set, "color", "blue"), "color: found 'blue', expected red or green");
    EXPECT_THAT(errorOf(set, "letters", "abd"), HasSubstr("letters a, b, c"));
    EXPECT_THAT(errorOf(set, "letters", ""), HasSubstr("letters a, b, c"));
    EXPECT_THAT(errorOf(set, "widht", 1), HasSubstr("did you mean 'width'?"));
    EXPECT_THAT(errorOf(set, "zzzzzz", 1), HasSubstr("known: width, count, on, color, letters"));
    EXPECT_EQ(set.get("width"), ParameterValue(0.5)) << "what is refused leaves no trace";
    try {
        set.set("width", 2, "--width");
        FAIL();
    } catch (const Error& error) {
        EXPECT_EQ(std::string(error.what()).find("--width: found '2'"), 0u);
    }
}

}  // namespace
}  // namespace metrolux::core
