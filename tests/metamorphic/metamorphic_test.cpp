/// A room and the same room elsewhere, turned, mirrored, in other units, with its shapes in another order:
/// the same picture. Nothing is known of the picture itself.
///
/// Both are rendered with the same seeds; the difference of each block's mean has a t-test over the seeds,
/// paired, at a Sidak level for a family rate of 1e-3. A difference below 0.1 % of the block is none:
/// rounding may shift a picture, and the same numbers take nearly the same paths. What the test would nearly
/// always see, twice the critical difference, may not exceed 5 % of the image.

#include "base/parallel.h"
#include "support/block_statistics.h"
#include "support/scene_rendering.h"
#include "support/temporary_folder.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

namespace metrolux::core::test {
namespace {

constexpr int kSeeds = 64, kColumns = 2, kRows = 1, kIntegrators = 4, kVariants = 10;
constexpr double kFamilyRate = 1e-3, kNone = 1e-3, kDetectable = 0.05;

struct Variant {
    const char* name;
    std::string transform = {};  ///< of all that has a place, after its own
    bool reversed = false;       ///< order of the shapes
    bool mirrors = false;        ///< spheres are turned inside out by it, as in Mitsuba 3, and back
};

std::string moved(const std::string& own, const Variant& v) {
    return "<transform name=\"to_world\">" + own + v.transform + "</transform>";
}

/// Closed, with a lamp, a glossy block and a glass ball.
std::string room(const Variant& v) {
    std::vector<std::string> shapes;
    const auto add = [&](const char* type, const std::string& own, const std::string& rest) {
        shapes.push_back(fmt::format("<shape type=\"{}\">{}{}</shape>", type, moved(own, v), rest));
    };
    const auto diffuse = [](const char* rgb) {
        return fmt::format(R"(<bsdf type="diffuse"><rgb name="reflectance" value="{}"/></bsdf>)", rgb);
    };
    add("cube", R"(<scale x="1" y="1" z="1.6"/>)",
        R"(<boolean name="flip_normals" value="true"/>)" + diffuse("0.6,0.5,0.4"));
    add("rectangle", R"(<scale x="0.8" y="1.4" z="1"/><rotate x="1" angle="90"/><translate y="0.98"/>)",
        R"(<emitter type="area"><rgb name="radiance" value="2,1.9,1.8"/></emitter>)");
    add("cube", R"(<scale value="0.3"/><rotate y="1" angle="20"/><translate x="-0.4" y="-0.7" z="-0.6"/>)",
        R"(<bsdf type="roughconductor"><float name="alpha" value="0.2"/></bsdf>)");
    add("sphere", R"(<scale value="0.35"/><translate x="0.4" y="-0.6" z="0.1"/>)",
        fmt::format(R"(<bsdf type="dielectric"/><boolean name="flip_normals" value="{}"/>)", v.mirrors));
    add("rectangle", R"(<scale value="0.4"/><translate x="0.2" z="-1.2"/>)", diffuse("0.1,0.3,0.7"));
    if (v.reversed) std::reverse(shapes.begin(), shapes.end());
    std::string text = R"(<scene version="3.0.0"><integrator type="path">
<integer name="max_depth" value="6"/></integrator><sensor type="perspective"><float name="fov" value="60"/>
<float name="near_clip" value="1e-6"/>)" +
                       moved(R"(<lookat origin="0.1,0.1,1.5" target="0,-0.1,0" up="0,1,0"/>)", v) +
                       R"(<film type="hdrfilm"><integer name="width" value="24"/>
<integer name="height" value="18"/><rfilter type="box"/></film></sensor>)";
    for (const std::string& shape : shapes) text += shape;
    return text + "</scene>";
}

const std::vector<Variant>& variants() {
    static const std::vector<Variant> list = {
        {"movedBy1e3", R"(<translate x="1000" y="-2000" z="1500"/>)"},
        {"movedBy1e5", R"(<translate x="1e5" y="-1e5" z="1e5"/>)"},
        {"movedBy1e6", R"(<translate x="1000000.3" y="-1000000.7" z="1000000.1"/>)"},
        {"movedBy1e9", R"(<translate x="1e9" y="3e8" z="-1e9"/>)"},
        {"turned", R"(<rotate x="0.3" y="1" z="-0.4" angle="137"/>)"},
        {"mirrored", R"(<scale x="-1"/>)", false, true},
        {"inMillimeters", R"(<scale value="1000"/>)"},
        {"inKilometers", R"(<scale value="0.001"/>)"},
        {"reversed", "", true},
        {"movedAndTurned", R"(<rotate z="1" angle="33"/><translate x="-4e6" y="2e6"/><scale value="2"/>)"}};
    return list;
}

std::vector<std::vector<float>> rendered(const Variant& v, const std::string& integrator) {
    const TemporaryFolder folder;
    const RenderableScene scene(folder.write("room.xml", room(v)));
    return scene.renderSeeds(integrator, integrator == "path" ? 12 : 6, 1, kSeeds, 1);
}

class Metamorphic : public testing::TestWithParam<const char*> {};

TEST_P(Metamorphic, theSamePicture) {
    const std::string integrator = GetParam();
    ASSERT_EQ(variants().size(), size_t(kVariants));
    const auto original = rendered({"original", ""}, integrator);
    const double level = sidak(kFamilyRate, double(kIntegrators) * kVariants * kColumns * kRows);
    const double critical =
        boost::math::quantile(boost::math::complement(boost::math::students_t(kSeeds - 1), level / 2));
    BlockStatistics blocks(24, 18, kColumns, kRows);
    for (const auto& image : original) blocks.add(image);
    for (const Variant& v : variants()) {
        const auto other = rendered(v, integrator);
        double seen = 0;
        for (size_t i = 1; i < blocks.size(); i += 3) {  // green
            double sum = 0, squares = 0;
            for (int s = 0; s < kSeeds; ++s) {
                const double d =
                    blocks.blockMeans(other[size_t(s)])[i] - blocks.blockMeans(original[size_t(s)])[i];
                sum += d;
                squares += d * d;
            }
            const double mean = sum / kSeeds;
            const double error = std::sqrt(std::max(squares / kSeeds - mean * mean, 0.0) / (kSeeds - 1));
            EXPECT_LE(std::abs(mean), critical * error + kNone * blocks.mean(i))
                << integrator << ", " << v.name << ": block " << i / 3 << ", channel " << i % 3 << " is "
                << blocks.mean(i) << " and differs by " << mean << " +- " << error;
            seen += 2 * critical * error / (kColumns * kRows);
        }
        EXPECT_LE(seen, kDetectable * blocks.total()) << integrator << ", " << v.name << ": too noisy";
        RecordProperty(v.name, fmt::format("{:.4f}", seen / blocks.total()));
    }
}

INSTANTIATE_TEST_SUITE_P(integrators, Metamorphic, testing::Values("path", "bdpt", "vcm", "mcmc_vcm"),
                         [](const auto& test) { return std::string(test.param); });

}  // namespace
}  // namespace metrolux::core::test
