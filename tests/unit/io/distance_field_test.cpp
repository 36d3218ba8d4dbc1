/// Signed distances and hairs as meshes: sizes against closed forms, and damaged files.

#include "io/distance_field.h"

#include "cases_support.h"

#include <gmock/gmock.h>

#include <cstring>
#include <map>
#include <numbers>

namespace metrolux::core::test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

constexpr double kTau = 2 * std::numbers::pi;

template <class T>
void append(std::string& data, const T& value) {
    char bytes[sizeof(T)];
    std::memcpy(bytes, &value, sizeof(T));
    data.append(bytes, sizeof(T));
}

/// A .vol file of n x n x n values of a function of the point of the unit cube.
template <class Function>
std::string volumeFile(int n, const Function& function, int channels = 1) {
    std::string data = "VOL\3";
    for (const int number : {1, n, n, n, channels}) append(data, int32_t(number));
    for (const float bound : {0.0f, 0.0f, 0.0f, 1.0f, 1.0f, 1.0f}) append(data, bound);
    const auto at = [n](int i) { return static_cast<float>(i) / static_cast<float>(std::max(n - 1, 1)); };
    for (int z = 0; z < n; ++z)
        for (int y = 0; y < n; ++y)
            for (int x = 0; x < n; ++x)
                for (int c = 0; c < channels; ++c) append(data, float(function(Vec3f(at(x), at(y), at(z)))));
    return data;
}
std::string sphereFile(int n, float radius, int channels = 1) {
    return volumeFile(
        n, [&](const Vec3f& p) { return (p - Vec3f(0.5f)).length() - radius; }, channels);
}

SceneParts loadDistances(const std::string& file, const std::string& more = "") {
    const TemporaryFolder folder;
    folder.write("data.vol", file);
    return loadScene(folder.write("scene.xml", underSky(R"(<shape type="sdfgrid"><string name="filename"
value="data.vol"/>)" + more + "</shape>")),
                     {});
}

const TriangleMesh& meshOf(const SceneParts& parts) {
    return dynamic_cast<const TriangleMesh&>(*parts.shapes.at(0));
}

TEST(DistanceField, PlanesAreExact) {
    const auto area = [](const Vec3f& normal, float at) {
        return double(loadDistances(volumeFile(4, [&](const Vec3f& p) { return dot(p, normal) - at; }))
                          .shapes[0]
                          ->area());
    };
    EXPECT_NEAR(area({0, 0, 1}, 0.4f), 1, 1e-5);
    EXPECT_NEAR(area({1, 1, 0}, 1), std::sqrt(2.0), 1e-5);
    EXPECT_NEAR(area({1, 1, 1}, 1.5f), 0.75 * std::sqrt(3.0), 1e-5);  // a regular hexagon
}

TEST(DistanceField, OfASphereHasItsAreaAndItsNormals) {
    // Trilinear interpolation of a sphere's distances is too large by the square of the cells' size.
    double missing[2];
    for (const int n : {9, 33}) {
        const SceneParts parts = loadDistances(sphereFile(n, 0.3f));
        missing[n == 33] = 2 * kTau * 0.09 - double(parts.shapes[0]->area());
        const TriangleMesh& mesh = meshOf(parts);
        for (size_t i = 0; i < mesh.positions.size(); ++i)
            EXPECT_GT(dot(mesh.normals.at(i), normalize(mesh.positions[i] - Vec3f(0.5f))),
                      n == 9 ? 0.98f : 0.995f);
    }
    EXPECT_NEAR(missing[1], 0, 0.005);
    EXPECT_NEAR(missing[0] / missing[1], 16, 2);
    EXPECT_TRUE(meshOf(loadDistances(sphereFile(9, 0.3f), R"(<string name="normals" value="analytic"/>)"))
                    .normals.empty());
    EXPECT_NEAR(
        loadDistances(sphereFile(33, 0.3f), R"(<transform name="to_world"><scale value="2"/></transform>)")
            .shapes[0]
            ->area(),
        2 * kTau * 0.36, 0.02);
}

TEST(DistanceField, IsClosedAndLooksOutward) {
    const SceneParts parts = loadDistances(sphereFile(33, 0.3f));
    const TriangleMesh& mesh = meshOf(parts);
    std::map<std::pair<uint32_t, uint32_t>, int> edges;
    double volume = 0;
    for (size_t i = 0; i < mesh.indices.size(); i += 3) {
        const uint32_t* t = &mesh.indices[i];
        for (int k = 0; k < 3; ++k) ++edges[{t[k], t[(k + 1) % 3]}];
        volume += double(dot(mesh.positions[t[0]] - Vec3f(0.5f),
                             cross(mesh.positions[t[1]] - Vec3f(0.5f), mesh.positions[t[2]] - Vec3f(0.5f)))) /
                  6;
    }
    for (const auto& [edge, count] : edges) {
        EXPECT_EQ(count, 1);
        EXPECT_EQ(edges.count({edge.second, edge.first}), 1u);
    }
    EXPECT_NEAR(volume, 2.0 / 3 * kTau * 0.027, 0.001);
}

TEST(DistanceField, RefusesWhatIsNone) {
    EXPECT_THAT(errorOf([] { loadDistances(sphereFile(5, -1)); }), HasSubstr("there is no surface"));
    EXPECT_THAT(errorOf([] { loadDistances(sphereFile(5, 0.3f, 3)); }), HasSubstr("found 3 channels"));
    EXPECT_THAT(errorOf([] { loadDistances(sphereFile(1, 0.3f)); }), HasSubstr("expected 2 at least"));
    EXPECT_THAT(errorOf([] { loadDistances(sphereFile(5, 0.3f).substr(0, 100)); }), HasSubstr("truncated"));
    EXPECT_THAT(errorOf([] { loadDistances(sphereFile(5, std::numeric_limits<float>::quiet_NaN())); }),
                HasSubstr("finite"));
    EXPECT_THAT(
        errorOf([] { loadDistances(sphereFile(5, 0.3f), R"(<string name="normals" value="rough"/>)"); }),
        HasSubstr("smooth, analytic"));
    LoadOptions little;
    little.memoryBytes = 100'000;
    const TemporaryFolder folder;
    folder.write("data.vol", sphereFile(9, 0.3f));
    const auto file = folder.write(
        "scene.xml", underSky(R"(<shape type="sdfgrid"><string name="filename" value="data.vol"/></shape>)"));
    EXPECT_THAT(errorOf([&] { loadScene(file, little); }), HasSubstr("memory"));
}

SceneParts loadHair(const std::string& file, const std::string& more = "") {
    const TemporaryFolder folder;
    folder.write("data.hair", file);
    return loadScene(folder.write("scene.xml", underSky(R"(<shape type="hair"><string name="filename"
value="data.hair"/>)" + more + "</shape>",
                                                        "0.6.0")),
                     {});
}

std::string binaryHair(std::initializer_list<float> values, uint32_t count) {
    std::string data = "BINARY_HAIR";
    append(data, count);
    for (const float value : values) append(data, value);
    return data;
}

TEST(Hair, HasTheAreaOfItsCylinders) {
    const std::string text = "0 0 0\n0 0 1\n0 0 3\n\n5 0 0\n5 2 0\n";
    EXPECT_NEAR(loadHair(text).shapes[0]->area(), kTau * 0.025 * 5, 1e-4);
    EXPECT_NEAR(loadHair(text, R"(<float name="radius" value="0.1"/>)").shapes[0]->area(), kTau * 0.1 * 5,
                1e-3);
    const SceneParts thinned =
        loadHair(text, R"(<float name="reduction" value="0.5"/><float name="angleThreshold"
value="1"/>)");
    EXPECT_THAT(thinned.warnings, ElementsAre(HasSubstr("reduction")));
    // In the binary form an infinite number stands before the first point of the next hair.
    const float next = std::numeric_limits<float>::infinity();
    EXPECT_NEAR(loadHair(binaryHair({0, 0, 0, 0, 0, 3, next, 5, 0, 0, 5, 2, 0}, 4)).shapes[0]->area(),
                kTau * 0.025 * 5, 1e-4);
}

TEST(Hair, RefusesDamagedFiles) {
    EXPECT_THAT(errorOf([] { loadHair("0 0 0\n0 0 1 1\n"); }), HasSubstr("data.hair:2"));
    EXPECT_THAT(errorOf([] { loadHair("0 0 0\n\n1 1 1\n"); }), HasSubstr("no hair of two points"));
    EXPECT_THAT(errorOf([] { loadHair(""); }), HasSubstr("no hair of two points"));
    EXPECT_THAT(errorOf([] { loadHair("BINARY_HAIR"); }), HasSubstr("ends after"));
    EXPECT_THAT(errorOf([] { loadHair(binaryHair({0, 0, 0}, 2)); }), HasSubstr("declares 2 points"));
    const float next = std::numeric_limits<float>::infinity();
    EXPECT_THAT(errorOf([&] { loadHair(binaryHair({0, 0, 0, next, 0, 0}, 2)); }), HasSubstr("ends after"));
    EXPECT_THAT(errorOf([&] { loadHair(binaryHair({0, next, 0, 1, 1, 1}, 2)); }), HasSubstr("not finite"));
    EXPECT_THAT(errorOf([] { loadHair("0 0 0\n0 0 1\n", R"(<float name="radius" value="0"/>)"); }),
                HasSubstr("positive"));
}

}  // namespace
}  // namespace metrolux::core::test
