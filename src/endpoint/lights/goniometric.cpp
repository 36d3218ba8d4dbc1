#include "base/distribution.h"
#include "base/error.h"
#include "base/warp.h"
#include "endpoint/goniometric_light.h"
#include "endpoint/lights/emission.h"

namespace metrolux::core {

namespace {

/// Where a value lies among ascending ones: between `low` and the next, at the fraction.
struct Place {
    size_t low = 0;
    float fraction = 0;
};
Place placeOf(const std::vector<float>& angles, float angle) {
    const auto above = std::upper_bound(angles.begin(), angles.end(), angle);
    if (above == angles.begin()) return {};
    const size_t low = static_cast<size_t>(above - angles.begin()) - 1;
    if (low + 1 >= angles.size()) return {low, 0};
    return {low, (angle - angles[low]) / (angles[low + 1] - angles[low])};
}

/// Into the range that the web has.
float folded(const std::vector<float>& horizontal, float angle) {
    const float first = horizontal.front(), last = horizontal.back();
    if (last - first >= 270) return angle;
    // A half turn between 90 and 270 degrees is mirrored at the plane of these, others at that of 0 and 180.
    if (first >= 90) return angle < 90 ? 180 - angle : angle > 270 ? 540 - angle : angle;
    const float half = angle > 180 ? 360 - angle : angle;
    return last <= 90 && half > 90 ? 180 - half : half;
}

void requireWeb(const PhotometricWeb& web) {
    const auto ascends = [](const std::vector<float>& angles, float most) {
        if (angles.empty()) return false;
        for (size_t i = 0; i < angles.size(); ++i)
            if (!(angles[i] >= 0 && angles[i] <= most) || (i > 0 && !(angles[i] > angles[i - 1])))
                return false;
        return true;
    };
    if (!ascends(web.vertical, 180) || !ascends(web.horizontal, 360))
        throw Error("goniometric light: the angles must ascend within [0, 180] and [0, 360] degrees");
    if (web.values.size() != web.vertical.size() * web.horizontal.size())
        throw Error("goniometric light: found {} values for {} x {} angles", web.values.size(),
                    web.vertical.size(), web.horizontal.size());
    for (const float value : web.values)
        if (!(value >= 0) || !std::isfinite(value))
            throw Error("goniometric light: found the value {}, expected finite ones that are not negative",
                        value);
}

class GoniometricLight final : public Light {
  public:
    explicit GoniometricLight(GoniometricLightParameters p)
        : position_(p.toWorld.point(Vec3f(0.0f))),
          axes_(localAxes(p.toWorld)),
          scale_(p.scale),
          web_(std::move(p.web)) {
        requireEmission(scale_, "goniometric");
        requireWeb(web_);
        makeTable();
    }

    float power() const override { return luminance(scale_) * meanValue_ * (4 * kPi); }
    std::optional<LightBounds> bounds() const override {
        return LightBounds{position_, position_, {}, 1, luminance(scale_) * meanValue_};
    }
    bool isDelta() const override { return true; }

    std::optional<EndpointRay> sampleRay(const Vec2f&, const Vec2f& uDirection) const override {
        if (table_.empty()) return std::nullopt;
        float pdfUv = 0;
        const Vec2f uv = table_.sample(uDirection, pdfUv);
        const float phi = 2 * kPi * uv.x, theta = kPi * uv.y, sine = std::sin(theta);
        const Vec3f local(std::cos(phi) * sine, std::sin(phi) * sine, std::cos(theta));
        EndpointRay ray;
        ray.origin = position_;
        ray.direction = normalize(axes_.toWorld(local));
        ray.pdfDirection = pdf(ray.direction);
        const Rgb value = intensity(ray.direction);
        if (isBlack(value) || !(ray.pdfDirection > 0)) return std::nullopt;
        ray.weight = value * (1.0f / ray.pdfDirection);
        return ray;
    }

    std::optional<EndpointConnection> connect(const Vec3f& x, const Vec2f&) const override {
        std::optional<EndpointConnection> c = connectionToPoint(position_, x);
        if (!c) return std::nullopt;
        const Rgb value = intensity(-c->wi);
        if (isBlack(value)) return std::nullopt;
        c->value = value * (1.0f / sqr(c->distance));
        c->pdfDirection = pdf(-c->wi);
        return c;
    }

  protected:
    void scaleEmission(float factor) override { scale_ *= factor; }

  private:
    /// Turns around the axis and from it, as fractions of 360 and 180 degrees.
    Vec2f toGrid(const Vec3f& w) const {
        const Vec3f d = axes_.toLocal(w);
        float turn = std::atan2(d.y, d.x) * (0.5f * kInvPi);
        turn -= std::floor(turn);
        const float fall = std::atan2(std::sqrt(d.x * d.x + d.y * d.y), d.z) * kInvPi;
        return {std::min(turn, kOneMinusEpsilon), std::min(fall, kOneMinusEpsilon)};
    }
    float value(const Vec2f& grid) const { return web_.at(180 * grid.y, 360 * grid.x); }
    Rgb intensity(const Vec3f& w) const { return scale_ * value(toGrid(w)); }
    float pdf(const Vec3f& w) const {
        const Vec2f grid = toGrid(w);
        return table_.pdf(grid) / (2 * kPi * kPi * std::max(std::sin(kPi * grid.y), 1e-7f));
    }

    /// A density over cells of a degree or less. A hundredth is uniform: what is narrower than a cell is not
    /// out of reach.
    void makeTable() {
        constexpr int kColumns = 360, kRows = 360;
        std::vector<float> table(size_t(kColumns) * kRows);
        double sum = 0;
        for (int y = 0; y < kRows; ++y) {
            const float sine = std::sin(kPi * (static_cast<float>(y) + 0.5f) / kRows);
            for (int x = 0; x < kColumns; ++x) {
                constexpr int kSub = 4;
                float mean = 0;
                for (int k = 0; k < kSub; ++k)
                    mean += value({(static_cast<float>(x) + 0.5f) / kColumns,
                                   (static_cast<float>(y) + (static_cast<float>(k) + 0.5f) / kSub) / kRows});
                table[size_t(y) * kColumns + size_t(x)] = mean / kSub * sine;
                sum += double(mean / kSub * sine);
            }
        }
        const double mean = sum / (kColumns * kRows);
        meanValue_ = static_cast<float>(mean) * (0.5f * kPi);  // the mean of the sine is 2 / pi
        for (int y = 0; y < kRows; ++y)
            for (int x = 0; x < kColumns; ++x)
                table[size_t(y) * kColumns + size_t(x)] +=
                    0.01f * meanValue_ * std::sin(kPi * (static_cast<float>(y) + 0.5f) / kRows);
        table_ = Distribution2D(table, kColumns, kRows);
    }

    Vec3f position_;
    Frame axes_;
    Rgb scale_;
    PhotometricWeb web_;
    Distribution2D table_;
    float meanValue_ = 0;  ///< over all directions
};

}  // namespace

float PhotometricWeb::at(float verticalDegrees, float horizontalDegrees) const {
    if (verticalDegrees < vertical.front() || verticalDegrees > vertical.back()) return 0;
    const Place v = placeOf(vertical, verticalDegrees);
    const size_t rows = vertical.size();
    const auto along = [&](size_t plane) {
        const float* column = &values[plane * rows];
        return v.fraction > 0 ? lerp(v.fraction, column[v.low], column[v.low + 1]) : column[v.low];
    };
    if (horizontal.size() == 1) return along(0);
    const float angle = folded(horizontal, horizontalDegrees);
    const Place h = placeOf(horizontal, angle);
    if (h.low + 1 == horizontal.size() && angle > horizontal.back()) {
        // Up to 360 degrees, where the first half plane is again.
        const float gap = 360 - horizontal.back() + horizontal.front();
        return lerp((angle - horizontal.back()) / gap, along(h.low), along(0));
    }
    return h.fraction > 0 ? lerp(h.fraction, along(h.low), along(h.low + 1)) : along(h.low);
}

LightPtr makeGoniometricLight(GoniometricLightParameters parameters) {
    return std::make_shared<GoniometricLight>(std::move(parameters));
}

}  // namespace metrolux::core
