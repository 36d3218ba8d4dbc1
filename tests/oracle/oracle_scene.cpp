#include "oracle/oracle_scene.h"

#include "base/warp.h"
#include "endpoint/goniometric_light.h"
#include "endpoint/wide_cameras.h"
#include "scattering/blend.h"
#include "scattering/coating.h"
#include "scattering/conductor.h"
#include "scattering/diffuse_transmitter.h"
#include "scattering/mask.h"
#include "scattering/mixture.h"
#include "scattering/null_bsdf.h"
#include "scattering/plastic.h"
#include "scattering/rough_diffuse.h"
#include "scattering/textures/bitmap_texture.h"
#include "support/small_scenes.h"

#include <array>

namespace metrolux::core::test {

namespace {

BsdfPtr glass() {
    DielectricParameters p;
    p.eta = kGlassEta;
    return makeDielectric(p);
}

RelativeIndex dispersiveIndex() {
    const double a = 1.2, square = sqr(1e-3 * double(kGlassWavelength));
    return {Dispersion::cauchy(std::array{a, (double(kGlassEta) - a) * square}), 1};
}

BsdfPtr roughMetal() {
    RoughConductorParameters p;
    p.alphaU = p.alphaV = constant(Rgb(0.5f));
    return makeRoughConductor(p);
}

BsdfPtr plastic() {
    PlasticParameters p;
    p.eta = kGlassEta;
    p.diffuseReflectance = constant(Rgb(0.6f));
    return makePlastic(p);
}

BsdfPtr blend(float weight, BsdfPtr first, BsdfPtr second) {
    return makeBlend({constant(Rgb(weight)), std::move(first), std::move(second)});
}

BsdfPtr roughDiffuse() {
    RoughDiffuseParameters p;
    p.reflectance = constant(Rgb(0.6f));
    p.alpha = constant(Rgb(0.4f));
    return makeRoughDiffuse(p);
}

/// Smooth without facets: a delta lobe above the base.
BsdfPtr coated(BsdfPtr base, std::optional<MicrofacetDistribution> facets) {
    CoatingParameters p;
    p.eta = 1.8f;
    p.thickness = 0.3f;
    p.sigmaA = constant(Rgb(0.4f));
    p.base = std::move(base);
    p.facets = facets;
    return makeCoating(p);
}

/// A rectangle whose shading normal leans toward `lean` by a quarter of a right angle or so.
ShapePtr leaning(const Vec3f& center, const Vec3f& normal, float a, float b, const Vec3f& lean) {
    const Frame f = Frame::fromNormal(normalize(normal));
    auto mesh = std::make_shared<TriangleMesh>();
    for (const auto& [u, v] : {std::pair(-1, -1), {1, -1}, {1, 1}, {-1, 1}}) {
        mesh->positions.push_back(center + f.s * (a * static_cast<float>(u)) +
                                  f.t * (b * static_cast<float>(v)));
        mesh->normals.push_back(normalize(f.n + lean * 0.35f));
    }
    mesh->indices = {0, 1, 2, 0, 2, 3};
    mesh->finalize();
    return mesh;
}

/// 4 x 3 texels of different brightness, none of them black.
TexturePtr picture() {
    BitmapTextureParameters p;
    p.width = 4;
    p.height = 3;
    p.channels = 1;
    p.pixels = std::make_shared<const std::vector<float>>(
        std::vector<float>{0.2f, 0.9f, 0.4f, 0.6f, 1.0f, 0.3f, 0.7f, 0.5f, 0.8f, 0.1f, 0.6f, 0.4f});
    p.filter = BitmapTextureParameters::Filter::Nearest;
    return makeBitmapTexture(p);
}

BsdfPtr veil() {
    MaskParameters p;
    p.opacity = constant(Rgb(OracleMedia::kVeilOpacity));
    p.nested = diffuse(0.8f);
    return makeMask(p);
}

struct Palette {
    BsdfPtr floor = diffuse(0.7f), wall = roughMetal(), ball = glass(), smallBall = diffuse(0.5f);
    BsdfPtr water = glass();
    BsdfPtr screen;  ///< upright in the room; none without
};

// Of Materials::Media. The fog ends far outside of the camera and the lamps, so that light of the sky gets
// in.
struct Ball {
    Vec3f center;
    float radius;
};
const Ball kFogBall{{0, 1, 0}, 7}, kDenseBall{{1.6f, 1.1f, 1.4f}, 0.65f}, kGlassBall{{0.3f, 1.2f, 0}, 0.6f};
const Rgb kFog(0.15f, 0.3f, 0.1f), kDense(1.2f, 0.7f, 0.9f);
const Vec3f kVeilCenter{-1.5f, 1.5f, 1.8f};
constexpr float kVeilX = 0.8f, kVeilY = 1.2f;  // half its width and height

/// Fills what is there with media, in the order fog, dense, absorbing.
void fill(SceneBuilder& b) {
    b.media() = {makeHomogeneousMedium(kFog, Rgb(0.8f, 0.6f, 0.9f), makeHenyeyGreensteinPhase(0.4f)),
                 makeHomogeneousMedium(kDense, Rgb(0.9f, 0.5f, 0.7f), makeRayleighPhase()),
                 makeHomogeneousMedium(Rgb(0.5f, 0.2f, 1), Rgb(0.0f), makeIsotropicPhase())};
    const auto boundary = [&](const Ball& ball, MediumSides sides) {
        b.add(makeSphere(Transform(), Vec3d(ball.center), ball.radius, false), makeNullBsdf())->media = sides;
    };
    boundary(kFogBall, {1, 0});
    boundary(kDenseBall, {2, 1});
}

Palette paletteOf(Materials materials, const BsdfPtr& veil) {
    Palette p;
    if (materials == Materials::Mixed) {
        p.floor = plastic();
        p.wall = blend(0.4f, makeConductor({}), blend(0.5f, roughMetal(), diffuse(0.6f)));
        p.ball = blend(0.3f, glass(), diffuse(0.8f));
        p.screen = veil;
    }
    if (materials == Materials::Media) p.screen = veil;
    if (materials == Materials::Dispersive) p.ball = p.water = makeDielectric({dispersiveIndex()});
    if (materials == Materials::Layered) {
        p.floor = coated(diffuse(0.6f), {});
        p.wall = coated(roughMetal(), MicrofacetDistribution(MicrofacetType::Ggx, 0.3f, 0.3f));
        p.ball = makeMixture({{{0.6f, glass()}, {0.15f, diffuse(0.8f)}, {0.2f, roughDiffuse()}}});
        p.smallBall = roughDiffuse();
        p.screen = makeDiffuseTransmitter({constant(Rgb(0.7f))});
    }
    return p;
}

void addSurfaces(SceneBuilder& b, Materials materials, const BsdfPtr& veil) {
    const bool shading = materials == Materials::Shading;
    const Palette palette = paletteOf(materials, veil);
    if (shading)
        b.add(leaning({0, 0, 0}, {0, 1, 0}, 4, 4, {1, 0, 0}), palette.floor);
    else
        b.add(rectangle({0, 0, 0}, {0, 1, 0}, 4, 4), palette.floor);
    b.add(rectangle({0, 2, -3}, {0, 0, 1}, 4, 3), palette.wall);
    const ShapePtr ball =
        b.add(makeSphere(Transform(), Vec3d(kGlassBall.center), kGlassBall.radius, false), palette.ball);
    if (materials == Materials::Media) {
        ball->media = MediumSides{3, 1};
        fill(b);
    }
    // Water above a part of the floor: an odd number of refractions, so that wrong factors do not cancel.
    if (shading)
        b.add(leaning({3, 0.4f, 0}, {0, 1, 0}, 2, 4, {0, 0, 1}), palette.water);
    else
        b.add(rectangle({3, 0.4f, 0}, {0, 1, 0}, 2, 4), palette.water);
    b.add(makeSphere(Transform(), {-1.2f, 0.6f, 0.5f}, 0.5f, false), palette.smallBall);
    if (palette.screen) b.add(rectangle(kVeilCenter, {0, 0, 1}, kVeilX, kVeilY), palette.screen);
}

Transform downward(const Vec3f& from) { return Transform::lookAt(from, {0.3f, 0, 0.3f}, {0, 0, 1}); }

LightPtr pointLight(const Vec3f& position) {
    PointLightParameters p;
    p.position = position;
    return makePointLight(p);
}

void addLight(SceneBuilder& b, Lighting lighting) {
    switch (lighting) {
        case Lighting::Area:
            b.emit(b.add(rectangle({0.5f, 3, 0}, {0, -1, 0}, 0.7f, 0.5f), diffuse(0.3f)), Rgb(5));
            break;
        case Lighting::SphereArea:
            b.emit(b.add(makeSphere(Transform(), {0.5f, 3, 0}, 0.5f, false), diffuse(0.3f)), Rgb(5));
            break;
        case Lighting::TexturedArea: {
            const ShapePtr shape =
                b.add(rectangle({-0.8f, 3, 0.4f}, {0.1f, -1, 0}, 0.6f, 0.4f), diffuse(0.3f));
            b.emit(shape, picture());
            break;
        }
        case Lighting::Point:
            b.light(pointLight({0.5f, 3, 0.2f}));
            break;
        case Lighting::Spot: {
            SpotLightParameters p;
            p.toWorld = downward({1.5f, 3.5f, 1});
            p.intensity = Rgb(8);
            p.cutoffAngle = 50;
            p.beamWidth = 30;
            b.light(makeSpotLight(p));
            break;
        }
        case Lighting::Projector: {
            ProjectorParameters p;
            p.toWorld = downward({-1, 3.2f, 1.5f});
            p.irradiance = picture();
            p.tanHalfFovX = 0.8f;
            p.aspect = 1.4f;
            p.scale = 3;
            b.light(makeProjector(p));
            break;
        }
        case Lighting::Collimated: {
            CollimatedLightParameters p;
            p.toWorld = downward({-0.3f, 3, 1.7f});
            p.power = Rgb(10);
            b.light(makeCollimatedLight(p));
            break;
        }
        case Lighting::Goniometric:
            b.light(makeGoniometricLight(
                {downward({0.4f, 3, 0.3f}),
                 Rgb(3),
                 {{0, 30, 60, 100}, {0, 90, 180}, {1, 2, 1, 0, 2, 3, 0, 0, 1, 1, 1, 2}}}));
            break;
        case Lighting::Directional: {
            DirectionalLightParameters p;
            p.direction = normalize(Vec3f(0.2f, -1, -0.1f));
            b.light(makeDirectionalLight(p));
            break;
        }
        case Lighting::Constant:
            b.light(makeConstantLight({}));
            break;
        case Lighting::EnvironmentMap: {
            EnvironmentMapParameters p;
            p.width = 8;
            p.height = 5;
            for (int i = 0; i < p.width * p.height; ++i)
                p.pixels.push_back(Rgb(0.005f * (0.3f + static_cast<float>(i * 7 % 11))));
            b.light(makeEnvironmentMap(std::move(p)));
            break;
        }
        case Lighting::SunSky: {
            SunSkyParameters p;
            p.up = {0, 1, 0};
            p.sunDirection = normalize(Vec3f(0.4f, 1, 0.5f));
            p.sunAperture = 20;
            p.sunProfile = {Rgb(3), Rgb(1)};
            b.light(makeSunSky(p));
            break;
        }
        case Lighting::Many:
            for (const Lighting one : {Lighting::Area, Lighting::TexturedArea, Lighting::Spot,
                                       Lighting::Projector, Lighting::Collimated})
                addLight(b, one);
            b.light(pointLight({1.2f, 2.5f, 1}));
            b.emit(b.add(makeSphere(Transform(), {-2.5f, 2, -1}, 0.3f, false), diffuse(0.3f)), Rgb(3));
            break;
        case Lighting::ManyAndEnvironment:
            for (const Lighting one : {Lighting::Many, Lighting::Directional, Lighting::EnvironmentMap})
                addLight(b, one);
            break;
    }
}

}  // namespace

Vec3f OracleLens::point(const Vec2f& uLens) const {
    if (!(radius > 0)) return origin;
    const Vec2f onDisk = warp::squareToDisk(uLens) * static_cast<float>(radius);
    return origin + x * onDisk.x + y * onDisk.y;
}

namespace {

/// Length of the segment from a to b that lies in the ball.
double lengthInside(const Ball& ball, const Vec3f& a, const Vec3f& b) {
    using V = Imath::V3d;
    const V d = V(b) - V(a), o = V(a) - V(ball.center);
    const double length = d.length(), projected = o.dot(d) / length;
    const double half = sqr(projected) - o.dot(o) + sqr(double(ball.radius));
    if (half <= 0) return 0;
    const double begin = std::max(-projected - std::sqrt(half), 0.0),
                 end = std::min(-projected + std::sqrt(half), length);
    return std::max(end - begin, 0.0);
}

bool crossesVeil(const Vec3f& a, const Vec3f& b) {
    const float before = a.z - kVeilCenter.z, after = b.z - kVeilCenter.z;
    constexpr float kOnIt = 1e-4f;
    if (std::abs(before) < kOnIt || std::abs(after) < kOnIt || (before < 0) == (after < 0)) return false;
    const Vec3f p = a + (b - a) * (before / (before - after));
    return std::abs(p.x - kVeilCenter.x) < kVeilX && std::abs(p.y - kVeilCenter.y) < kVeilY;
}

}  // namespace

Rgb OracleMedia::survival(const Vec3f& a, const Vec3f& b) const {
    if (!present) return Rgb(1.0f);
    const double dense = lengthInside(kDenseBall, a, b),
                 fog = lengthInside(kFogBall, a, b) - dense - lengthInside(kGlassBall, a, b);
    Rgb result;
    for (int c = 0; c < 3; ++c)
        result[c] = static_cast<float>(std::exp(-(double(kFog[c]) * fog + double(kDense[c]) * dense)));
    return crossesVeil(a, b) ? result * (1 - kVeilOpacity) : result;
}

bool OracleMedia::isGrazing(const Vec3f& a, const Vec3f& b) const {
    if (!present) return false;
    constexpr float kLeastCosine = 0.5f;
    const Vec3f w = normalize(b - a);
    for (const Ball& ball : {kFogBall, kDenseBall, kGlassBall}) {
        const Vec3f o = a - ball.center;
        const float nearest = (o - w * dot(o, w)).length() / ball.radius;
        if (nearest > std::sqrt(1 - kLeastCosine * kLeastCosine) && nearest < 1.05f) return true;
    }
    return false;
}

Rgb OracleMedia::extinction(const Vec3f& p) const {
    return (p - kDenseBall.center).length() < kDenseBall.radius ? kDense : kFog;
}

OracleScene makeOracleScene(Lighting lighting, Lens lens, Materials materials) {
    OracleScene result;
    result.veil = veil();
    SceneBuilder b;
    addSurfaces(b, materials, result.veil);
    addLight(b, lighting);
    result.media.present = materials == Materials::Media;
    const Vec3f origin{0, 1.5f, 5}, target{0, 1, 0};
    FilmWindow window;
    window.fullWidth = window.width = kImageWidth;
    window.fullHeight = window.height = kImageHeight;
    constexpr double kShape = double(kImageHeight) / kImageWidth;
    result.lens.origin = origin;
    result.lens.axis = normalize(target - origin);
    result.lens.x = normalize(cross(Vec3f(0, 1, 0), result.lens.axis));
    result.lens.y = cross(result.lens.axis, result.lens.x);
    result.lens.kind = lens;
    if (lens == Lens::Orthographic) {
        constexpr float kHalfWidth = 2.2f;
        OrthographicParameters p;
        p.toWorld =
            Transform::lookAt(origin, target, {0, 1, 0}) * Transform::scale({kHalfWidth, kHalfWidth, 1});
        b.camera(makeOrthographicCamera(p, window));
        result.lens.imageArea = 4.0 * kHalfWidth * kHalfWidth * kShape;
    } else if (lens == Lens::Panorama) {
        // The part around the middle, in which there is something to see.
        constexpr int kWhole = 5 * kImageWidth;
        const FilmWindow part{
            kWhole,      kWhole / 2,  (kWhole - kImageWidth) / 2, (kWhole / 2 - kImageHeight) / 2,
            kImageWidth, kImageHeight};
        b.camera(makePanoramaCamera({Transform::lookAt(origin, target, {0, 1, 0})}, part));
        result.lens.imageArea = 2 * sqr(std::numbers::pi) * part.pixelCount() / (kWhole * kWhole / 2);
    } else if (lens == Lens::Fisheye) {
        constexpr float kAperture = 80;
        b.camera(makeFisheyeCamera({Transform::lookAt(origin, target, {0, 1, 0})}, kAperture, window));
        const double height = double(kAperture) * std::numbers::pi / 180;
        result.lens.imageArea = height * height / kShape;
    } else {
        constexpr float kFov = 50;
        PerspectiveParameters p;
        p.toWorld = Transform::lookAt(origin, target, {0, 1, 0});
        p.fov = kFov;
        if (lens == Lens::Thin) {
            p.apertureRadius = 0.25f;
            p.focusDistance = 4;
            result.lens.radius = double(p.apertureRadius);
        }
        b.camera(makePerspectiveCamera(p, window));
        const double halfWidth = std::tan(0.5 * double(kFov) * std::numbers::pi / 180);
        result.lens.imageArea = 4 * halfWidth * halfWidth * kShape;
    }
    b.limits().maxDepth = 9;
    // Roulette is no part of the densities: scenes with shading normals play it too.
    b.limits().rouletteDepth = materials == Materials::Shading ? 2 : 100;
    result.scene = b.build();
    return result;
}

}  // namespace metrolux::core::test
