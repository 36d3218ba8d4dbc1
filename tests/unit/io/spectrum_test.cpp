/// Conversions of spectra against values that others published: the RGB fragments of Mitsuba's cbox scene,
/// which were made from its spectral ones, and against Planck's law.

#include "io/mitsuba/spectrum.h"

#include "support/shared_data.h"

#include <gtest/gtest.h>
#include <pugixml.hpp>

#include <filesystem>
#include <sstream>

namespace metrolux::core::mitsuba {
namespace {

SpectrumValue parse(const std::string& text) {
    SpectrumValue s;
    std::istringstream stream(text);
    float wavelength = 0, value = 0;
    char colon = 0, comma = 0;
    while (stream >> wavelength >> colon >> value) {
        s.wavelengths.push_back(wavelength);
        s.values.push_back(value);
        stream >> comma;
    }
    return s;
}

void expectNear(const Rgb& found, const Rgb& expected, float relative) {
    EXPECT_NEAR(found.x, expected.x, relative * expected.x);
    EXPECT_NEAR(found.y, expected.y, relative * expected.y);
    EXPECT_NEAR(found.z, expected.z, relative * expected.z);
}

TEST(Spectrum, reproducesCboxReflectances) {
    const std::filesystem::path folder = test::sharedPath("scenes/cbox/fragments");
    METROLUX_NEEDS_SHARED(folder);
    pugi::xml_document spectral, rgb;
    ASSERT_TRUE(spectral.load_file((folder / "bsdfs-spectral.xml").c_str()));
    ASSERT_TRUE(rgb.load_file((folder / "bsdfs-rgb.xml").c_str()));
    int compared = 0;
    for (const char* id : {"white", "red", "green", "light"}) {
        SCOPED_TRACE(id);
        const auto value = [&](const pugi::xml_document& document, const char* tag) {
            return std::string(document.child("scene")
                                   .find_child_by_attribute("bsdf", "id", id)
                                   .child(tag)
                                   .attribute("value")
                                   .value());
        };
        Rgb expected;
        char comma = 0;
        std::istringstream(value(rgb, "rgb")) >> expected.x >> comma >> expected.y >> comma >> expected.z;
        ASSERT_GT(expected.x, 0);
        expectNear(reflectanceFromSpectrum(parse(value(spectral, "spectrum"))), expected, 2.5e-3f);
        ++compared;
    }
    EXPECT_EQ(compared, 4);
}

TEST(Spectrum, emissionHasTheChromaticityThatMitsubaRendered) {
    // Mitsuba's reference test_arealight_ref_rgb.exr shows a diffuse sphere of reflectance (0.2, 0.5, 0.3)
    // under this light: its pixels divided by the reflectance are in the ratio 1.91 : 1 : 0.26. (The light of
    // cbox-rgb.xml, 18.387 10.9873 2.75357, is no conversion of this list: its red is 11 % less.)
    const Rgb emission = emissionFromSpectrum(parse("400:0, 500:8, 600:15.6, 700:18.4"));
    EXPECT_NEAR(emission.x / emission.y, 1.91, 0.005);
    EXPECT_NEAR(emission.z / emission.y, 0.26, 0.005);
    // Luminance: the list against the observer's Y, by hand (trapezoids of 5 nm).
    EXPECT_NEAR(luminance(emission), 12.37, 0.02);
}

TEST(Spectrum, uniformValueIsGray) {
    SpectrumValue s;
    s.values = {0.4f};
    EXPECT_EQ(reflectanceFromSpectrum(s), Rgb(0.4f));
    EXPECT_EQ(emissionFromSpectrum(s), Rgb(0.4f));
    s.values = {6.15f};
    EXPECT_EQ(reflectanceFromSpectrum(s), Rgb(1.0f));
    EXPECT_EQ(unboundedFromSpectrum(s), Rgb(6.15f));
}

TEST(Spectrum, samplingOfAStraightLineDoesNotMatter) {
    const SpectrumValue two = parse("380:0.1, 780:0.5"),
                        irregular = parse("380:0.1, 400:0.12, 530:0.25, 531:0.251, 780:0.5");
    expectNear(reflectanceFromSpectrum(irregular), reflectanceFromSpectrum(two), 1e-5f);
}

TEST(Spectrum, saturatedReflectanceIsClampedEmissionIsNot) {
    const SpectrumValue red = parse("600:1.5, 800:1.5");
    const Rgb reflectance = reflectanceFromSpectrum(red), emission = emissionFromSpectrum(red);
    EXPECT_EQ(reflectance.x, 1);
    EXPECT_GT(emission.x, 1);
    EXPECT_EQ(reflectance.z, 0);  // out of gamut
    EXPECT_EQ(emission.z, 0);
}

TEST(Spectrum, blackbody) {
    const auto at = [](float kelvin) {
        SpectrumValue s;
        s.blackbodyKelvin = kelvin;
        s.values = {1};
        return s;
    };
    // 2041.4 K is platinum's freezing point, once the definition of the candela: 60 cd / cm^2.
    EXPECT_NEAR(luminance(emissionFromSpectrum(at(2041.4f))) * 106.75 * 683 / 60e4, 1, 0.01);
    const Rgb warm = emissionFromSpectrum(at(2800)), cold = emissionFromSpectrum(at(10000));
    EXPECT_GT(warm.x, warm.z);
    EXPECT_LT(cold.x, cold.z);
    EXPECT_FLOAT_EQ(maxComponent(reflectanceFromSpectrum(at(3000))), 1);
}

}  // namespace
}  // namespace metrolux::core::mitsuba
