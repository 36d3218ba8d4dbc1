/// Texts to values: strictness, colors and spectra.

#include "io/mitsuba/values.h"

#include "support.h"

#include <gmock/gmock.h>

#include <clocale>
#include <locale>

namespace metrolux::core::mitsuba {
namespace {

using test::errorOf;
using testing::ElementsAre;
using testing::HasSubstr;

TEST(Values, Numbers) {
    EXPECT_EQ(parseNumber("1.5"), 1.5);
    EXPECT_EQ(parseNumber(" +2.5e-3\n"), 2.5e-3);
    EXPECT_EQ(parseNumber("-.5"), -0.5);
    EXPECT_EQ(parseNumber("1e-400"), 0.0);  // underflow is not an error
    for (const char* bad : {"", " ", "abc", "1.5f", "1,5", "1 2", "0x10", "nan", "NaN", "-nan", "inf",
                            "-Infinity", "1e400", "--1", "+-1", "1e", "1..2"})
        EXPECT_THROW(parseNumber(bad), Error) << bad;
    EXPECT_EQ(parseFloat("3e38"), 3e38f);
    EXPECT_THROW(parseFloat("1e39"), Error);
}

/// The decimal comma of a locale that need not be installed.
struct DecimalComma : std::numpunct<char> {
    char do_decimal_point() const override { return ','; }
};

TEST(Values, NumbersDoNotDependOnTheLocale) {
    const std::string before = std::setlocale(LC_ALL, nullptr);
    std::setlocale(LC_ALL, "de_DE.UTF-8");  // where it is installed
    const std::locale global = std::locale::global(std::locale(std::locale::classic(), new DecimalComma));
    EXPECT_EQ(parseNumber("1.5"), 1.5);
    EXPECT_THROW(parseNumber("1,5"), Error);
    std::locale::global(global);
    std::setlocale(LC_ALL, before.c_str());
}

TEST(Values, IntegersAndBooleans) {
    EXPECT_EQ(parseInteger(" -12 "), -12);
    EXPECT_EQ(parseInteger("+9223372036854775807"), std::numeric_limits<int64_t>::max());
    for (const char* bad : {"", "1.0", "1e3", "9223372036854775808", "0x1", "one", "1 2"})
        EXPECT_THROW(parseInteger(bad), Error) << bad;
    EXPECT_TRUE(parseBoolean("TRUE"));
    EXPECT_FALSE(parseBoolean(" false "));
    for (const char* bad : {"", "1", "yes", "truee"}) EXPECT_THROW(parseBoolean(bad), Error) << bad;
}

TEST(Values, Colors) {
    EXPECT_EQ(parseRgb("0.5"), Rgb(0.5f));
    EXPECT_EQ(parseRgb("1, 2,3"), Rgb(1, 2, 3));
    EXPECT_EQ(parseRgb("1 2\t3"), Rgb(1, 2, 3));
    EXPECT_EQ(parseRgb("#ff0033"), Rgb(1, 0, 0.2f));
    for (const char* bad : {"", "1 2", "1 2 3 4", "1,x,3", "#ff00", "#ff00zz", "#-f0033", "nan 0 0"})
        EXPECT_THROW(parseRgb(bad), Error) << bad;
    EXPECT_NEAR(parseSrgb("0.5").x, 0.21404f, 1e-5f);  // IEC 61966-2-1
    EXPECT_NEAR(parseSrgb("0.02").x, 0.02f / 12.92f, 1e-7f);
    EXPECT_EQ(parseSrgb("#ffffff"), Rgb(1.0f));
}

TEST(Values, Spectra) {
    EXPECT_THAT(parseSpectrum("0.75").values, ElementsAre(0.75f));
    const SpectrumValue list = parseSpectrum("400:0.1, 500:0.2\n600:0.3");
    EXPECT_THAT(list.wavelengths, ElementsAre(400, 500, 600));
    EXPECT_THAT(list.values, ElementsAre(0.1f, 0.2f, 0.3f));
    for (const char* bad : {"", "0.1 0.2 0.3", "400:0.1", "500:1, 400:1", "400:1, 400:2", "400:1, 500",
                            "400:x, 500:1", "-1:1, 2:1", "400:nan, 500:1", "400:1:2, 500:1"})
        EXPECT_THROW(parseSpectrum(bad), Error) << bad;
}

TEST(Values, SpectrumFiles) {
    const test::TemporaryFolder folder;
    const SpectrumValue read =
        readSpectrumFile(folder.write("a.spd", "# comment\n400 0.5\r\n\n500, 0.25 # more\n"));
    EXPECT_THAT(read.wavelengths, ElementsAre(400, 500));
    EXPECT_THAT(read.values, ElementsAre(0.5f, 0.25f));
    const auto bad = folder.write("b.spd", "400 0.5\n450 high\n");
    EXPECT_THAT(errorOf([&] { readSpectrumFile(bad); }),
                testing::AllOf(HasSubstr("b.spd"), HasSubstr("line 2"), HasSubstr("high")));
    EXPECT_THROW(readSpectrumFile(folder.write("c.spd", "")), Error);
    EXPECT_THROW(readSpectrumFile(folder.write("d.spd", "400 1 2\n500 1 2\n")), Error);
    EXPECT_THROW(readSpectrumFile(folder.path() / "absent.spd"), Error);
}

TEST(Values, Blackbody) {
    EXPECT_FLOAT_EQ(parseBlackbody("6500K", "").blackbodyKelvin, 6500);
    EXPECT_THAT(parseBlackbody("3000", "2.5").values, ElementsAre(2.5f));
    EXPECT_THROW(parseBlackbody("0", ""), Error);
    EXPECT_THROW(parseBlackbody("warm", ""), Error);
}

}  // namespace
}  // namespace metrolux::core::mitsuba
