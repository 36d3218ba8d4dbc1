/// Typed access to properties, what is left unread, and suggestions.

#include "support.h"

#include <gmock/gmock.h>

namespace metrolux::core {
namespace {

using mitsuba::ElementPtr;
using test::errorOf;
using test::parseText;
using test::scene;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

ElementPtr firstBsdf(const std::string& body) {
    return parseText(scene("<bsdf type=\"plastic\" id=\"b\">\n" + body + "\n</bsdf>"))
        .root->childrenOf("bsdf")
        .at(0);
}

TEST(Properties, AreReadByType) {
    const ElementPtr element = firstBsdf(R"(
        <float name="f" value="1.5"/> <integer name="i" value="-3"/> <boolean name="b" value="True"/>
        <string name="s" value="text"/> <point name="p" x="1" y="2" z="3"/> <vector name="v" value="4, 5 6"/>)");
    EXPECT_FLOAT_EQ(element->number("f", 0), 1.5f);
    EXPECT_FLOAT_EQ(element->number("i", 0), -3.0f);  // an integer will do for a number
    EXPECT_EQ(element->integer("i", 0), -3);
    EXPECT_TRUE(element->boolean("b", false));
    EXPECT_EQ(element->string("s", ""), "text");
    EXPECT_EQ(element->vector("p", Vec3f(0.0f)), Vec3f(1, 2, 3));
    EXPECT_EQ(element->vector("v", Vec3f(0.0f)), Vec3f(4, 5, 6));
    EXPECT_FLOAT_EQ(element->number("absent", 7), 7.0f);
    EXPECT_TRUE(element->transform("absent").isIdentity());
    std::vector<std::string> warnings;
    EXPECT_NO_THROW(element->checkAllUsed(false, warnings));
}

TEST(Properties, WrongTypesNameWhatWasFoundAndExpected) {
    const ElementPtr element =
        firstBsdf("<string name=\"alpha\" value=\"ggx\"/><float name=\"n\" value=\"2\"/>");
    EXPECT_THAT(errorOf([&] { element->number("alpha", 0); }),
                AllOf(HasSubstr("scene.xml:3:"), HasSubstr("<bsdf type=\"plastic\">"), HasSubstr("\"alpha\""),
                      HasSubstr("\"ggx\""), HasSubstr("expected a <float>")));
    EXPECT_THAT(errorOf([&] { element->integer("n", 0); }), HasSubstr("expected an <integer>"));
    EXPECT_THAT(errorOf([&] { element->boolean("n", false); }), HasSubstr("expected a <boolean>"));
    EXPECT_THAT(errorOf([&] { element->vector("n", Vec3f(0.0f)); }), HasSubstr("expected a <point>"));
    EXPECT_THAT(errorOf([&] { element->transform("n"); }), HasSubstr("expected a <transform>"));
    EXPECT_THAT(errorOf([&] { element->requiredString("filename"); }),
                AllOf(HasSubstr("scene.xml:2:"), HasSubstr("filename")));
}

TEST(Properties, NumbersOutsideOfFloatAreRefused) {
    const ElementPtr element = firstBsdf("<float name=\"huge\" value=\"1e300\"/>");
    EXPECT_THAT(errorOf([&] { element->number("huge", 0); }), HasSubstr("finite single-precision"));
}

TEST(Properties, WhatIsNotReadIsAnErrorWithTheNearestName) {
    const ElementPtr element =
        firstBsdf("<float name=\"intIOR\" value=\"1.5\"/>\n<rgb name=\"zzz\" value=\"1\"/>");
    element->number("int_ior", 1.5f);
    element->number("ext_ior", 1);
    std::vector<std::string> warnings;
    EXPECT_THAT(
        errorOf([&] { element->checkAllUsed(false, warnings); }),
        AllOf(HasSubstr("scene.xml:3:"), HasSubstr("\"intIOR\""), HasSubstr("did you mean \"int_ior\"?")));

    const ElementPtr again =
        firstBsdf("<float name=\"intIOR\" value=\"1.5\"/>\n<rgb name=\"zzz\" value=\"1\"/>");
    again->number("int_ior", 1.5f);
    again->checkAllUsed(true, warnings);
    ASSERT_EQ(warnings.size(), 2u);
    EXPECT_THAT(warnings[1], AllOf(HasSubstr("scene.xml:4:"), HasSubstr("expected one of: int_ior")));
}

TEST(Properties, ChildrenThatNothingTakesAreErrors) {
    const ElementPtr element = firstBsdf("<bsdf type=\"diffuse\"/>\n<emitter type=\"area\"/>");
    EXPECT_EQ(element->childrenOf("bsdf").size(), 1u);
    std::vector<std::string> warnings;
    EXPECT_THAT(
        errorOf([&] { element->checkAllUsed(false, warnings); }),
        AllOf(HasSubstr("scene.xml:4:"), HasSubstr("<emitter type=\"area\">"), HasSubstr("not expected")));
}

TEST(Properties, ChildrenAreFoundWithAndWithoutNamesInOrder) {
    const ElementPtr element = firstBsdf(R"(<bsdf type="a"/><bsdf name="x" type="b"/><bsdf type="c"/>
        <texture name="t" type="bitmap"/>)");
    std::string types;
    for (const ElementPtr& child : element->childrenOf("bsdf")) types += child->type;
    EXPECT_EQ(types, "abc");
    EXPECT_EQ(element->child("t")->type, "bitmap");
    EXPECT_EQ(element->child("u"), nullptr);
}

TEST(Properties, NearestName) {
    const std::vector<std::string> names = {
        "reflectance", "specular_reflectance", "alpha", "alpha_u", "eta", "k"};
    EXPECT_EQ(nearestName("reflectanc", names), "reflectance");
    EXPECT_EQ(nearestName("specularReflectance", names), "specular_reflectance");
    EXPECT_EQ(nearestName("alphaU", names), "alpha_u");
    EXPECT_EQ(nearestName("zebra_crossing", names), "");
    EXPECT_EQ(nearestName("anything", {}), "");
}

}  // namespace
}  // namespace metrolux::core
