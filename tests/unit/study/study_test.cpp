#include "study/study.h"

#include "base/error.h"
#include "image/image_io.h"
#include "study/page.h"
#include "study/report.h"
#include "support/small_scenes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <sstream>
#include <unistd.h>

namespace metrolux::core::study {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;

std::shared_ptr<Scene> smallScene() {
    test::SceneBuilder builder;
    builder.add(test::rectangle({0, 0, 0}, {0, 0, 1}, 2, 2), test::diffuse(0.5f));
    const ShapePtr lamp = builder.add(test::rectangle({0, 1, 3}, {0, 0, -1}, 0.3f, 0.3f), test::diffuse(0));
    builder.emit(lamp, Rgb(5));
    builder.camera({0, 0, 4}, {0, 0, 0}, 40, 16, 12);
    builder.limits().maxDepth = 3;
    return builder.build();
}

Entrant entrant(const std::string& integrator) { return {integrator, integrator, {}, {}, {}, {}}; }

class SmallStudy : public testing::Test {
  protected:
    SmallStudy() : scene(smallScene()) {
        plan.entrants = {entrant("path"), entrant("vcm")};
        plan.passes = 4;
        plan.seeds = 2;
        study.name = "small";
        study.file = "small.xml";
        study.window = scene->camera().window();
        study.reference.file = "given.exr";
        study.reference.image = {16, 12, 3, std::vector<float>(16 * 12 * 3, 0.1f)};
    }
    std::shared_ptr<Scene> scene;
    Plan plan;
    SceneStudy study;
};

TEST_F(SmallStudy, RunsEveryIntegratorWithEverySeed) {
    std::vector<std::string> order;
    Surroundings s;
    s.afterRun = [&](const SceneStudy& so, size_t e) {
        order.push_back(plan.entrants[e].label + std::to_string(so.contributions[e].runs.back().seed));
    };
    runStudy(*scene, plan, study, s);
    EXPECT_THAT(order, ElementsAre("path1", "vcm1", "path2", "vcm2"));
    for (const Contribution& contribution : study.contributions) {
        ASSERT_EQ(contribution.runs.size(), 2u);
        for (const study::Run& run : contribution.runs) {
            EXPECT_EQ(run.reason, StopReason::Passes);
            ASSERT_EQ(run.measurements.size(), 4u) << "passes 1, 2, 3, 4";
            EXPECT_EQ(run.measurements.back().passes, 4u);
            const ImageDifference difference = compareImages(run.image, study.reference.image);
            EXPECT_EQ(run.measurements.back().values[indexOf(Metric::RelMse)], difference.relMse);
            EXPECT_EQ(run.measurements.back().values[indexOf(Metric::Bias)], difference.bias);
        }
        EXPECT_NE(contribution.runs[0].image.pixels, contribution.runs[1].image.pixels);
    }
    EXPECT_FALSE(study.interrupted);
}

TEST_F(SmallStudy, EqualTimeStopsNearTheLimitAndCountsRenderingOnly) {
    plan.passes = 0;
    plan.seconds = 0.2;
    plan.seeds = 1;
    runStudy(*scene, plan, study, {});
    for (const Contribution& contribution : study.contributions) {
        const study::Run& run = contribution.runs.front();
        EXPECT_EQ(run.reason, StopReason::Time);
        EXPECT_GE(run.measurements.front().seconds, run.setupSeconds);
        EXPECT_GT(run.measurements.back().seconds, 0.1);
        EXPECT_EQ(run.measurements.front().passes, 1u);
    }
}

TEST_F(SmallStudy, InterruptedKeepsWhatIsThere) {
    int asked = 0;
    Surroundings s;
    s.interrupted = [&] { return ++asked > 6; };
    runStudy(*scene, plan, study, s);
    EXPECT_TRUE(study.interrupted);
    ASSERT_EQ(study.contributions[0].runs.size(), 1u);
    EXPECT_TRUE(study.contributions[0].runs[0].complete());
    ASSERT_EQ(study.contributions[1].runs.size(), 1u);
    EXPECT_FALSE(study.contributions[1].runs[0].complete());
    const auto json = studyJson(study, plan, {});
    EXPECT_EQ(json["interrupted"], true);
    EXPECT_EQ(json["entrants"][1]["status"], "incomplete");
    EXPECT_TRUE(json["entrants"][1]["summary"].is_null()) << "a run that was cut short is no result";
    EXPECT_EQ(json["entrants"][1]["runs"][0]["points"].size(), 2u);
    EXPECT_EQ(json["winners"]["mse"]["entrant"], "path");
}

TEST_F(SmallStudy, AnIntegratorThatRefusesIsLeftOut) {
    plan.entrants.push_back(entrant("none_such"));
    runStudy(*scene, plan, study, {});
    EXPECT_THAT(study.contributions[2].refusal, HasSubstr("none_such"));
    const auto json = studyJson(study, plan, {});
    EXPECT_EQ(json["entrants"][2]["status"], "refused");
    EXPECT_EQ(json["entrants"][0]["status"], "done");
}

TEST_F(SmallStudy, TheReferenceKnowsItsOwnNoise) {
    const auto reference = renderReference(*scene, plan, entrant("path"), 0.5, {});
    ASSERT_TRUE(reference.has_value());
    EXPECT_THAT(reference->seeds, ElementsAre(3u, 4u)) << "none of the plan's 1 and 2";
    ASSERT_TRUE(reference->noise.has_value());
    EXPECT_GT(reference->noise->relMse, 0);
    // Against a longer and independent one the error is of the size that the halves say (both have noise).
    plan.firstSeed = 100;
    const auto longer = renderReference(*scene, plan, entrant("path"), 2, {});
    const double found = compareImages(reference->image, longer->image).relMse;
    const double expected = reference->noise->relMse + longer->noise->relMse;
    EXPECT_GT(found / expected, 0.5);
    EXPECT_LT(found / expected, 2);
    Surroundings s;
    s.interrupted = [] { return true; };
    EXPECT_FALSE(renderReference(*scene, plan, entrant("path"), 0.5, s).has_value());
}

/// All keys of a JSON document, "[]" for the elements of an array.
void collectKeys(const nlohmann::ordered_json& json, const std::string& prefix, std::set<std::string>& keys) {
    for (const auto& [key, value] : json.items()) {
        const std::string name = json.is_array() ? prefix + "[]" : prefix + "." + key;
        if (!json.is_array()) keys.insert(name);
        if (value.is_structured() && key != "integrator_statistics") collectKeys(value, name, keys);
    }
}

TEST_F(SmallStudy, JsonHasTheSchemaOfItsVersion) {
    runStudy(*scene, plan, study, {});
    std::set<std::string> keys;
    collectKeys(
        studyJson(study, plan, {"1.2.3", {"metrolux", "study"}, {{"threads", 2}}, nlohmann::json::object()}),
        "", keys);
    // A change here is a change of the format: count kFormatVersion up and say it in docs/reference/study.md.
    static_assert(kFormatVersion == 1);
    for (const char* key : {".format",
                            ".format_version",
                            ".version",
                            ".written",
                            ".command",
                            ".machine",
                            ".machine.threads",
                            ".scene",
                            ".scene.name",
                            ".scene.file",
                            ".scene.options",
                            ".scene.window.width",
                            ".scene.image.height",
                            ".scene.warnings",
                            ".plan.limit",
                            ".plan.seconds",
                            ".plan.passes",
                            ".plan.seeds",
                            ".plan.epsilon",
                            ".plan.confidence",
                            ".plan.fit_share",
                            ".plan.grid",
                            ".reference.source",
                            ".reference.file",
                            ".reference.exr",
                            ".reference.png",
                            ".interrupted",
                            ".entrants[].label",
                            ".entrants[].integrator",
                            ".entrants[].options",
                            ".entrants[].status",
                            ".entrants[].refusal",
                            ".entrants[].summary.runs",
                            ".entrants[].summary.passes",
                            ".entrants[].summary.seconds",
                            ".entrants[].summary.final.rel_mse.mean",
                            ".entrants[].summary.final.bias.low",
                            ".entrants[].summary.final.smape.high",
                            ".entrants[].summary.final_absolute_bias.mean",
                            ".entrants[].summary.rates.rel_mse",
                            ".entrants[].summary.rates.mse.slope",
                            ".entrants[].summary.rates.mse.standard_error",
                            ".entrants[].summary.rates.mse.runs[].points",
                            ".entrants[].summary.curve[].passes",
                            ".entrants[].summary.curve[].seconds",
                            ".entrants[].summary.curve[].trimmed_rel_mse.mean",
                            ".entrants[].runs[].seed",
                            ".entrants[].runs[].stop_reason",
                            ".entrants[].runs[].setup_seconds",
                            ".entrants[].runs[].non_finite",
                            ".entrants[].runs[].exr",
                            ".entrants[].runs[].png",
                            ".entrants[].runs[].integrator_statistics",
                            ".entrants[].runs[].points[].passes",
                            ".entrants[].runs[].points[].seconds",
                            ".entrants[].runs[].points[].rel_mse",
                            ".entrants[].runs[].points[].bias",
                            ".winners.rel_mse.entrant",
                            ".winners.bias.tied"})
        EXPECT_TRUE(keys.contains(key)) << key;
}

TEST_F(SmallStudy, JsonAgreesWithTheRuns) {
    runStudy(*scene, plan, study, {});
    const auto json = studyJson(study, plan, {});
    for (size_t e = 0; e < 2; ++e) {
        const auto& entry = json["entrants"][e];
        double logs = 0;
        for (const study::Run& run : study.contributions[e].runs)
            logs += std::log(run.measurements.back().values[indexOf(Metric::Mse)]) / 2;
        EXPECT_NEAR(entry["summary"]["final"]["mse"]["mean"].get<double>(), std::exp(logs), 1e-12);
        EXPECT_EQ(entry["runs"][1]["exr"], runFiles(plan.entrants[e], 2).exr);
    }
    EXPECT_EQ(json["plan"]["seeds"], (std::vector<int>{1, 2}));
}

TEST_F(SmallStudy, FilesAreWritten) {
    runStudy(*scene, plan, study, {});
    const fs::path folder = fs::path(testing::TempDir()) / ("metrolux-study-" + std::to_string(::getpid()));
    fs::create_directories(folder);
    writeReference(study, {}, folder);
    writeRun(study, plan, 1, study.contributions[1].runs[0], {}, folder);
    writeReport(study, plan, {}, folder);
    EXPECT_TRUE(fs::exists(folder / "index.html"));
    EXPECT_EQ(readImage(folder / "vcm-seed1.exr", false).pixels, study.contributions[1].runs[0].image.pixels);
    EXPECT_EQ(readImage(folder / "reference.exr", false).pixels, study.reference.image.pixels);
    EXPECT_TRUE(fs::exists(folder / "study.json"));
    EXPECT_TRUE(fs::exists(folder / "table.md"));
    fs::remove_all(folder);
}

TEST_F(SmallStudy, CsvHasARowForEachMeasurement) {
    runStudy(*scene, plan, study, {});
    std::istringstream lines(curvesCsv(study, plan));
    std::string line;
    std::getline(lines, line);
    EXPECT_EQ(line, "scene,entrant,seed,complete,passes,seconds,rel_mse,trimmed_rel_mse,mse,smape,bias");
    int rows = 0;
    for (; std::getline(lines, line); ++rows)
        EXPECT_EQ(std::count(line.begin(), line.end(), ','), 10) << line;
    EXPECT_EQ(rows, 2 * 2 * 4);
}

TEST(RunFiles, HaveNamesThatEveryFileSystemTakes) {
    EXPECT_EQ(runFiles(entrant("mcmc_vcm:kernel=adaptive"), 7).exr, "mcmc_vcm-kernel-adaptive-seed7.exr");
}

TEST(PagePixels, AreBase64OfZlibOfBytePlanes) {
    // One gray pixel: three equal numbers. 1.0f is 3f800000, so the planes are 0 0 0, 0 0 0, 80 80 80, 3f 3f
    // 3f.
    const ImageData image{1, 1, 1, {1.0f}};
    const std::string text = encodePixels(image, false);
    EXPECT_EQ(text.size() % 4, 0u);
    EXPECT_EQ(text.substr(0, 2), "eJ") << "the header of zlib, 78 9c";
    EXPECT_NE(encodePixels(image, true), text);
}

TEST(StudyPage, CannotBeBrokenByWhatItShows) {
    const ImageData image{1, 1, 3, {1, 2, 3}};
    const std::string hostile = "</script><script>alert(1)</script><!--";
    const std::string page = studyPage({{"scene", hostile}}, {{hostile, &image}});
    EXPECT_EQ(page.find("alert(1)</script>"), std::string::npos);
    EXPECT_EQ(page.find("@METROLUX"), std::string::npos);
    EXPECT_EQ(page.find("http-equiv"), std::string::npos);
    EXPECT_EQ(page.find("src=\"http"), std::string::npos) << "nothing is loaded from elsewhere";
}

}  // namespace
}  // namespace metrolux::core::study
