#include "command.h"

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include <fstream>

namespace metrolux::core::cli {
namespace {

using testing::HasSubstr;

TEST_F(CliTest, BenchMeasuresRaysAndTechniques) {
    const Outcome outcome =
        run({"bench", "scene.xml", "-i", "vcm", "--threads", "2", "--passes", "2", "--json", "b.json"});
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_THAT(outcome.out, HasSubstr("ray efficiency"));
    const nlohmann::json j = nlohmann::json::parse(std::ifstream(folder / "b.json"));
    EXPECT_EQ(j["format"], "metrolux-bench");
    EXPECT_EQ(j["passes"]["integrator"], "vcm");
    EXPECT_EQ(j["passes"]["pixels"], 24 * 16);
    // One eye and one light subpath for each pixel, and more edges than that.
    EXPECT_GT(j["passes"]["rays_per_pass"]["intersect"], 2 * 24 * 16);
    EXPECT_GT(j["passes"]["rays_per_pass"]["occlusion"], 24 * 16);
    ASSERT_EQ(j["passes"]["ways"].size(), 2u);
    for (const auto& way : j["passes"]["ways"]) {
        EXPECT_GT(way["ray_efficiency"], 0);
        EXPECT_GT(way["sorted_ray_efficiency"], 0);
        EXPECT_LT(way["ray_efficiency_cpu"], 1.5);  // near 1 only if nothing but rays cost time
        EXPECT_GT(way["rays_per_second"], 0);
    }
    for (const char* technique : {"eye_vertex", "light_vertex", "next_event", "splat", "connection", "merge"})
        EXPECT_GT(j["techniques"][technique]["count"], 0) << technique;
    for (const char* key : {"processor", "compiler", "flags", "embree", "revision"})
        EXPECT_FALSE(j["machine"][key].get<std::string>().empty()) << key;
}

TEST_F(CliTest, BenchRefusesWhatItCannotMeasure) {
    EXPECT_EQ(run({"bench", "absent.xml"}).status, 2);
    EXPECT_EQ(run({"bench", "scene.xml", "--passes", "0"}).status, 2);
    const Outcome outcome = run({"bench", "scene.xml", "-i", "vmc"});
    EXPECT_EQ(outcome.status, 2);
    EXPECT_THAT(outcome.err, HasSubstr("vcm"));
}

}  // namespace
}  // namespace metrolux::core::cli
