/// Media whose radiance is known in closed form, rendered by every integrator. Error rates: rendering.h.

#include "rendering.h"
#include "scattering/null_bsdf.h"

namespace metrolux::core {
namespace {

using namespace test;

std::vector<std::string> integratorNames() {
    std::vector<std::string> names;
    for (const IntegratorDescription& integrator : integratorList()) names.push_back(integrator.name);
    return names;
}

class Media : public ::testing::TestWithParam<std::string> {
  protected:
    bool is(const char* name) const { return GetParam() == name; }
    void expect(SceneBuilder& b, double radiance, double detectable, const std::string& what, int passes) {
        // Near the boundary of the ball, which is taken for a plane, this loses 1e-3.
        constexpr double kRadius = 0.02, kMediumRadius = 0.05;
        RenderSetup s;
        s.integrator = GetParam();
        s.passes = passes;
        s.radius = kRadius;
        if (ParameterSet(findIntegrator(s.integrator).parameters).find("medium_radius"))
            s.parameters["medium_radius"] = kMediumRadius;
        s.columns = s.rows = 1;
        expectRadiance(renderSeeds(*b.build(), s), radiance, detectable,
                       fmt::format("{} {}", GetParam(), what));
    }
};

/// A ball of `medium` whose boundary changes nothing.
ShapePtr addBall(SceneBuilder& b, float radius, MediumPtr medium, BsdfPtr boundary = makeNullBsdf()) {
    b.media().push_back(std::move(medium));
    ShapePtr ball = b.add(makeSphere(Transform(), {0, 0, 0}, radius, false), std::move(boundary));
    ball->media = MediumSides{static_cast<MediumIndex>(b.media().size()), 0};
    return ball;
}

TEST_P(Media, ABallThatOnlyScattersVanishes) {
    for (const float density : {0.5f, 4.0f}) {
        SceneBuilder b;
        addBall(b, 1, makeHomogeneousMedium(Rgb(density), Rgb(1.0f), makeHenyeyGreensteinPhase(0.3f)));
        b.light(makeConstantLight({}));
        b.camera({0.2f, 0.3f, 2.5f}, {0, 0, 0}, 35, 24, 24);
        expect(b, 1, 0.3, fmt::format("density {}", density),
               is("light")               ? 32
               : is("sppm") || is("vpt") ? 96
                                         : 16);
    }
}

TEST_P(Media, ABallThatOnlyScattersVanishesBehindGlass) {
    if (is("light")) GTEST_SKIP() << "light tracing does not see through what is specular";
    if (is("mmlt")) GTEST_SKIP() << "mmlt's chains of each path length scatter too much to decide";
    SceneBuilder b;
    addBall(b, 1, makeHomogeneousMedium(Rgb(1.0f), Rgb(1.0f), makeRayleighPhase()), makeDielectric({}));
    b.light(makeConstantLight({}));
    b.camera({0.2f, 0.3f, 2.5f}, {0, 0, 0}, 35, 24, 24);
    expect(b, 1, 0.4, "", is("mmlt") ? 48 : 24);
}

TEST_P(Media, ASlabAbsorbsByBeersLaw) {
    // Through 2 units of the cube, from an environment of radiance 1.
    constexpr float kSigma = 0.7f;
    SceneBuilder b;
    b.media() = {makeHomogeneousMedium(Rgb(kSigma), Rgb(0.0f), makeIsotropicPhase())};
    b.add(makeCube(Transform(), false), makeNullBsdf())->media = MediumSides{1, 0};
    b.light(makeConstantLight({}));
    OrthographicParameters p;
    p.toWorld = Transform::lookAt({0, 0, 4}, {0, 0, 0}, {0, 1, 0}) * Transform::scale({0.9f, 0.9f, 1});
    FilmWindow window;
    window.fullWidth = window.width = window.fullHeight = window.height = 12;
    b.camera(makeOrthographicCamera(p, window));
    expect(b, std::exp(-2 * double(kSigma)), 1e-3, "", 2);
}

/// Radiance of single scattering that a ray gathers, in infinite fog with a point light at distance `across`
/// from the ray, level with the point at `along`: trapezoids fine enough for 1e-6. The fog begins where the
/// ray does, at the near plane.
double singleScattering(double sigmaT, double sigmaS, double intensity, double along, double across,
                        double near) {
    constexpr int kSteps = 400'000;
    const double end = 40 / sigmaT;
    double sum = 0;
    for (int i = 0; i <= kSteps; ++i) {
        const double t = end * i / kSteps, d2 = sqr(across) + sqr(near + t - along), d = std::sqrt(d2);
        const double value = std::exp(-sigmaT * (t + d)) / d2;
        sum += i == 0 || i == kSteps ? 0.5 * value : value;
    }
    return sum * end / kSteps * sigmaS * intensity / (4 * std::numbers::pi);
}

TEST_P(Media, APointLightInEndlessFogScattersOnce) {
    if (is("sppm") || is("vpt") || is("light"))
        GTEST_SKIP() << "next to no light subpath comes near so narrow a view";
    constexpr float kSigma = 0.5f, kAlbedo = 0.8f, kIntensity = 10;
    SceneBuilder b;
    b.media() = {makeHomogeneousMedium(Rgb(kSigma), Rgb(kAlbedo), makeIsotropicPhase())};
    PointLightParameters p;
    p.position = {2, 0, 3};
    p.intensity = Rgb(kIntensity);
    b.light(makePointLight(p));
    // One narrow pixel after the other: all rays run nearly along the axis.
    b.camera({0, 0, 0}, {0, 0, 1}, 0.5f, 8, 8);
    // Something to bound the scene, which nothing sees.
    b.add(rectangle({0, -8, 0}, {0, -1, 0}, 0.1f, 0.1f), diffuse(0));
    b.limits().maxDepth = 2;
    b.cameraInMedium(1);
    expect(b, singleScattering(kSigma, kSigma * kAlbedo, kIntensity, 3, 2, 0.01), 0.3, "",
           is("path") || is("bdpt") || is("vcm") ? 64 : 256);
}

INSTANTIATE_TEST_SUITE_P(All, Media, ::testing::ValuesIn(integratorNames()),
                         [](const auto& i) { return i.param; });

}  // namespace
}  // namespace metrolux::core
