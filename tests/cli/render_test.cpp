#include "command.h"
#include "image/image_io.h"
#include "support/parameter_values.h"

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include <csignal>
#include <fstream>
#include <set>

namespace metrolux::core::cli {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::IsEmpty;

double mean(const ImageData& image) {
    double sum = 0;
    for (float value : image.pixels) sum += value;
    return sum / static_cast<double>(image.pixels.size());
}

TEST_F(CliTest, RendersToTheFilesThatAreNamed) {
    const Outcome outcome = run({"render", "scene.xml", "-o", "a.exr", "-o", "b.png", "--passes", "2",
                                 "--aov", "albedo,depth", "--quiet"});
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_THAT(outcome.out, IsEmpty());
    EXPECT_THAT(outcome.err, IsEmpty());
    EXPECT_GT(mean(readImage(folder / "a.exr", false)), 0.01);
    EXPECT_EQ(readImage(folder / "b.png", false).height, 16);
    EXPECT_EQ(readLayer(folder / "a.exr", "depth").pixels.size(), 24u * 16);
    EXPECT_EQ(run({"render", "scene.xml", "--passes", "1"}).status, 0);
    EXPECT_TRUE(fs::exists(folder / (folder.filename().string() + ".exr")))
        << "named after scene.xml's folder";
    fs::copy_file(folder / "scene.xml", folder / "other.xml");
    EXPECT_EQ(run({"render", "other.xml", "--passes", "1"}).status, 0);
    EXPECT_TRUE(fs::exists(folder / "other.exr")) << "named after the scene";
}

TEST_F(CliTest, EverySensorHasAnImageOfItsName) {
    const auto sensor = [](const char* attributes, const char* width) {
        return fmt::format(
            R"(<sensor type="perspective"{}><film type="hdrfilm"><integer name="width" value="{}"/>
<integer name="height" value="4"/></film><transform name="to_world">
<lookat origin="1e6 0 -4" target="1e6 0 0" up="0 1 0"/></transform></sensor>)",
            attributes, width);
    };
    write("many.xml", R"(<scene version="3.0.0">)" + sensor(R"( id="a/b")", "5") + sensor("", "6") +
                          R"(<shape type="sphere"><point name="center" x="1e6" y="0" z="0"/></shape>
<emitter type="constant"/></scene>)");
    const std::vector<std::string> all{"render", "many.xml", "--sensor", "all", "--passes", "1"};
    const auto with = [&](std::vector<std::string> more) {
        std::vector<std::string> words = all;
        words.insert(words.end(), more.begin(), more.end());
        return run(words);
    };
    EXPECT_EQ(with({}).status, 0);
    EXPECT_EQ(readImage(folder / "many.a_b.exr", false).width, 5);
    EXPECT_EQ(readImage(folder / "many.1.exr", false).width, 6);
    EXPECT_EQ(with({"-o", "x.png", "--stats", "s.json"}).status, 0);
    EXPECT_TRUE(fs::exists(folder / "x.a_b.png") && fs::exists(folder / "s.1.json"));
    EXPECT_THAT(with({"--checkpoint", "c"}).err, HasSubstr("name one sensor"));

    // Positions are the file's, although the scene is built around an origin of its own.
    const nlohmann::json info = nlohmann::json::parse(run({"info", "many.xml", "--json"}).out);
    EXPECT_NEAR(info["origin"][0].get<double>(), 1e6, 4);
    EXPECT_EQ(info["sensor"]["position"], nlohmann::json({1e6, 0.0, -4.0}));
    EXPECT_NEAR(info["bounds"]["center"][0].get<double>(), 1e6, 0.1);
    EXPECT_THAT(run({"info", "many.xml"}).out, HasSubstr("at (1000000, 0, -4)"));
}

TEST_F(CliTest, ConvertedScenesRenderToTheSameBits) {
    EXPECT_EQ(run({"convert", "scene.xml", "new.xml"}).status, 0);
    EXPECT_EQ(run({"render", "scene.xml", "--passes", "2", "-o", "a.exr"}).status, 0);
    EXPECT_EQ(run({"render", "new.xml", "--passes", "2", "-o", "b.exr"}).status, 0);
    EXPECT_EQ(readImage(folder / "a.exr", false).pixels, readImage(folder / "b.exr", false).pixels);
    EXPECT_THAT(run({"convert", "scene.xml", "new.xml"}).err, HasSubstr("without --overwrite"));
    EXPECT_EQ(run({"convert", "scene.xml", "new.xml", "--overwrite"}).status, 0);
    EXPECT_THAT(run({"convert", "scene.xml", "scene.xml", "--overwrite"}).err, HasSubstr("that is read"));
    EXPECT_THAT(run({"convert", "scene.xml", "new.glb"}).err, HasSubstr(".xml"));
}

TEST_F(CliTest, ThreadsDoNotChangeTheImageOfAnyIntegrator) {
    for (const std::string& name : integratorNames()) {
        for (const char* threads : {"1", "2"}) {
            const Outcome outcome = run({"render", "scene.xml", "-i", name, "--passes", "3", "--threads",
                                         threads, "-o", name + threads + ".exr"});
            ASSERT_EQ(outcome.status, 0) << name << ": " << outcome.err;
        }
        const ImageData one = readImage(folder / (name + "1.exr"), false),
                        two = readImage(folder / (name + "2.exr"), false);
        EXPECT_EQ(one.pixels, two.pixels) << name;
        EXPECT_GT(mean(one), 0.001) << name;
    }
}

/// Light so strong that its contributions overflow: left out, counted by technique, and said.
TEST_F(CliTest, ContributionsThatAreNotFiniteAreReported) {
    // The lamp fills the image and is brighter than everything else by more than a sum can hold.
    write("bright.xml", R"(<scene version="3.0.0"><sensor type="perspective">
<film type="hdrfilm"><integer name="width" value="8"/><integer name="height" value="8"/></film>
<float name="fov" value="1e-5"/>
<transform name="to_world"><lookat origin="0 0 -4" target="0 0 0" up="0 1 0"/></transform></sensor>
<shape type="sphere"><float name="radius" value="1e-6"/>
<emitter type="area"><rgb name="radiance" value="1e25 1e25 1e25"/></emitter></shape>
<shape type="sphere"><point name="center" x="0" y="0" z="4"/></shape></scene>)");
    const Outcome outcome =
        run({"render", "bright.xml", "-i", "path", "--passes", "2", "-o", "a.exr", "--stats", "a.json"});
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr("contributions of the technique 'hit' were not finite"));
    std::ifstream stream(folder / "a.json");
    const nlohmann::json counts = nlohmann::json::parse(stream)["non_finite"];
    EXPECT_GT(counts["hit"], 0);
    EXPECT_EQ(counts["splat"], 0) << "a path tracer has no splats";
    for (const float value : readImage(folder / "a.exr", false).pixels) EXPECT_TRUE(std::isfinite(value));
}

TEST_F(CliTest, ScenesOfAnyFiniteBrightnessAreRendered) {
    const std::string scene = R"(<scene version="3.0.0"><sensor type="perspective">
<film type="hdrfilm"><integer name="width" value="8"/><integer name="height" value="8"/></film>
<transform name="to_world"><lookat origin="0 0 -4" target="0 0 0" up="0 1 0"/></transform></sensor>
<shape type="sphere"/><emitter type="constant"><rgb name="radiance" value="$l $l $l"/></emitter></scene>)";
    write("any.xml", scene);
    std::vector<std::string> errors;
    for (const char* radiance : {"1e-30", "1", "3e38", "2e-38"}) {
        const Outcome outcome = run({"render", "any.xml", "-D", std::string("l=") + radiance, "--passes", "2",
                                     "-o", "a.exr", "--stats", "a.json"});
        ASSERT_EQ(outcome.status, 0) << outcome.err;
        const nlohmann::json stats = nlohmann::json::parse(std::ifstream(folder / "a.json"));
        for (const auto& [technique, count] : stats["non_finite"].items()) EXPECT_EQ(count, 0) << technique;
        EXPECT_NEAR(readImage(folder / "a.exr", false).pixels[0] / std::stof(radiance), 1, 1e-6) << radiance;
        errors.push_back(outcome.err);
    }
    for (const size_t ordinary : {0, 1}) EXPECT_THAT(errors[ordinary], Not(HasSubstr("single precision")));
    EXPECT_THAT(errors[3], HasSubstr("values of the image are too large or too small for single precision"));
}

TEST_F(CliTest, LightsOfInfinitePowerAreRefused) {
    write("infinite.xml", R"(<scene version="3.0.0"><sensor type="perspective"/>
<shape type="sphere"><float name="radius" value="1e18"/></shape>
<emitter type="constant"><rgb name="radiance" value="3e38 3e38 3e38"/></emitter></scene>)");
    const Outcome outcome = run({"render", "infinite.xml", "--passes", "1"});
    EXPECT_EQ(outcome.status, 2);
    EXPECT_THAT(outcome.err, HasSubstr("infinite.xml: the power of light 1 of 1 is"));
}

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
/// Sanitizers need more address space than this leaves.
TEST_F(CliTest, ThreadsThatTheSystemDoesNotGiveEndWithAMessage) {
    const Outcome outcome = Command(folder, {"render", "scene.xml", "--threads", "512", "--passes", "1"},
                                    {"bash", "-c", "ulimit -v 1500000; exec \"$@\"", "bash"})
                                .wait();
    EXPECT_EQ(outcome.status, 2) << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr("of 512 threads"));
    EXPECT_THAT(outcome.err, HasSubstr("--threads"));
}
#endif

TEST_F(CliTest, SeedChangesTheNoise) {
    for (const char* seed : {"1", "2"})
        ASSERT_EQ(
            run({"render", "scene.xml", "--passes", "1", "--seed", seed, "-o", seed + std::string(".exr")})
                .status,
            0);
    EXPECT_NE(readImage(folder / "1.exr", false).pixels, readImage(folder / "2.exr", false).pixels);
}

TEST_F(CliTest, CropIsThePartOfTheImage) {
    // Means of 120 pixels after 200 passes: their noise is far below the 10 % that is allowed.
    for (const char* integrator : {"path", "bdpt", "pssmlt"}) {
        ASSERT_EQ(run({"render", "scene.xml", "-i", integrator, "--passes", "200", "-o", "all.exr"}).status,
                  0);
        ASSERT_EQ(run({"render", "scene.xml", "-i", integrator, "--passes", "200", "-o", "crop.exr", "--crop",
                       "5,6,12,10"})
                      .status,
                  0);
        const ImageData all = readImage(folder / "all.exr", false),
                        crop = readImage(folder / "crop.exr", false);
        ASSERT_EQ(crop.width, 12);
        ASSERT_EQ(crop.height, 10);
        ImageData cut{12, 10, 3, {}};
        for (int y = 0; y < 10; ++y)
            cut.pixels.insert(cut.pixels.end(), all.at(5, y + 6), all.at(5, y + 6) + 36);
        EXPECT_NEAR(mean(crop) / mean(cut), 1, 0.1) << integrator;
    }
}

TEST_F(CliTest, OptionsOfPathChainsReachThem) {
    // Each of these is another image; the first is the default.
    const std::vector<std::vector<std::string>> variants{
        {"-i", "pssmlt_merge"},
        {"-i", "pssmlt_merge", "--method", "A"},
        {"-i", "pssmlt_merge", "--large-step", "0.5"},
        {"-i", "pssmlt_merge", "--kernel", "adaptive"},
        {"-i", "pssmlt_merge", "--lanes", "3"},
    };
    std::set<std::vector<float>> images;
    for (const std::vector<std::string>& variant : variants) {
        std::vector<std::string> arguments{"render", "scene.xml", "--passes", "4",
                                           "-o",     "a.exr",     "--stats",  "a.json"};
        arguments.insert(arguments.end(), variant.begin(), variant.end());
        const Outcome outcome = run(arguments);
        ASSERT_EQ(outcome.status, 0) << outcome.err;
        EXPECT_TRUE(images.insert(readImage(folder / "a.exr", false).pixels).second)
            << testing::PrintToString(variant);
        const nlohmann::json s =
            nlohmann::json::parse(std::ifstream(folder / "a.json"))["integrator_statistics"];
        EXPECT_GT(s["b"]["value"], 0);
        EXPECT_GT(s["small_steps"]["tried"], 0);
    }
}

TEST_F(CliTest, OptionsThatTheIntegratorDoesNotKnowAreWarnedOf) {
    const auto warnings = [&](const std::vector<std::string>& options) {
        std::vector<std::string> words{"render", "scene.xml", "--passes", "1", "-o", "a.exr"};
        words.insert(words.end(), options.begin(), options.end());
        const Outcome outcome = run(words);
        EXPECT_EQ(outcome.status, 0) << outcome.err;
        return outcome.err;
    };
    EXPECT_THAT(warnings({"-i", "path", "--large-step", "0.5"}),
                HasSubstr("--large-step has no effect on path"));
    EXPECT_THAT(warnings({"-i", "pssmlt", "--split", "1/1/2"}), HasSubstr("--split has no effect on pssmlt"));
    EXPECT_THAT(warnings({"-i", "bdpt", "--radius", "0.1"}), HasSubstr("--radius has no effect on bdpt"));
    EXPECT_THAT(warnings({"-i", "vpt", "--target", "relative"}), HasSubstr("--target has no effect on vpt"));
    EXPECT_THAT(warnings({"-i", "path", "--connections", "0.5"}),
                HasSubstr("--connections has no effect on path"));
    EXPECT_THAT(warnings({"-i", "scene", "--radius", "0.1"}), HasSubstr("--radius has no effect on path"));
    EXPECT_THAT(warnings({"-i", "pssmlt", "--large-step", "0.5", "--lanes", "2", "--kernel", "adaptive"}),
                testing::Not(HasSubstr("no effect")));
    EXPECT_THAT(warnings({"--split", "auto", "--radius", "0.1", "--replicas", "uvf"}),
                testing::Not(HasSubstr("no effect")));
}

/// What an option says of itself is true: of each integrator and parameter, either the option is warned of
/// and leaves the image as it is, or it is not and the statistics show it.
TEST_F(CliTest, WarningsOfOptionsWithoutEffectAreTrue) {
    std::map<std::string, std::string> options;  // with a value that is not a default
    for (const IntegratorDescription& integrator : integratorList())
        for (const ParameterInfo& info : integrator.parameters)
            options[info.name] = toText(test::otherValues(info).front());
    const auto words = [](std::string name, const std::string& value) {
        std::replace(name.begin(), name.end(), '_', '-');
        if (value == "true") return Words{"--" + name};
        return value == "false" ? Words{"--no-" + name} : Words{"--" + name, value};
    };
    const auto render = [&](const std::string& integrator, const Words& others) {
        const Outcome outcome = run(Words{"render", "scene.xml", "--resolution", "6x4", "--passes", "2", "-o",
                                          "a.exr", "--stats", "a.json", "-i", integrator} +
                                    others);
        EXPECT_EQ(outcome.status, 0) << outcome.err;
        return outcome.err;
    };
    const auto parameters = [&] {
        return nlohmann::json::parse(std::ifstream(folder / "a.json"))["parameters"];
    };
    for (const IntegratorDescription& integrator : integratorList()) {
        render(integrator.name, {});
        const nlohmann::json defaults = parameters();
        EXPECT_EQ(defaults.size(), integrator.parameters.size());
        const std::vector<float> plain = pixels("a.exr");
        Words foreign;
        for (const auto& [name, value] : options) {
            const ParameterSet own(integrator.parameters);  // their defaults may differ from others'
            if (const ParameterInfo* info = own.find(name)) {
                EXPECT_THAT(render(integrator.name, words(name, toText(test::otherValues(*info).front()))),
                            testing::Not(HasSubstr("no effect")));
                EXPECT_NE(parameters()[name], defaults[name]) << integrator.name << ": " << name;
            } else {
                foreign = foreign + words(name, value);
            }
        }
        const std::string warnings = render(integrator.name, foreign);
        for (const auto& [name, value] : options) {
            if (ParameterSet(integrator.parameters).find(name)) continue;
            EXPECT_THAT(warnings, HasSubstr(words(name, value).front() + " has no effect on " +
                                            integrator.name + ": it is for "));
        }
        EXPECT_EQ(pixels("a.exr"), plain) << integrator.name << " reads what it does not have";
        EXPECT_EQ(parameters(), defaults);
    }
}

TEST_F(CliTest, OtherSpellingsOfOptionsAreTheSameOption) {
    for (const char* option : {"--normalization", "--normalisation"}) {
        ASSERT_EQ(
            run({"render", "scene.xml", "--passes", "1", "--stats", "a.json", option, "bennett"}).status, 0);
        EXPECT_EQ(nlohmann::json::parse(std::ifstream(folder / "a.json"))["parameters"]["normalization"],
                  "bennett");
    }
}

/// The tiny scene with this <integrator>.
std::string sceneWith(const std::string& integrator) {
    std::string text = kTinyScene;
    const size_t begin = text.find("<integrator"), end = text.find("</integrator>") + 13;
    return text.replace(begin, end - begin, integrator);
}

TEST_F(CliTest, EveryIntegratorCanBeNamedByTheScene) {
    for (const IntegratorDescription& integrator : integratorList()) {
        Words types = integrator.mitsubaTypes;
        types.push_back(integrator.name);
        for (const std::string& type : types) {
            write("named.xml", sceneWith("<integrator type=\"" + type + "\"/>"));
            const Outcome outcome = run({"render", "named.xml", "-i", "scene", "--resolution", "6x4",
                                         "--passes", "1", "--stats", "a.json"});
            ASSERT_EQ(outcome.status, 0) << outcome.err;
            EXPECT_EQ(nlohmann::json::parse(std::ifstream(folder / "a.json"))["integrator"], integrator.name);
        }
    }
}

TEST_F(CliTest, ParametersInTheSceneHoldUnlessTheCommandSaysOtherwise) {
    write("own.xml", sceneWith(R"(<integrator type="mcmc_vcm"><string name="kernel" value="adaptive"/>
<float name="chain_inefficiency" value="8"/></integrator>)"));
    const auto parameters = [&](const Words& words) {
        const Outcome outcome = run(Words{"render", "own.xml", "--passes", "1", "--stats", "a.json"} + words);
        EXPECT_EQ(outcome.status, 0) << outcome.err;
        return nlohmann::json::parse(std::ifstream(folder / "a.json"))["parameters"];
    };
    for (const char* integrator : {"mcmc_vcm", "scene"}) {
        EXPECT_EQ(parameters({"-i", integrator})["kernel"], "adaptive");
        EXPECT_EQ(parameters({"-i", integrator})["chain_inefficiency"], 8);
        EXPECT_EQ(parameters({"-i", integrator, "--chain-inefficiency", "2"})["chain_inefficiency"], 2);
    }
    EXPECT_EQ(parameters({"-i", "split_mcmc"})["chain_inefficiency"], 4) << "the settings are another's";
}

TEST_F(CliTest, AnUnknownIntegratorOfTheSceneMattersWhereItIsToRender) {
    write("foreign.xml", sceneWith(R"(<integrator type="guided_path"><integer name="max_depth" value="1"/>
<float name="learning_rate" value="0.1"/></integrator>)"));
    const Outcome rendered = run({"render", "foreign.xml", "-i", "path", "--passes", "1", "-o", "a.exr"});
    EXPECT_EQ(rendered.status, 0) << rendered.err;
    EXPECT_THAT(rendered.err, HasSubstr("unknown integrator"));
    write("same.xml",
          sceneWith(R"(<integrator type="path"><integer name="max_depth" value="1"/></integrator>)"));
    ASSERT_EQ(run({"render", "same.xml", "-i", "path", "--passes", "1", "-o", "b.exr"}).status, 0);
    EXPECT_EQ(pixels("a.exr"), pixels("b.exr")) << "its path lengths hold";
    const Outcome refused = run({"render", "foreign.xml", "-i", "scene", "--passes", "1"});
    EXPECT_EQ(refused.status, 2);
    EXPECT_THAT(refused.err, AllOf(HasSubstr("foreign.xml:"), HasSubstr("<integrator type=\"guided_path\">"),
                                   HasSubstr("--integrator")));
    write("vpl.xml", sceneWith("<integrator type=\"vpl\"/>"));
    EXPECT_THAT(run({"render", "vpl.xml", "-i", "scene", "--passes", "1"}).err,
                AllOf(HasSubstr("not supported"), HasSubstr("nearest is \"bdpt\"")));
}

TEST_F(CliTest, ResolutionAndDefinesReplaceTheScenes) {
    ASSERT_EQ(run({"render", "scene.xml", "--passes", "1", "--resolution", "10x6", "-o", "a.exr"}).status, 0);
    EXPECT_EQ(readImage(folder / "a.exr", false).width, 10);
    ASSERT_EQ(run({"render", "scene.xml", "--passes", "1", "-Dwidth=31", "-o", "b.exr"}).status, 0);
    EXPECT_EQ(readImage(folder / "b.exr", false).width, 31);
}

TEST_F(CliTest, MaxDepthOneShowsLightsOnly) {
    ASSERT_EQ(
        run({"render", "scene.xml", "--passes", "4", "--max-depth", "1", "-i", "path", "-o", "a.exr"}).status,
        0);
    ASSERT_EQ(run({"render", "scene.xml", "--passes", "4", "-i", "path", "-o", "b.exr"}).status, 0);
    EXPECT_LT(mean(readImage(folder / "a.exr", false)), 0.5 * mean(readImage(folder / "b.exr", false)));
}

TEST_F(CliTest, StatisticsAreWritten) {
    ASSERT_EQ(run({"render", "scene.xml", "--passes", "20", "--stats", "a.json", "--threads", "1", "--seed",
                   "9", "-i", "scene"})
                  .status,
              0);
    const nlohmann::json s = nlohmann::json::parse(std::ifstream(folder / "a.json"));
    EXPECT_EQ(s["scene"], "scene.xml");
    EXPECT_EQ(s["integrator"], "path") << "what the scene names";
    EXPECT_EQ(s["passes"], 20);
    EXPECT_EQ(s["threads"], 1);
    EXPECT_EQ(s["seed"], 9);
    EXPECT_EQ(s["stop_reason"], "passes");
    EXPECT_GT(s["seconds"], 0);
    EXPECT_GT(s["relative_error"], 0);
    EXPECT_GE(s["rays"]["intersect"], 20 * 24 * 16);
    EXPECT_GT(s["rays"]["shadow"], 0);
    EXPECT_GT(s["rays"]["per_second"], 0);
    EXPECT_GT(s["rays"]["share_of_time"], 0);
    EXPECT_LT(s["rays"]["share_of_time"], 1);
    EXPECT_GT(s["peak_memory_bytes"], 1000000);
    for (const char* technique : {"hit", "nee", "connect", "splat", "merge"})
        EXPECT_EQ(s["non_finite"][technique], 0);
    EXPECT_TRUE(s.contains("integrator_statistics"));
    EXPECT_TRUE(s.contains("version"));
}

TEST_F(CliTest, TimeAndErrorLimitsStop) {
    ASSERT_EQ(run({"render", "scene.xml", "--time", "0.5s", "--stats", "a.json", "-i", "path"}).status, 0);
    const nlohmann::json time = nlohmann::json::parse(std::ifstream(folder / "a.json"));
    EXPECT_EQ(time["stop_reason"], "time");
    EXPECT_GT(time["seconds"], 0.25);
    EXPECT_LT(time["seconds"], 5);
    ASSERT_EQ(
        run({"render", "scene.xml", "--error", "0.5", "--time", "60s", "--stats", "a.json", "-i", "path"})
            .status,
        0);
    const nlohmann::json error = nlohmann::json::parse(std::ifstream(folder / "a.json"));
    EXPECT_EQ(error["stop_reason"], "error");
    EXPECT_LE(error["relative_error"], 0.5);
}

TEST_F(CliTest, SignalsEndThePassAndKeepTheImage) {
    for (int signal : {SIGINT, SIGTERM, SIGHUP}) {
        fs::remove(folder / "a.exr");
        Command command(folder, {"render", "scene.xml", "--time", "1h", "--save-every", "0.01", "-o", "a.exr",
                                 "--stats", "a.json"});
        ASSERT_TRUE(waitFor("a.exr"));
        command.signal(signal);
        const Outcome outcome = command.wait();
        EXPECT_EQ(outcome.status, 3) << outcome.err;
        EXPECT_THAT(outcome.err, HasSubstr("metrolux resume"));
        EXPECT_GT(mean(readImage(folder / "a.exr", false)), 0.001);
        EXPECT_EQ(nlohmann::json::parse(std::ifstream(folder / "a.json"))["stop_reason"], "interrupted");
    }
}

TEST_F(CliTest, OutputThatCannotBeWrittenIsFoundBeforeRendering) {
    fs::create_directory(folder / "folder.exr");
    for (const char* output : {"absent/a.exr", "folder.exr", "/proc/a.exr"}) {
        // If it rendered first, this would take an hour.
        const Outcome outcome = run({"render", "scene.xml", "--time", "1h", "-o", output});
        EXPECT_EQ(outcome.status, 2) << output;
        EXPECT_THAT(outcome.err, HasSubstr(output));
    }
    EXPECT_EQ(run({"render", "scene.xml", "--time", "1h", "--stats", "absent/a.json"}).status, 2);
}

TEST_F(CliTest, ImageIsRescuedWhenTheOutputFolderVanishes) {
    fs::create_directory(folder / "gone");
    Command command(folder,
                    {"render", "scene.xml", "--time", "1h", "--save-every", "0.01", "-o", "gone/a.exr"});
    ASSERT_TRUE(waitFor("gone/a.exr"));
    fs::rename(folder / "gone", folder / "renamed");
    command.signal(SIGINT);
    const Outcome outcome = command.wait();
    EXPECT_EQ(outcome.status, 4) << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr("metrolux-rescue-a.exr"));
    EXPECT_GT(mean(readImage(folder / "metrolux-rescue-a.exr", false)), 0.001);
}

}  // namespace
}  // namespace metrolux::core::cli
