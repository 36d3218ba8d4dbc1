/// What integrators say of their parameters, and that it is so.

#include "integrators/scene_choice.h"
#include "scattering/null_bsdf.h"
#include "support/parameter_values.h"
#include "support/small_scenes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <set>

namespace metrolux::core {
namespace {

using testing::HasSubstr;

std::vector<std::string> names() {
    std::vector<std::string> result;
    for (const IntegratorDescription& integrator : integratorList()) result.push_back(integrator.name);
    return result;
}

TEST(Integrators, AreAllListedAndMade) {
    test::SceneBuilder b;
    b.camera({0, 0, 5}, {0, 0, 0}, 50, 12, 10);
    const std::shared_ptr<Scene> scene = b.build();
    EXPECT_EQ(integratorList().front().name, kDefaultIntegrator);
    std::set<std::string> types;
    for (const IntegratorDescription& integrator : integratorList()) {
        EXPECT_FALSE(integrator.summary.empty());
        EXPECT_NE(makeIntegrator(integrator.name, *scene), nullptr);
        EXPECT_TRUE(types.insert(integrator.name).second) << integrator.name;
        for (const std::string& type : integrator.mitsubaTypes)
            EXPECT_TRUE(types.insert(type).second) << type << " is two integrators";
    }
    EXPECT_THAT([] { findIntegrator("bdtp"); }, testing::ThrowsMessage<Error>(HasSubstr("'bdpt'")));
    for (const char* bad : {"", "x", "uvz"})
        EXPECT_THROW(makeIntegrator("mcmc_vcm", *scene, {}, {{"replicas", bad}}), Error) << bad;
    EXPECT_NE(makeIntegrator("mcmc_vcm", *scene, {}, {{"replicas", "uvf"}}), nullptr);
    for (const char* withoutContribution : {"vpt", "split_mcmc"}) {
        EXPECT_THROW(makeIntegrator(withoutContribution, *scene, {}, {{"replicas", "uvf"}}), Error);
        EXPECT_THROW(makeIntegrator(withoutContribution, *scene, {}, {{"split", "auto"}}), Error);
    }
    EXPECT_THROW(makeIntegrator("mcmc_vcm", *scene, {}, {{"replicas", "uv"}, {"split", "auto"}}), Error);
    EXPECT_THAT(
        [&] {
            makeIntegrator("path", *scene, {}, {{"radius", 1}});
        },
        testing::ThrowsMessage<Error>(HasSubstr("integrator path: unknown parameter 'radius'")));
}

TEST(Integrators, ParametersHaveNamesHelpAndOtherValues) {
    for (const IntegratorDescription& integrator : integratorList()) {
        std::set<std::string> all{"max_depth", "rr_depth", "hide_emitters", "seed", "memory"};
        for (const ParameterInfo& info : integrator.parameters) {
            const std::string what = integrator.name + ": " + info.name;
            EXPECT_TRUE(all.insert(info.name).second) << what;
            if (!info.alias.empty()) {
                EXPECT_TRUE(all.insert(info.alias).second) << what;
            }
            EXPECT_EQ(info.name.find_first_not_of("abcdefghijklmnopqrstuvwxyz_"), std::string::npos) << what;
            EXPECT_GE(info.help.size(), 10u) << what;
            EXPECT_LE(info.help.size(), 110u) << what << ": a line of help";
            EXPECT_EQ(info.help.find('\n'), std::string::npos) << what;
            EXPECT_FALSE(test::otherValues(info).empty()) << what;
            EXPECT_EQ(info.checked(info.defaultValue), info.defaultValue) << what;
            EXPECT_EQ(info.checked(toText(info.defaultValue)), info.defaultValue) << what;
        }
    }
}

/// A room where everything that parameters steer takes part: hidden light, glass, a lit floor.
std::shared_ptr<Scene> room(bool fog = false) {
    test::SceneBuilder b;
    if (fog) {
        b.media() = {makeHomogeneousMedium(Rgb(0.2f), Rgb(0.9f), makeIsotropicPhase())};
        b.add(makeSphere(Transform(), {0, 1, 0}, 9, false), makeNullBsdf())->media = MediumSides{1, 0};
    }
    b.add(test::rectangle({0, 0, 0}, {0, 1, 0}, 4, 4), test::diffuse(0.7f));
    b.add(makeSphere(Transform(), {0, 1, 0}, 0.7f, false), makeDielectric({}));
    b.emit(b.add(test::rectangle({0.5f, 3, 0}, {0, -1, 0}, 0.7f, 0.5f), test::diffuse(0.3f)), Rgb(5));
    b.camera({0, 1.5f, 5}, {0, 1, 0}, 50, 24, 20);
    return b.build();
}

class EachDescription : public testing::TestWithParam<std::string> {};

/// Each parameter that an integrator has changes what it renders; none but those can be given.
TEST_P(EachDescription, ParametersChangeTheImage) {
    const std::shared_ptr<Scene> clear = room(), foggy = room(true);
    const auto image = [&](const ParameterValues& values) {
        const std::shared_ptr<Scene>& scene = values.contains("medium_radius") ? foggy : clear;
        Film film = makeFilm(*scene);
        CommonOptions options;
        options.seed = 5;
        const auto integrator = makeIntegrator(GetParam(), *scene, options, values);
        for (int pass = 0; pass < 8; ++pass) integrator->renderPass(film, film.passes());
        return film.image();
    };
    const std::vector<float> plain = image({});
    for (const ParameterInfo& info : findIntegrator(GetParam()).parameters) {
        ParameterValues values;
        // The steering of theta is that of the adaptive kernel.
        if (info.name == "theta") values["kernel"] = "adaptive";
        // Merging in media needs one.
        if (info.name == "medium_radius") values["medium_radius"] = 0.5;
        const std::vector<float> reference = values.empty() ? plain : image(values);
        bool changes = false;
        for (const ParameterValue& value : test::otherValues(info)) {
            values[info.name] = value;
            changes = changes || image(values) != reference;
            if (changes) break;
        }
        EXPECT_TRUE(changes) << info.name << " changes nothing";
    }
    for (const IntegratorDescription& other : integratorList())
        for (const ParameterInfo& info : other.parameters)
            if (!ParameterSet(findIntegrator(GetParam()).parameters).find(info.name)) {
                EXPECT_THROW(image({{info.name, info.defaultValue}}), Error) << info.name;
            }
}
INSTANTIATE_TEST_SUITE_P(All, EachDescription, testing::ValuesIn(names()),
                         [](const auto& i) { return i.param; });

SceneParts partsWith(const std::string& type, std::vector<std::pair<std::string, ParameterValue>> settings,
                     bool legacy = false) {
    SceneParts parts;
    parts.integrator.type = type;
    parts.integrator.where = "a.xml:3: <integrator>";
    parts.integrator.legacy = legacy;
    for (const auto& [name, value] : settings)
        parts.integrator.settings.push_back({name, value, "a.xml:4: property \"" + name + "\""});
    return parts;
}
IntegratorChoice choose(const std::string& chosen, SceneParts parts, const ParameterValues& given = {}) {
    settleSceneIntegrator(parts, false);
    return chooseIntegrator(chosen, parts.integrator, given);
}

TEST(SceneIntegrators, EveryNameAndTypeOfMitsubaIsAnIntegrator) {
    for (const IntegratorDescription& integrator : integratorList()) {
        EXPECT_EQ(choose("scene", partsWith(integrator.name, {})).name(), integrator.name);
        for (const std::string& type : integrator.mitsubaTypes)
            EXPECT_EQ(choose("scene", partsWith(type, {})).name(), integrator.name) << type;
    }
    EXPECT_EQ(choose("scene", {}).name(), "path") << "a scene that names none";
}

TEST(SceneIntegrators, SettingsHoldWhereTheIntegratorIsUsedAndGivenValuesOverThem) {
    const SceneParts sppm = partsWith("ppm", {{"initial_radius", 0.5}, {"photon_count", 1000}});
    EXPECT_EQ(choose("scene", sppm).parameters.get("radius"), ParameterValue(0.5));
    EXPECT_EQ(choose("sppm", sppm).parameters.get("radius"), ParameterValue(0.5));
    EXPECT_EQ(choose("vcm", sppm).parameters.get("radius"), ParameterValue(0.0)) << "another's setting";
    EXPECT_EQ(choose("scene", sppm, {{"radius", 2}}).parameters.get("radius"), ParameterValue(2.0));
    EXPECT_EQ(choose("scene", partsWith("pssmlt", {{"p_large", 0.7}})).parameters.get("large_step"),
              ParameterValue(0.7));
    EXPECT_EQ(choose("mcmc_vcm", partsWith("mcmc_vcm", {{"kernel", "adaptive"}})).parameters.get("kernel"),
              ParameterValue("adaptive"));
}

TEST(SceneIntegrators, WrongSettingsSayWhereTheyAreAndWhatIsExpected) {
    const auto error = [](const SceneParts& parts) -> std::string {
        try {
            choose("path", parts);
        } catch (const Error& problem) {
            return problem.what();
        }
        return "";
    };
    EXPECT_EQ(error(partsWith("vcm", {{"radius", -1.0}})),
              "a.xml:4: property \"radius\": found '-1', expected a number of 0 or more");
    EXPECT_THAT(error(partsWith("vcm", {{"raduis", 1.0}})), HasSubstr("did you mean \"radius\"?"));
    EXPECT_THAT(error(partsWith("path", {{"photon_count", 1}})), HasSubstr("a.xml:4"));
    SceneParts old = partsWith("path", {{"max_dept", 1}}, true);
    settleSceneIntegrator(old, false);
    EXPECT_THAT(old.warnings, testing::ElementsAre(HasSubstr("\"max_depth\"?"))) << "a warning in 0.x";
    EXPECT_EQ(error(partsWith("path", {{"photon_count", 1}}, true)), "") << "left behind in an old scene";
    SceneParts lenient = partsWith("vcm", {{"raduis", 1.0}, {"radius", -1.0}, {"connections", 0.5}});
    settleSceneIntegrator(lenient, true);
    EXPECT_EQ(lenient.warnings.size(), 2u);
    EXPECT_EQ(chooseIntegrator("scene", lenient.integrator).parameters.get("connections"),
              ParameterValue(0.5));
    SceneParts spent = partsWith("path", {{"samples_per_pass", 4}, {"block_size", 8}});
    settleSceneIntegrator(spent, false);
    EXPECT_THAT(spent.warnings, testing::ElementsAre(AllOf(HasSubstr("\"samples_per_pass\", \"block_size\""),
                                                           HasSubstr("no effect"))));
}

TEST(SceneIntegrators, UnknownTypesAreErrorsWhereTheyAreToRender) {
    const auto errorOf = [](const std::string& type) -> std::string {
        try {
            choose("scene", partsWith(type, {{"anything", 3}}));
        } catch (const Error& problem) {
            return problem.what();
        }
        return "";
    };
    EXPECT_THAT(errorOf("pathh"), AllOf(HasSubstr("a.xml:3"), HasSubstr("did you mean \"path\"?")));
    for (const auto& [type, nearest] :
         {std::pair("erpt", "pssmlt"), {"vpl", "bdpt"}, {"prb_reparam", "path"}}) {
        EXPECT_THAT(errorOf(type), AllOf(HasSubstr("not supported"), HasSubstr(nearest)));
        EXPECT_NO_THROW(findIntegrator(nearest));
    }
    SceneParts foreign = partsWith("guided_path", {{"anything", 3}});
    settleSceneIntegrator(foreign, false);
    EXPECT_THAT(foreign.warnings, testing::ElementsAre(HasSubstr("unknown integrator")));
    EXPECT_EQ(chooseIntegrator("path", foreign.integrator).name(), "path");
}

}  // namespace
}  // namespace metrolux::core
