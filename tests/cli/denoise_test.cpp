/// --denoise: what is written, and by whom.

#include "command.h"
#include "image/image_io.h"
#include "paths.h"

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include <fstream>

namespace metrolux::core::cli {
namespace {

using testing::HasSubstr;
using testing::Not;

class DenoiseTest : public CliTest {
  protected:
    static Words words(const Words& more) {
        return Words{"render", "scene.xml", "--resolution", "32x24", "--seed", "3"} + more;
    }
    /// `oidn`: value of METROLUX_OIDN.
    Outcome runWith(const std::string& oidn, const Words& arguments, const std::string& wish = "") const {
        return Command(folder, arguments, {"env", "METROLUX_OIDN=" + oidn, "FAKE_OIDN=" + wish}).wait();
    }
    Outcome denoise(const Words& arguments) const { return runWith("off", arguments); }
    std::vector<float> layer(const std::string& image) const {
        return readLayer(folder / image, "denoised").pixels;
    }
    static std::string standIn() { return std::string(METROLUX_BINARY_DIR) + "/tests/libfake_oidn.so"; }
};

TEST_F(DenoiseTest, ThePlainImageStaysAsItIs) {
    for (const char* integrator : {"path", "mcmc_vcm"}) {
        const Words render = words({"-i", integrator, "--passes", "16", "--overwrite"});
        ASSERT_EQ(denoise(render + Words{"-o", "plain.exr", "-o", "plain.png"}).status, 0);
        const Outcome outcome =
            denoise(render + Words{"-o", "a.exr", "-o", "a.png", "--denoise", "--stats", "a.json"});
        ASSERT_EQ(outcome.status, 0) << outcome.err;
        EXPECT_EQ(pixels("a.exr"), pixels("plain.exr"));
        EXPECT_NE(pixels("a.png"), pixels("plain.png"));
        EXPECT_EQ(layer("a.exr").size(), pixels("a.exr").size());
        EXPECT_NE(layer("a.exr"), pixels("a.exr"));
        EXPECT_THAT(outcome.err, HasSubstr("wrote a.exr, with the layer denoised by own filter"));
        EXPECT_THAT(outcome.err, HasSubstr("wrote a.png, denoised by own filter"));
        EXPECT_THAT(run({"compare", "a.exr", "plain.exr"}).out, HasSubstr("MSE      0\n"));
        EXPECT_THAT(run({"compare", "a.exr", "plain.exr", "--layer", "denoised"}).out,
                    Not(HasSubstr("MSE      0\n")));
        const nlohmann::json statistics = nlohmann::json::parse(std::ifstream(folder / "a.json"));
        EXPECT_EQ(statistics["denoiser"], "own filter");
    }
}

TEST_F(DenoiseTest, ALayerIsTheSameAsTheOption) {
    ASSERT_EQ(denoise(words({"--passes", "4", "-o", "a.exr", "--denoise"})).status, 0);
    ASSERT_EQ(denoise(words({"--passes", "4", "-o", "b.exr", "--aov", "denoised", "--threads", "3"})).status,
              0);
    EXPECT_EQ(layer("a.exr"), layer("b.exr"));
}

TEST_F(DenoiseTest, ResumedItIsTheSame) {
    const Words render = words({"--denoise", "--checkpoint", "c"});
    ASSERT_EQ(denoise(words({"--denoise", "--passes", "13", "-o", "whole.exr"})).status, 0);
    ASSERT_EQ(denoise(render + Words{"--passes", "6", "-o", "a.exr"}).status, 0);
    const Outcome outcome = denoise({"resume", "c", "--passes", "13", "-o", "b.exr"});
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_EQ(pixels("b.exr"), pixels("whole.exr"));
    EXPECT_EQ(layer("b.exr"), layer("whole.exr"));
}

TEST_F(DenoiseTest, MergedPartsAreTheWhole) {
    const Words render = words({"--passes", "11", "--slices", "4", "--denoise"});
    ASSERT_EQ(denoise(render + Words{"-o", "whole.exr"}).status, 0);
    for (const char* slices : {"0", "1-2", "3"})
        ASSERT_EQ(denoise(render + Words{"--only-slices", slices, "--checkpoint", slices}).status, 0);
    const Outcome outcome = denoise({"merge", "3", "0", "1-2", "-o", "merged.exr", "--denoise"});
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_EQ(pixels("merged.exr"), pixels("whole.exr"));
    EXPECT_EQ(layer("merged.exr"), layer("whole.exr"));
}

TEST_F(DenoiseTest, PartsWithoutHalvesAreRefused) {
    const Words part = words({"--passes", "4", "--slices", "2", "--only-slices", "0"});
    ASSERT_EQ(denoise(part + Words{"--checkpoint", "p"}).status, 0);
    const Outcome outcome = denoise({"merge", "p", "-o", "a.exr", "--denoise"});
    EXPECT_EQ(outcome.status, 2);
    EXPECT_THAT(outcome.err, HasSubstr("have no halves of their passes, render them with --denoise"));
}

TEST_F(DenoiseTest, OnePassIsLeftAsItIs) {
    const Outcome outcome = denoise(words({"--passes", "1", "-o", "a.exr", "--denoise"}));
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr("the noise of one pass is not known"));
    EXPECT_EQ(layer("a.exr"), pixels("a.exr"));
}

TEST_F(DenoiseTest, AnotherLibraryDoesIt) {
    const Outcome outcome = runWith(standIn(), words({"--passes", "2", "-o", "a.exr", "--denoise"}));
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr("by Open Image Denoise 2.3.4"));
    const std::vector<float> plain = pixels("a.exr"), denoised = layer("a.exr");
    float least = 1e9f, most = 0;
    for (size_t i = 0; i < plain.size(); ++i) {
        const float added = denoised[i] - plain[i];
        least = std::min(least, added);
        most = std::max(most, added);
    }
    EXPECT_GT(most, 100) << "the normal";
    EXPECT_LT(most, 110.01f) << "the albedo";
    EXPECT_GE(least, -1e-3f);
}

TEST_F(DenoiseTest, ALibraryThatFailsCostsNoImage) {
    const Outcome outcome = runWith(standIn(), words({"--passes", "4", "-o", "a.exr", "--denoise"}), "fail");
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr("Open Image Denoise: the stand-in was to fail: our own filter"));
    EXPECT_THAT(outcome.err, HasSubstr("by own filter"));
}

TEST_F(DenoiseTest, ALibraryThatIsNoneIsRefusedBeforeTheFirstPass) {
    const Outcome missing = runWith("/nowhere/lib.so", words({"--passes", "4", "-o", "a.exr", "--denoise"}));
    EXPECT_EQ(missing.status, 2);
    EXPECT_THAT(missing.err, HasSubstr("METROLUX_OIDN: cannot load '/nowhere/lib.so'"));
    const std::string other = std::string(METROLUX_BINARY_DIR) + "/tests/libfailing_io.so";
    const Outcome wrong = runWith(other, words({"--passes", "4", "-o", "a.exr", "--denoise"}));
    EXPECT_EQ(wrong.status, 2);
    EXPECT_THAT(wrong.err, HasSubstr("is not Open Image Denoise: found no function oidnNewDevice"));
    EXPECT_THAT(wrong.err, Not(HasSubstr("pass 1")));
    EXPECT_EQ(runWith("/nowhere/lib.so", words({"--passes", "1", "-o", "a.exr"})).status, 0)
        << "nobody asked for it";
}

}  // namespace
}  // namespace metrolux::core::cli
