#include "base/printable.h"

#include "base/error.h"

#include <gtest/gtest.h>

namespace metrolux::core {
namespace {

using namespace std::string_literals;

TEST(Printable, TextStaysAsItIs) {
    for (const std::string text : {"", "scene.xml", "Küche/照明.xml", "a\\b", "1/2 \"quoted\" 'too' {}"})
        EXPECT_EQ(printable(text), text);
}

TEST(Printable, WhatIsNoTextIsEscaped) {
    EXPECT_EQ(printable("a\nb\tc\rd"), R"(a\nb\tc\rd)");
    EXPECT_EQ(printable("\x1b[31mred\x7f"), R"(\x1b[31mred\x7f)");
    EXPECT_EQ(printable("nul\0!"s), R"(nul\x00!)");
    EXPECT_EQ(printable("\u009b31m"), R"(\x9b31m)") << "a control sequence in one character";
    EXPECT_EQ(printable("gpj.\u202etxt"), R"(gpj.\u202etxt)") << "reads as another name";
    EXPECT_EQ(printable("a\u2028b"), R"(a\u2028b)");
    EXPECT_EQ(printable("\xff\xc3(\xe2\x82"), R"(\xff\xc3(\xe2\x82)") << "no UTF-8";
    EXPECT_EQ(printable("\xed\xa0\x80"), R"(\xed\xa0\x80)") << "a surrogate";
}

TEST(Printable, LinesCanStay) { EXPECT_EQ(printableLines("a\n  b\x1b"), "a\n  b\\x1b"); }

TEST(Printable, JsonTakesValidUtf8) { EXPECT_EQ(validUtf8("a\n\x1b\xff\xc3\xa9"), "a\n\x1b\\xff\xc3\xa9"); }

TEST(Printable, ErrorsEscapeTheirArgumentsAndNotTheirOwnLines) {
    const std::string name = "scene\n[error] all is lost\x1b[2J.xml";
    const Error error("{}:\n  found {}, expected {}", name, "\x07", 3);
    EXPECT_STREQ(error.what(), "scene\\n[error] all is lost\\x1b[2J.xml:\n  found \\x07, expected 3");
}

}  // namespace
}  // namespace metrolux::core
