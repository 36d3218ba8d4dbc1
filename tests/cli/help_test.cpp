#include "command.h"
#include "paths.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include <fstream>

namespace metrolux::core::cli {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::IsEmpty;

TEST_F(CliTest, HelpTeachesWithExamples) {
    for (const std::vector<std::string>& command : {std::vector<std::string>{"--help"},
                                                    {"render", "--help"},
                                                    {"view", "--help"},
                                                    {"resume", "--help"},
                                                    {"merge", "--help"},
                                                    {"compare", "--help"},
                                                    {"study", "--help"},
                                                    {"bench", "--help"},
                                                    {"info", "-h"}}) {
        const Outcome outcome = run(command);
        EXPECT_EQ(outcome.status, 0) << command[0];
        EXPECT_THAT(outcome.out, HasSubstr("Examples:\n  metrolux ")) << command[0];
        EXPECT_THAT(outcome.err, IsEmpty()) << command[0];
    }
    EXPECT_EQ(run({"integrators", "--help"}).status, 0);
}

TEST_F(CliTest, VersionIsPrinted) {
    const Outcome outcome = run({"--version"});
    EXPECT_EQ(outcome.status, 0);
    EXPECT_THAT(outcome.out, testing::MatchesRegex("metrolux [0-9]+\\.[0-9]+\\.[0-9]+\n"));
}

TEST_F(CliTest, WithoutACommandItShowsHelpAndFails) {
    const Outcome outcome = run({});
    EXPECT_EQ(outcome.status, 2);
    EXPECT_THAT(outcome.err, HasSubstr("render"));
}

TEST_F(CliTest, IntegratorsAreListed) {
    const Outcome outcome = run({"integrators"});
    EXPECT_EQ(outcome.status, 0);
    const std::string lines = fmt::format("\n{}", outcome.out);
    for (const std::string& name : integratorNames())
        EXPECT_THAT(lines, HasSubstr(fmt::format("\n{} ", name))) << "each begins a line";
    EXPECT_THAT(run({"integrators", "pssmlt"}).out, AllOf(HasSubstr("--large-step X"), HasSubstr("p_large")));
    EXPECT_THAT(run({"integrators", "psmlt"}).err, HasSubstr("did you mean 'pssmlt'?"));
}

TEST_F(CliTest, ThePageOfParametersIsThatOfTheProgram) {
    std::ifstream file(fs::path(METROLUX_SOURCE_DIR) / "docs/reference/parameters.md");
    const std::string page((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
    EXPECT_EQ(run({"integrators", "--markdown"}).out, page)
        << "metrolux integrators --markdown > docs/reference/parameters.md";
}

TEST_F(CliTest, ProgramsReadTheIntegratorsAsJson) {
    std::vector<std::string> names;
    for (const nlohmann::json& integrator : nlohmann::json::parse(run({"integrators", "--json"}).out)) {
        names.push_back(integrator["name"]);
        for (const nlohmann::json& p : integrator["parameters"])
            for (const char* field : {"name", "help", "default", "expected"})
                EXPECT_FALSE(p.at(field).get<std::string>().empty()) << integrator["name"] << p;
    }
    EXPECT_EQ(names, integratorNames());
    EXPECT_EQ(run({"integrators", "--json", "--markdown"}).status, 2);
}

TEST_F(CliTest, InfoShowsWhatWasUnderstood) {
    const Outcome outcome = run({"info", "scene.xml", "-D", "width=40"});
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    for (const char* text :
         {"40x16 pixels", "gaussian", "path", "at most 8 edges", "1 Sphere", "AreaLight", "Dielectric"})
        EXPECT_THAT(outcome.out, HasSubstr(text));
}

TEST_F(CliTest, InfoReadsFragmentsAndRenderSaysWhatIsMissing) {
    write("fragment.xml",
          R"(<scene version="2.1.0"><shape type="rectangle"/><emitter type="constant"/></scene>)");
    const Outcome info = run({"info", "fragment.xml"});
    EXPECT_EQ(info.status, 0) << info.err;
    for (const char* text : {"sensor      none", "1 TriangleMesh", "ConstantLight", "no <sensor>"})
        EXPECT_THAT(info.out, HasSubstr(text));
    const Outcome render = run({"render", "fragment.xml", "--passes", "1"});
    EXPECT_EQ(render.status, 2);
    EXPECT_THAT(render.err, HasSubstr("found no <sensor>"));
}

TEST_F(CliTest, InfoPrintsJson) {
    const Outcome outcome = run({"info", "scene.xml", "--json"});
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    const auto json = nlohmann::json::parse(outcome.out);
    EXPECT_EQ(json["film"]["size"], (std::vector<int>{24, 16}));
    EXPECT_EQ(json["integrator"]["max_depth"], 8);
    EXPECT_EQ(json["shapes"]["Sphere"], 1);
    EXPECT_TRUE(json["warnings"].empty());
}

TEST_F(CliTest, StrictRefusesWhatIsWarnedOf) {
    write("warned.xml",
          R"(<scene version="3.0.0"><sensor type="perspective" id="a"/><sensor type="perspective"/>
        <emitter type="constant"/></scene>)");
    EXPECT_EQ(run({"info", "warned.xml"}).status, 0);
    for (const char* command : {"info", "render"}) {
        const Outcome outcome = run({command, "warned.xml", "--strict"});
        EXPECT_EQ(outcome.status, 2);
        EXPECT_THAT(outcome.err, HasSubstr("2 sensors"));
    }
    EXPECT_EQ(run({"info", "warned.xml", "--strict", "--sensor", "a"}).status, 0);
    EXPECT_EQ(run({"info", "warned.xml", "--strict", "--lenient"}).status, 2);
}

TEST_F(CliTest, WrongOptionsFailWithStatus2AndSayWhatIsWrong) {
    const std::vector<std::pair<std::vector<std::string>, std::string>> cases{
        {{"rendr", "scene.xml"}, "Did you mean render?"},
        {{"render"}, "scene"},
        {{"render", "scene.xml", "--tme", "5s"}, "Did you mean --time?"},
        {{"render", "scene.xml", "--time", "5x"}, "5x"},
        {{"render", "scene.xml", "--time", "0"}, "longer than zero"},
        {{"render", "scene.xml", "--passes", "-3"}, "--passes: '-3'"},
        {{"render", "scene.xml", "--passes", "many"}, "--passes: 'many'"},
        {{"render", "scene.xml", "--error", "nan"}, "--error nan: expected a number above zero"},
        {{"render", "scene.xml", "--seed", "-1"}, "--seed: '-1'"},
        {{"render", "scene.xml", "--threads", "0"}, "--threads: '0'"},
        {{"render", "scene.xml", "--resolution", "12"}, "WIDTHxHEIGHT"},
        {{"render", "scene.xml", "--resolution", "99999999x99999999"}, "65536"},
        {{"render", "scene.xml", "--resolution", "1000000x1000000"}, "65536"},
        {{"render", "scene.xml", "--resolution", "65536x65536"}, "65536 x 65536 pixels is too large"},
        {{"render", "scene.xml", "--scene-memory", "1k", "--passes", "1"}, "would take"},
        {{"render", "scene.xml", "--crop", "1,2,3"}, "x,y,width,height"},
        {{"render", "scene.xml", "--crop", "20,0,10,10", "--passes", "1"}, "crop"},
        {{"render", "scene.xml", "--memory", "4X"}, "4X"},
        {{"render", "scene.xml", "--curve", "aces"}, "aces"},
        {{"render", "scene.xml", "--replicas", "uvw"}, "--replicas: found 'uvw', expected some of"},
        {{"render", "scene.xml", "--replicas", "uvf", "-i", "vpt"}, "--replicas: found 'uvf'"},
        {{"render", "scene.xml", "--radius", "-1"}, "--radius: found '-1', expected a number of 0 or more"},
        {{"render", "scene.xml", "--lanes", "2.5"}, "--lanes: found '2.5', expected a whole number from"},
        {{"render", "scene.xml", "--split", "1/0/1"}, "--split: found '1/0/1'"},
        {{"render", "scene.xml", "--split", "1/2"}, "--split: found '1/2'"},
        {{"render", "scene.xml", "--split", "1/2/3x"}, "--split: found '1/2/3x'"},
        {{"render", "scene.xml", "--split", "automatic"}, "expected `auto`"},
        {{"render", "scene.xml", "--split", "auto", "-i", "vpt", "--passes", "1"}, "--split: found 'auto'"},
        {{"render", "scene.xml", "--split", "auto", "--replicas", "uv", "--passes", "1"}, "replica f"},
        {{"render", "scene.xml", "--target", "brightness"}, "--target"},
        {{"render", "scene.xml", "--normalization", "none"}, "--normalization"},
        {{"render", "scene.xml", "--theta", "1"}, "--theta"},
        {{"render", "scene.xml", "--large-step", "1.5"}, "--large-step"},
        {{"render", "scene.xml", "--method", "C"}, "--method"},
        {{"render", "scene.xml", "--aov", "color"}, "color"},
        {{"render", "scene.xml", "-i", "vcm", "--radius", "1e10"},
         "merging radius 1e+10: found a scene of radius"},
        {{"render", "scene.xml", "-i", "sppm", "--radius", "1e-30"}, "merging radius 1e-30"},
        {{"render", "scene.xml", "--passes", "16777216"}, "16777215"},
        {{"render", "scene.xml", "--threads", "5000"}, "4096"},
        {{"render", "scene.xml", "--time", "1e30s"}, "a hundred years"},
        {{"render", "scene.xml", "--error", "1e30"}, "--error"},
        {{"render", "scene.xml", "--save-every", "1e300h"}, "a hundred years"},
        {{"render", "scene.xml", "--memory", "1"}, "--memory"},
        {{"render", "scene.xml", "--progress", "xml"}, "--progress"},
        {{"render", "scene.xml", "-D", "width"}, "name=value"},
        {{"render", "scene.xml", "-i", "mcmc_vmc"}, "did you mean 'mcmc_vcm'"},
        {{"render", "scene.xml", "-o", "a.gif"}, ".gif"},
        {{"render", "scene.xml", "other.xml"}, "other.xml"},
        {{"render", "absent.xml", "--passes", "1"}, "absent.xml"},
        {{"info", "absent.xml"}, "absent.xml"},
        {{"compare", "absent.exr", "absent.exr"}, "absent.exr"},
        {{"compare", "absent.exr"}, "reference"},
    };
    for (const auto& [arguments, message] : cases) {
        const Outcome outcome = run(arguments);
        const std::string line = testing::PrintToString(arguments);
        EXPECT_EQ(outcome.status, 2) << line;
        EXPECT_THAT(outcome.err, HasSubstr(message)) << line;
        EXPECT_THAT(outcome.out, IsEmpty()) << line;
    }
}

TEST_F(CliTest, MalformedScenesFailWithStatus2) {
    const std::string scene = kTinyScene;
    const auto replaced = [&](const std::string& from, const std::string& to) {
        std::string text = scene;
        const size_t at = text.find(from);
        EXPECT_NE(at, std::string::npos) << from;
        return text.replace(at, from.size(), to);
    };
    const std::vector<std::pair<std::string, std::string>> cases{
        {"empty", ""},
        {"not XML", "this is not a scene"},
        {"cut off", scene.substr(0, scene.size() / 2)},
        {"another root", "<html></html>"},
        {"unknown bsdf", replaced("type=\"dielectric\"", "type=\"dielectrik\"")},
        {"unknown property", replaced("name=\"radius\"", "name=\"radios\"")},
        {"number that is none", replaced("name=\"fov\" value=\"50\"", "name=\"fov\" value=\"wide\"")},
        {"infinite number", replaced("name=\"radius\" value=\"0.5\"", "name=\"radius\" value=\"inf\"")},
        {"film of no size", replaced("value=\"$width\"", "value=\"0\"")},
        {"film of monstrous size", replaced("value=\"$width\"", "value=\"2000000000\"")},
        {"undefined parameter", replaced("value=\"16\"", "value=\"$undefined\"")},
        {"dangling reference", replaced("<bsdf type=\"dielectric\"/>", "<ref id=\"nowhere\"/>")},
        {"absent mesh",
         replaced("<shape type=\"sphere\">",
                  "<shape type=\"obj\"><string name=\"filename\" value=\"absent.obj\"/></shape>"
                  "<shape type=\"sphere\">")},
        {"camera without extent",
         replaced("<lookat origin=\"0, 1, -4\"", "<scale value=\"0\"/><lookat origin=\"0, 1, -4\"")},
        {"no sensor", replaced("<sensor type=\"perspective\">", "<sensor type=\"nothing\">")},
    };
    for (const auto& [name, text] : cases) {
        write("bad.xml", text);
        const Outcome outcome = run({"render", "bad.xml", "--passes", "1"});
        EXPECT_EQ(outcome.status, 2) << name << ": " << outcome.err;
        EXPECT_THAT(outcome.err, HasSubstr("bad.xml")) << name;
        EXPECT_FALSE(std::filesystem::exists(folder / "bad.exr")) << name;
    }
}

}  // namespace
}  // namespace metrolux::core::cli
