/// Recursive MIS weights against brute force: for random paths of every technique, the weight that transport/
/// applies is compared with one made of the products of all densities along the path
/// (docs/explain/algorithm.md section 1), and the weights of all techniques of one path must sum to one.
/// Deterministic: fixed seeds. 99.9 % of the paths must agree to 1e-4 (relative) and all to 2e-3 (8e-3 where
/// a quarter of the light subpaths is connected): vertices are single precision, and refraction magnifies the
/// rounding of a few. A wrong cosine, count or index of refraction shows as deviations of 1e-2 to 1 in most
/// paths.

#include "oracle/technique_paths.h"
#include "sampling/streams.h"
#include "support/eye_factors.h"

#include <gtest/gtest.h>

#include <numeric>

namespace metrolux::core {
namespace {

using namespace test;

struct Case {
    Lighting lighting;
    bool merging;
    double connect = 1;  ///< Strategies::connect
    Lens lens = Lens::Pinhole;
    Materials materials = Materials::Plain;
    int wanted = 10000;  ///< paths of each technique
    double nee = 1;      ///< next-event estimations for each hit
};

std::string nameOf(const Case& c) {
    constexpr std::array kLights{"Area",        "SphereArea",        "TexturedArea",   "Point",
                                 "Spot",        "Projector",         "Collimated",     "Goniometric",
                                 "Directional", "Constant",          "EnvironmentMap", "SunSky",
                                 "Many",        "ManyAndEnvironment"};
    constexpr std::array kLenses{"", "ThinLens", "Orthographic", "Panorama", "Fisheye"};
    constexpr std::array kMaterials{"", "MixedLobes", "ShadingNormals", "Layered", "Media", "Dispersive"};
    std::string name = kLights[static_cast<size_t>(c.lighting)];
    name += kLenses[static_cast<size_t>(c.lens)];
    name += kMaterials[static_cast<size_t>(c.materials)];
    if (c.merging) name += "Merging";
    if (c.connect < 1) name += "ConnectedInPart";
    return name;
}

void PrintTo(const Case& c, std::ostream* out) { *out << nameOf(c); }

std::vector<Case> everyLight() {
    std::vector<Case> cases;
    for (const Lighting l :
         {Lighting::Area, Lighting::SphereArea, Lighting::Point, Lighting::Directional, Lighting::Constant})
        for (const bool merging : {false, true})
            for (const double connect : {1.0, 0.25}) cases.push_back({l, merging, connect});
    for (const Lighting l :
         {Lighting::TexturedArea, Lighting::Spot, Lighting::Projector, Lighting::Collimated,
          Lighting::Goniometric, Lighting::EnvironmentMap, Lighting::SunSky})
        cases.push_back({l, true, 0.25, Lens::Pinhole, Materials::Plain, 3000, 1.7});
    return cases;
}

std::vector<Case> everyCombination() {
    std::vector<Case> cases;
    for (const Lighting l : {Lighting::Area, Lighting::Many, Lighting::ManyAndEnvironment})
        for (const Lens lens : {Lens::Pinhole, Lens::Thin, Lens::Orthographic, Lens::Panorama, Lens::Fisheye})
            for (const Materials m :
                 {Materials::Plain, Materials::Mixed, Materials::Shading, Materials::Layered}) {
                if (l == Lighting::Area && lens == Lens::Pinhole && m == Materials::Plain) continue;
                // In turn, so that each occurs with each kind of light, lens and material.
                const auto turn = static_cast<int>(l) + static_cast<int>(lens) + static_cast<int>(m);
                cases.push_back({l, turn % 3 != 0, turn % 2 == 0 ? 1 : 0.25, lens, m, 3000, 1.7});
            }
    return cases;
}

std::vector<Case> media() {
    std::vector<Case> cases;
    for (const Lighting l : {Lighting::Area, Lighting::SphereArea, Lighting::Point, Lighting::Directional,
                             Lighting::Constant, Lighting::ManyAndEnvironment})
        for (const Lens lens : {Lens::Pinhole, Lens::Thin, Lens::Orthographic}) {
            const auto turn = static_cast<int>(l) + static_cast<int>(lens);
            cases.push_back({l, turn % 3 != 0, turn % 2 == 0 ? 1 : 0.25, lens, Materials::Media, 3000, 1.7});
        }
    return cases;
}

std::vector<Case> dispersion() {
    std::vector<Case> cases;
    for (const Lighting l : {Lighting::Area, Lighting::Point, Lighting::Constant})
        cases.push_back({l, true, 1, Lens::Pinhole, Materials::Dispersive, 3000, 1.7});
    return cases;
}

/// A density of photons that makes the shares of merging differ from vertex to vertex.
void countPhotons(const Scene& scene, PhotonDensity& photons) {
    constexpr int kSubpaths = 2000;
    for (uint64_t i = 0; i < kSubpaths; ++i) {
        IndependentStream stream(hashKey(i, 4));
        Collector subpath;
        traceLightSubpath(scene, stream, scene.parts().limits, Strategies::path(), subpath);
        for (const Vertex& v : subpath.vertices) photons.count(v.si.p);
    }
    photons.endIteration(0.01 * kSubpaths);  // as if a hundred times as dense
}

/// How the weights of one technique's paths deviate.
struct Deviations {
    std::vector<double> relative;
    std::set<const Light*> lights;  ///< of the paths
};

class MisOracle : public ::testing::TestWithParam<Case> {};

TEST_P(MisOracle, RecursiveWeightsEqualBruteForceAndSumToOne) {
    const Case& c = GetParam();
    const OracleScene oracleScene = makeOracleScene(c.lighting, c.lens, c.materials);
    const Scene& scene = *oracleScene.scene;
    PhotonDensity photons(0.5);
    countPhotons(scene, photons);
    const double radius = 0.05, pixels = kImageWidth * kImageHeight;
    Strategies n = Strategies::bidirectional(3.7, c.merging ? pixels * std::numbers::pi * radius * radius : 0,
                                             &photons, 0.3);
    n.connect = c.connect;
    n.nee *= c.nee;
    if (c.materials == Materials::Media) n.mergeInMedia = 0.7;
    if (c.materials == Materials::Dispersive) n.wavelength = {kGlassWavelength, Rgb(1.0f)};
    // Half of the cases with factors of what eye subpaths find alone.
    EyeFactors factors(scene.camera().window());
    CounterRng rng(7);
    setRandomEyeFactors(factors, static_cast<uint32_t>(scene.camera().window().pixelCount()), rng);
    if (c.merging || c.connect < 1) n.eyeFactors = &factors;
    const BruteForce bruteForce(oracleScene, n);

    std::map<std::string, Deviations> found;
    double worstSum = 0;
    std::map<std::string, int> inMedia;  // vertices, for each technique
    int mixed = 0;                       // vertices at which a path follows one of several kinds of lobes
    const auto check = [&](const TechniqueKey& technique, const FullPath& path, double weight) {
        if (!path.found || !bruteForce.wellConditioned(path)) return;
        const auto weights = bruteForce.weights(path);
        double sum = 0;
        for (const auto& [key, w] : weights) sum += w;
        worstSum = std::max(worstSum, std::abs(sum - 1));
        const auto it = weights.find(technique);
        ASSERT_NE(it, weights.end()) << technique.first << " " << technique.second
                                     << " is not a technique of this path";
        Deviations& d = found[technique.first];
        d.relative.push_back(std::abs(weight - it->second) / std::max(it->second, 1e-3));
        d.lights.insert(path.light);
        for (const InnerVertex& v : path.inner) inMedia[technique.first] += v.si.ng == Vec3f(0.0f);
        for (const InnerVertex& v : path.inner) mixed += v.delta && v.si.shape->bsdf->hasSmoothLobe();
    };

    const auto& lights = scene.lights();
    const bool canBeHit = std::any_of(lights.begin(), lights.end(), [](auto&l) { return !l->isDelta(); }),
               canBeConnected =
                   std::any_of(lights.begin(), lights.end(), [](auto&l) { return l->isConnectable(); });
    std::vector<std::string> techniques{"connect", "splat"};
    if (canBeHit) techniques.push_back("hit");
    if (canBeConnected) techniques.push_back("nee");
    if (c.merging) techniques.push_back("merge");
    const auto wanted = [&](const std::string& name) {
        return std::find(techniques.begin(), techniques.end(), name) != techniques.end() &&
               found[name].relative.size() < static_cast<size_t>(c.wanted);
    };
    TechniquePaths paths(oracleScene, n, check, wanted);
    constexpr uint64_t kMostSubpaths = 1000000;
    for (uint64_t i = 0; i < kMostSubpaths && std::any_of(techniques.begin(), techniques.end(), wanted); ++i)
        paths.run(i);

    for (const std::string& name : techniques) {
        SCOPED_TRACE(name);
        Deviations& d = found[name];
        std::sort(d.relative.begin(), d.relative.end());
        ASSERT_GE(d.relative.size(), static_cast<size_t>(c.wanted));
        EXPECT_LT(d.relative[d.relative.size() * 999 / 1000], 1e-4);
        // Rounding changes the sum of the others; how much of that a weight feels grows as it is made
        // smaller.
        EXPECT_LT(d.relative.back(), 2e-3 / c.connect);
        for (size_t k = 0; k < lights.size(); ++k) {
            const LightPtr& light = lights[k];
            if ((name == "hit" && !light->isDelta()) || (name == "nee" && light->isConnectable()) ||
                (name != "hit" && name != "nee")) {
                EXPECT_TRUE(d.lights.contains(light.get())) << "no path of light " << k;
            }
        }
    }
    EXPECT_LT(worstSum, 1e-9);
    if (c.merging) {
        EXPECT_GT(paths.reducedShares(), 1000) << "the photons' density made no difference";
    }
    if (c.materials == Materials::Media) {
        for (const std::string& name : techniques)
            EXPECT_GT(inMedia[name], 300) << name << ": hardly a vertex in a medium";
    }
    if (c.materials == Materials::Mixed || c.materials == Materials::Layered) {
        EXPECT_GT(mixed, 1000) << "hardly a path follows a coat or a veil";
    }
}

INSTANTIATE_TEST_SUITE_P(Lights, MisOracle, ::testing::ValuesIn(everyLight()),
                         [](const auto& i) { return nameOf(i.param); });
INSTANTIATE_TEST_SUITE_P(Media, MisOracle, ::testing::ValuesIn(media()),
                         [](const auto& i) { return nameOf(i.param); });
INSTANTIATE_TEST_SUITE_P(Dispersion, MisOracle, ::testing::ValuesIn(dispersion()),
                         [](const auto& i) { return nameOf(i.param); });
INSTANTIATE_TEST_SUITE_P(Scenes, MisOracle, ::testing::ValuesIn(everyCombination()),
                         [](const auto& i) { return nameOf(i.param); });

}  // namespace
}  // namespace metrolux::core
