#include "base/parallel.h"
#include "endpoint/lights.h"
#include "endpoint/lights/hosek_sky.h"
#include "endpoint/lights/infinite.h"

namespace metrolux::core {

namespace {

// The sky's table: 0.35 degrees between rows, the finest that the band above the horizon asks for.
constexpr int kColumns = 512, kRows = 513;

/// The sky as an environment map whose +y is `up` and whose -z is the sun's azimuth. Rows beyond the horizon
/// but the first are black; SunSky cuts that one off at the horizon itself.
LightPtr makeSkyMap(const SunSkyParameters& p, const Vec3f& up, const Vec3f& towardSun, float sunTheta) {
    const HosekSky sky(p.turbidity, p.albedo, 0.5f * kPi - sunTheta);
    const Vec3f z = -towardSun, x = cross(up, z);
    EnvironmentMapParameters map;
    map.toWorld =
        Transform::fromRows({{x.x, up.x, z.x, 0}, {x.y, up.y, z.y, 0}, {x.z, up.z, z.z, 0}, {0, 0, 0, 1}});
    map.width = kColumns;
    map.height = kRows;
    map.scale = p.skyScale;
    map.pixels.assign(size_t(kColumns) * kRows, Rgb(0.0f));
    const double pi = std::numbers::pi;
    const int last = std::min(kRows - 1, static_cast<int>(std::ceil(0.5 * p.stretch * (kRows - 1) - 1e-4)));
    parallelFor(size_t(last) + 1, [&](size_t row) {
        const double theta = std::min(pi * double(row) / (kRows - 1) / p.stretch, pi / 2);
        for (int column = 0; column < kColumns; ++column) {
            const double phi = 2 * pi * (column + 0.5) / kColumns;
            const double cosGamma = std::cos(theta) * std::cos(double(sunTheta)) +
                                    std::sin(theta) * std::sin(double(sunTheta)) * std::cos(phi);
            map.pixels[row * kColumns + static_cast<size_t>(column)] =
                sky.radiance(std::cos(theta), std::acos(std::clamp(cosGamma, -1.0, 1.0)));
        }
    });
    return makeEnvironmentMap(std::move(map));
}

/// A sky and the disc of a sun before it. Directions are drawn from the mixture of both densities; everything
/// that reports the density of a direction computes it from the direction, by pdf().
class SunSky final : public InfiniteLight {
  public:
    explicit SunSky(const SunSkyParameters& p)
        : up_(normalize(p.up)), profile_(p.sunProfile), cosHorizon_(p.stretch == 1 ? 0.0f : horizon(p)) {
        check(p);
        const float cosTheta = std::clamp(dot(up_, normalize(p.sunDirection)), -1.0f, 1.0f);
        const Vec3f across = normalize(p.sunDirection) - up_ * cosTheta;
        const float theta = std::atan2(across.length(), cosTheta);
        if (theta > 0.5f * kPi + 1e-5f)
            throw Error("the sun is {:.2f} degrees below the horizon, expected it above",
                        (theta - 0.5f * kPi) * 180 / kPi);
        const Vec3f towardSun = across.length() > 1e-6f ? normalize(across) : Frame::fromNormal(up_).s;
        sun_ = Frame::fromNormal(
            normalize(up_ * std::cos(theta * p.stretch) + towardSun * std::sin(theta * p.stretch)));

        const float half = radians(p.sunAperture) / 2;
        sine2_ = sqr(std::sin(half));
        gap_ = 2 * sqr(std::sin(half / 2));
        for (Rgb& c : profile_) requireEmission(c, "sun");
        if (p.skyScale > 0) sky_ = makeSkyMap(p, up_, towardSun, std::min(theta, 0.5f * kPi));
        measure();
    }

    float power() const override { return fluence_ * diskArea(); }
    bool isDelta() const override { return false; }
    bool isEnvironment() const override { return true; }
    void setSceneBounds(const SceneBounds& bounds) override {
        InfiniteLight::setSceneBounds(bounds);
        if (sky_) sky_->setSceneBounds(bounds);
    }
    LightPtr copy() const override {
        auto result = std::make_shared<SunSky>(*this);
        if (sky_) result->sky_ = sky_->copy();
        return result;
    }

    Rgb environmentRadiance(const Vec3f& w) const override {
        if (dot(w, up_) < cosHorizon_) return Rgb(0.0f);
        const Rgb disc = discRadiance(w);
        return sky_ ? sky_->environmentRadiance(w) + disc : disc;
    }

    EndpointDensities environmentDensities(const Vec3f&, const Vec3f& w) const override {
        const float density = pdf(w);
        return {density, diskPdf(), density, 1};
    }

    std::optional<EndpointRay> sampleRay(const Vec2f& uPosition, const Vec2f& uDirection) const override {
        const std::optional<Sample> s = sampleDirection(uDirection);
        if (!s) return std::nullopt;
        EndpointRay ray;
        ray.direction = -s->w;
        ray.origin = diskPoint(ray.direction, uPosition);
        ray.pdfDirection = s->pdf;
        ray.pdfPosition = diskPdf();
        ray.weight = s->radiance * (diskArea() / s->pdf);
        return ray;
    }

    std::optional<EndpointConnection> connect(const Vec3f& x, const Vec2f& u) const override {
        const std::optional<Sample> s = sampleDirection(u);
        if (!s) return std::nullopt;
        EndpointConnection c = connectionAlong(x, s->w);
        c.pdf = c.pdfDirection = s->pdf;
        c.value = s->radiance * (1.0f / s->pdf);
        return c;
    }

  protected:
    void scaleEmission(float factor) override {
        for (Rgb& c : profile_) c *= factor;
        if (sky_) sky_->setEmissionExponent(sky_->emissionExponent() - std::ilogb(factor));
        measure();
    }

  private:
    struct Sample {
        Vec3f w;
        float pdf;
        Rgb radiance;
    };

    static void check(const SunSkyParameters& p) {
        const auto scale = [](float value, const char* name) {
            if (!(value >= 0) || !std::isfinite(value))
                throw Error("the scale {} of the {} must be finite and not negative", value, name);
        };
        scale(p.skyScale, "sky");
        if (!(p.stretch >= 1 && p.stretch <= 2))
            throw Error("the stretch {} is out of range, expected 1 to 2", p.stretch);
        if (!(p.sunAperture > 0 && p.sunAperture < 90))
            throw Error(
                "the sun's aperture of {} degrees is out of range, expected more than 0 and less than 90",
                p.sunAperture);
        if (!isFinite(p.up) || !(p.up.length() > 0)) throw Error("the up direction has no length");
        if (!isFinite(p.sunDirection) || !(p.sunDirection.length() > 0))
            throw Error("the sun's direction has no length");
        HosekSky(p.turbidity, p.albedo, 0.5f);  // its ranges, also when the sky is off
    }
    static float horizon(const SunSkyParameters& p) { return std::cos(0.5f * kPi * p.stretch); }

    /// Where w lies on the disc: the share of the disc's solid angle that is nearer to its center, or more
    /// than 1. From the sine, which keeps its precision in so narrow a cone.
    float discShare(const Vec3f& w) const {
        const Vec3f d = sun_.toLocal(w);
        const float sine2 = d.x * d.x + d.y * d.y;
        if (d.z <= 0 || sine2 > sine2_) return 2;
        return std::min(sine2 / ((1 + d.z) * gap_), 1.0f);
    }

    Rgb discRadiance(const Vec3f& w) const {
        if (profile_.empty()) return Rgb(0.0f);
        const float share = discShare(w);
        if (share > 1) return Rgb(0.0f);
        const float position = share * static_cast<float>(profile_.size() - 1);
        const size_t i = std::min(static_cast<size_t>(position), profile_.size() - 1);
        const size_t j = std::min(i + 1, profile_.size() - 1);
        return lerp(position - static_cast<float>(i), profile_[i], profile_[j]);
    }

    std::optional<Sample> sampleDirection(Vec2f u) const {
        Sample s;
        if (u.x < sunProbability_) {
            u.x = std::min(u.x / sunProbability_, kOneMinusEpsilon);
            s.w = normalize(sun_.toWorld(warp::squareToCone(u, gap_)));
        } else {
            if (!sky_) return std::nullopt;
            u.x = std::min((u.x - sunProbability_) / (1 - sunProbability_), kOneMinusEpsilon);
            const std::optional<EndpointConnection> c = sky_->connect(Vec3f(0.0f), u);
            if (!c) return std::nullopt;
            s.w = c->wi;
        }
        s.radiance = environmentRadiance(s.w);
        s.pdf = pdf(s.w);
        if (!(s.pdf > 0) || !std::isfinite(s.pdf) || isBlack(s.radiance)) return std::nullopt;
        return s;
    }

    float pdf(const Vec3f& w) const {
        float sum = 0;
        if (sunProbability_ > 0 && discShare(w) <= 1) sum += sunProbability_ * warp::uniformConePdf(gap_);
        if (sky_) sum += (1 - sunProbability_) * sky_->environmentDensities(Vec3f(0.0f), w).connect;
        return sum;
    }

    /// What sun and sky send, luminance integrated over the sphere; and how often the sun is drawn: half by
    /// that, half evenly, because the sun's share says nothing about points in the shade.
    void measure() {
        constexpr int kSteps = 32;
        double sun = 0;
        for (int i = 0; i < kSteps && !profile_.empty(); ++i)
            for (int j = 0; j < kSteps; ++j) {
                const Vec2f u((static_cast<float>(i) + 0.5f) / kSteps,
                              (static_cast<float>(j) + 0.5f) / kSteps);
                const Vec3f w = normalize(sun_.toWorld(warp::squareToCone(u, gap_)));
                if (dot(w, up_) >= cosHorizon_) sun += luminance(discRadiance(w));
            }
        sun *= double(2 * kPi * gap_) / (kSteps * kSteps);
        double sky = 0;
        if (sky_) {
            constexpr int kRings = 1024, kTurns = 256;
            for (int i = 0; i < kRings; ++i) {
                const float z = 1 - (1 - cosHorizon_) * (static_cast<float>(i) + 0.5f) / kRings;
                const float r = safeSqrt(1 - z * z);
                const Frame frame = Frame::fromNormal(up_);
                for (int j = 0; j < kTurns; ++j) {
                    const float phi = 2 * kPi * (static_cast<float>(j) + 0.5f) / kTurns;
                    sky += luminance(
                        sky_->environmentRadiance(frame.toWorld({r * std::cos(phi), r * std::sin(phi), z})));
                }
            }
            sky *= 2 * std::numbers::pi * double(1 - cosHorizon_) / (kRings * kTurns);
        }
        fluence_ = static_cast<float>(sun + sky);
        if (sun > 0) sunProbability_ = sky > 0 ? static_cast<float>(0.25 + 0.5 * sun / (sun + sky)) : 1.0f;
    }

    Vec3f up_;
    Frame sun_;
    std::vector<Rgb> profile_;
    LightPtr sky_;
    float cosHorizon_;
    float sine2_ = 0, gap_ = 0;  ///< of the disc's angular radius: sin^2 and 1 - cos
    float sunProbability_ = 0;
    float fluence_ = 0;
};

}  // namespace

LightPtr makeSunSky(const SunSkyParameters& parameters) { return std::make_shared<SunSky>(parameters); }

}  // namespace metrolux::core
