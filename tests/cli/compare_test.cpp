#include "command.h"
#include "image/image_io.h"

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

namespace metrolux::core::cli {
namespace {

using testing::HasSubstr;

ImageData constant(int width, float value) {
    return {width, 20, 3, std::vector<float>(static_cast<size_t>(width) * 60, value)};
}

TEST_F(CliTest, ComparePrintsMetricsAndWritesAHeatMap) {
    writeExr(folder / "a.exr", constant(30, 3));
    writeExr(folder / "b.exr", constant(30, 2));
    const Outcome text = run({"compare", "a.exr", "b.exr", "--heatmap", "heat.png"});
    EXPECT_EQ(text.status, 0) << text.err;
    EXPECT_THAT(text.out, HasSubstr("MSE      1\n"));
    EXPECT_THAT(text.out, HasSubstr("bias     +50.0000 %"));
    EXPECT_EQ(readImage(folder / "heat.png", true).width, 30);

    const Outcome json = run({"compare", "a.exr", "b.exr", "--json"});
    EXPECT_EQ(json.status, 0);
    const nlohmann::json result = nlohmann::json::parse(json.out);
    EXPECT_NEAR(result["mse"], 1, 1e-9);
    EXPECT_NEAR(result["rel_mse"], 1 / 4.01, 1e-9);
    EXPECT_NEAR(result["bias"], 0.5, 1e-9);
    EXPECT_EQ(result["pixels"], 600);
}

TEST_F(CliTest, CompareRefusesImagesOfDifferentSize) {
    writeExr(folder / "a.exr", constant(30, 3));
    writeExr(folder / "b.exr", constant(31, 3));
    const Outcome outcome = run({"compare", "a.exr", "b.exr"});
    EXPECT_EQ(outcome.status, 2);
    EXPECT_THAT(outcome.err, HasSubstr("30x20"));
    EXPECT_THAT(outcome.err, HasSubstr("31x20"));
}

}  // namespace
}  // namespace metrolux::core::cli
