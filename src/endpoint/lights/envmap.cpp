#include "base/distribution.h"
#include "base/parallel.h"
#include "endpoint/lights.h"
#include "endpoint/lights/infinite.h"

namespace metrolux::core {

namespace {

/// Coarse maps get a finer table, so that the table follows sin(theta) and the interpolation.
constexpr int kMinTableRows = 64;

/// The table holds the mean of luminance * sin(theta) over cells that subdivide the cells of bilinear
/// interpolation. A density per solid angle is the table's density per uv area over 2 pi^2 sin(theta).
/// Everything that reports the density of a direction computes it from the direction, by pdf().
class EnvironmentMap final : public InfiniteLight {
  public:
    explicit EnvironmentMap(EnvironmentMapParameters p)
        : toWorld_(p.toWorld), toLocal_(p.toWorld.inverse()), width_(p.width), height_(p.height) {
        if (width_ < 1 || height_ < 2 || p.pixels.size() != size_t(width_) * height_)
            throw Error("environment map: an image of at least 1 x 2 pixels is needed, found {} x {}", width_,
                        height_);
        if (!(p.scale >= 0) || !std::isfinite(p.scale))
            throw Error("environment map: scale {} must be finite and not negative", p.scale);
        for (Rgb& pixel : p.pixels) {
            requireEmission(pixel, "environment map");
            pixel *= p.scale;
        }
        pixels_ = std::move(p.pixels);
        makeTable();
    }

    LightPtr copy() const override { return std::make_shared<EnvironmentMap>(*this); }
    float power() const override { return meanLuminance_ * (4 * kPi) * diskArea(); }
    bool isDelta() const override { return false; }
    bool isEnvironment() const override { return true; }

    Rgb environmentRadiance(const Vec3f& w) const override { return lookup(toGrid(toLocal(w))); }

    EndpointDensities environmentDensities(const Vec3f&, const Vec3f& w) const override {
        const float density = pdf(w);
        return {density, diskPdf(), density, 1};
    }

    std::optional<EndpointRay> sampleRay(const Vec2f& uPosition, const Vec2f& uDirection) const override {
        EndpointRay ray;
        const Vec3f w = sampleDirection(uDirection);
        ray.pdfDirection = pdf(w);
        const Rgb radiance = environmentRadiance(w);
        if (!usable(ray.pdfDirection) || isBlack(radiance)) return std::nullopt;
        ray.direction = -w;
        ray.origin = diskPoint(ray.direction, uPosition);
        ray.pdfPosition = diskPdf();
        ray.weight = radiance * (diskArea() / ray.pdfDirection);
        return ray;
    }

    std::optional<EndpointConnection> connect(const Vec3f& x, const Vec2f& u) const override {
        const Vec3f w = sampleDirection(u);
        EndpointConnection c = connectionAlong(x, w);
        c.pdf = c.pdfDirection = pdf(w);
        const Rgb radiance = environmentRadiance(w);
        if (!usable(c.pdf) || isBlack(radiance)) return std::nullopt;
        c.value = radiance * (1.0f / c.pdf);
        return c;
    }

  protected:
    void scaleEmission(float factor) override {
        for (Rgb& pixel : pixels_) pixel *= factor;
        makeTable();
    }

  private:
    static bool usable(float pdf) { return pdf > 0 && std::isfinite(pdf); }
    Vec3f toLocal(const Vec3f& w) const { return normalize(toLocal_.vector(w)); }

    /// Unit-square coordinates of a local direction in which texel (i, j) lies at (i / width, j / (height -
    /// 1)).
    Vec2f toGrid(const Vec3f& d) const {
        const float phi = std::atan2(d.x, -d.z);
        const float theta = std::atan2(sinTheta(d), d.y);
        float s = phi * (0.5f * kInvPi) - 0.5f / static_cast<float>(width_);
        s -= std::floor(s);
        return {std::min(s, kOneMinusEpsilon), std::clamp(theta * kInvPi, 0.0f, kOneMinusEpsilon)};
    }
    static float sinTheta(const Vec3f& d) { return std::sqrt(d.x * d.x + d.z * d.z); }

    Rgb lookup(const Vec2f& grid) const {
        const float fx = grid.x * static_cast<float>(width_), fy = grid.y * static_cast<float>(height_ - 1);
        const int x = std::min(static_cast<int>(fx), width_ - 1),
                  y = std::min(static_cast<int>(fy), height_ - 2);
        const int x1 = x + 1 == width_ ? 0 : x + 1;
        const float tx = fx - static_cast<float>(x), ty = fy - static_cast<float>(y);
        const Rgb* row = &pixels_[size_t(y) * width_];
        return lerp(ty, lerp(tx, row[x], row[x1]), lerp(tx, row[width_ + x], row[width_ + x1]));
    }

    void makeTable() {
        const int divide = std::max(1, (kMinTableRows + height_ - 2) / (height_ - 1));
        const int rows = (height_ - 1) * divide, columns = width_ * divide;
        std::vector<float> table(size_t(rows) * columns);
        parallelFor(size_t(rows), [&](size_t row) {
            // The mean of sin over the row's interval, and the bilinear function's mean: its value at the
            // center.
            const double theta0 = std::numbers::pi * double(row) / rows,
                         theta1 = std::numbers::pi * double(row + 1) / rows;
            const float meanSin =
                static_cast<float>((std::cos(theta0) - std::cos(theta1)) / (theta1 - theta0));
            for (int x = 0; x < columns; ++x) {
                const Vec2f center((static_cast<float>(x) + 0.5f) / static_cast<float>(columns),
                                   (static_cast<float>(row) + 0.5f) / static_cast<float>(rows));
                table[row * columns + x] = luminance(lookup(center)) * meanSin;
            }
        });
        table_ = Distribution2D(table, columns, rows);
        meanLuminance_ = static_cast<float>(table_.total()) * (0.5f * kPi);  // the mean of sin(theta) is 2/pi
    }

    Vec3f sampleDirection(const Vec2f& u) const {
        float pdf = 0;
        const Vec2f grid = table_.sample(u, pdf);
        const float phi = 2 * kPi * (grid.x + 0.5f / static_cast<float>(width_)), theta = kPi * grid.y;
        const float sine = std::sin(theta);
        const Vec3f local(std::sin(phi) * sine, std::cos(theta), -std::cos(phi) * sine);
        return normalize(toWorld_.vector(local));
    }

    float pdf(const Vec3f& w) const {
        if (table_.empty()) return 0;
        const Vec3f d = toLocal(w);
        return table_.pdf(toGrid(d)) / (2 * kPi * kPi * std::max(sinTheta(d), 1e-7f));
    }

    Transform toWorld_, toLocal_;
    int width_, height_;
    std::vector<Rgb> pixels_;
    Distribution2D table_;
    float meanLuminance_ = 0;
};

}  // namespace

LightPtr makeEnvironmentMap(EnvironmentMapParameters parameters) {
    return std::make_shared<EnvironmentMap>(std::move(parameters));
}

}  // namespace metrolux::core
