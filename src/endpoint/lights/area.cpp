#include "base/error.h"
#include "base/frame.h"
#include "base/warp.h"
#include "endpoint/lights.h"
#include "endpoint/lights/texture_table.h"
#include "scattering/textures/scaled.h"

namespace metrolux::core {

namespace {

/// A mesh of two triangles that fill the unit uv square by one affine map: a parallelogram, on which a
/// texture can be importance-sampled through its uv.
class Parallelogram {
  public:
    static std::optional<Parallelogram> fromShape(const Shape& shape) {
        const auto* mesh = dynamic_cast<const TriangleMesh*>(&shape);
        if (!mesh || mesh->indices.size() != 6 || mesh->uvs.size() != mesh->positions.size())
            return std::nullopt;
        Parallelogram result(*mesh);
        // Affine map by the first triangle; the second must agree with it, and the uvs be corners of the
        // square.
        const auto index = [&](int i) { return mesh->indices[static_cast<size_t>(i)]; };
        const Vec2f a = mesh->uvs[index(0)], e1 = mesh->uvs[index(1)] - a, e2 = mesh->uvs[index(2)] - a;
        const float det = e1.x * e2.y - e1.y * e2.x;
        if (std::abs(std::abs(det) - 1) > 1e-5f) return std::nullopt;
        const Vec2f c = mesh->uvs[index(3)], f1 = mesh->uvs[index(4)] - c, f2 = mesh->uvs[index(5)] - c;
        const float second = f1.x * f2.y - f1.y * f2.x;
        if (std::abs(second - det) > 1e-5f) return std::nullopt;
        const Vec3f p = mesh->positions[index(0)];
        const Vec3f d1 = mesh->positions[index(1)] - p, d2 = mesh->positions[index(2)] - p;
        result.uvOrigin_ = a;
        result.toBarycentric1_ = Vec2f(e2.y, -e2.x) / det;
        result.toBarycentric2_ = Vec2f(-e1.y, e1.x) / det;
        const float tolerance = 1e-4f * std::sqrt(std::max(lengthSquared(d1), lengthSquared(d2)));
        for (int i = 0; i < 6; ++i) {
            const Vec2f uv = mesh->uvs[index(i)];
            if ((uv.x != 0 && uv.x != 1) || (uv.y != 0 && uv.y != 1)) return std::nullopt;
            const Vec2f b = result.barycentric(uv);
            if (((p + d1 * b.x + d2 * b.y) - mesh->positions[index(i)]).length() > tolerance)
                return std::nullopt;
        }
        return result;
    }

    SurfaceInteraction at(const Vec2f& uv) const {
        Vec2f b = barycentric(uv);
        uint32_t triangle = 0;
        if (b.x < 0 || b.y < 0 || b.x + b.y > 1) {
            triangle = 1;
            b = barycentricOfSecond(uv);
        }
        SurfaceInteraction si;
        mesh_->interaction(triangle, b, si);
        return si;
    }

  private:
    explicit Parallelogram(const TriangleMesh& mesh) : mesh_(&mesh) {}
    Vec2f barycentric(const Vec2f& uv) const {
        const Vec2f d = uv - uvOrigin_;
        return {dot2(toBarycentric1_, d), dot2(toBarycentric2_, d)};
    }
    Vec2f barycentricOfSecond(const Vec2f& uv) const {
        const Vec2f a = mesh_->uvs[mesh_->indices[3]];
        const Vec2f e1 = mesh_->uvs[mesh_->indices[4]] - a, e2 = mesh_->uvs[mesh_->indices[5]] - a,
                    d = uv - a;
        const float det = e1.x * e2.y - e1.y * e2.x;
        const float b1 = std::clamp((d.x * e2.y - d.y * e2.x) / det, 0.0f, 1.0f);
        return {b1, std::clamp((e1.x * d.y - e1.y * d.x) / det, 0.0f, 1.0f - b1)};
    }
    static float dot2(const Vec2f& a, const Vec2f& b) { return a.x * b.x + a.y * b.y; }

    const TriangleMesh* mesh_;
    Vec2f uvOrigin_, toBarycentric1_, toBarycentric2_;
};

/// Share of a spherical cap's area (1 - cosine is its height) that faces its axis, seen from afar: 1 when it
/// is flat, 1/4 for the whole sphere.
float projectedShare(float cosine) { return cosine > 0 ? 0.5f * (1 + cosine) : 0.5f / (1 - cosine); }

/// Knows points that are behind all of a flat light, to which connections need not be tried. Points that it
/// does not exclude may be behind the light too.
class FrontSide {
  public:
    /// Excludes nothing, unless the shape is a mesh in one plane.
    explicit FrontSide(const Shape& shape) {
        const DirectionCone cone = shape.normalCone();
        const auto* mesh = dynamic_cast<const TriangleMesh*>(&shape);
        if (!mesh || !(cone.cosine > 1 - 0.5f * kAngle * kAngle)) return;
        normal_ = cone.axis;
        least_ = kInfinity;
        for (const uint32_t index : mesh->indices) {
            const Vec3f& p = mesh->positions[index];
            least_ = std::min(least_, dot(normal_, p));
            size_ = std::max(size_, p.length());
        }
    }
    bool excludes(const Vec3f& x) const {
        return dot(normal_, x) <
               least_ - 2 * kAngle * (std::abs(x.x) + std::abs(x.y) + std::abs(x.z) + size_);
    }

  private:
    /// Normals deviate from each other by less. Twice that leaves room for rounding.
    static constexpr float kAngle = 1e-3f;
    Vec3f normal_{0.0f};
    float least_ = -kInfinity, size_ = 0;
};

class AreaLight final : public Light {
  public:
    explicit AreaLight(const AreaLightParameters& p)
        : shape_(p.shape), radiance_(p.radiance), area_(p.shape->area()), front_(*p.shape) {
        if (!(area_ > 0)) throw Error("area light on shape '{}': the shape has no area", p.shape->id);
        if (!radiance_->isConstant()) parallelogram_ = Parallelogram::fromShape(*shape_);
        makeTable();
    }

    float power() const override { return std::max(luminance(radiance_->mean()), 0.0f) * kPi * area_; }
    std::optional<LightBounds> bounds() const override {
        LightBounds b;
        shape_->bounds(b.lower, b.upper);
        b.normals = shape_->normalCone();
        b.intensity = power() * kInvPi * projectedShare(b.normals.cosine);
        return b;
    }
    bool isDelta() const override { return false; }
    const Shape* shape() const override { return shape_; }

    Rgb radiance(const SurfaceInteraction& si, const Vec3f& w) const override {
        return dot(si.ng, w) > 0 ? radiance_->rgb(si) : Rgb(0.0f);
    }

    EndpointDensities densities(const Vec3f& x, const SurfaceInteraction& si) const override {
        const Vec3f d = x - si.p;
        const float distance2 = lengthSquared(d);
        if (!(distance2 > 0)) return {};
        const float cosine = dot(si.ng, d) / std::sqrt(distance2);
        if (!(cosine > 0)) return {};
        return {pdfToward(x, si) * distance2 / cosine, pdfArea(si), cosine * kInvPi, cosine};
    }

    std::optional<EndpointRay> sampleRay(const Vec2f& uPosition, const Vec2f& uDirection) const override {
        const ShapeSample point = sampleArea(uPosition);
        const Rgb emitted = radiance_->rgb(point.si);
        if (!(point.pdfArea > 0) || isBlack(emitted)) return std::nullopt;
        const Vec3f local = warp::squareToCosineHemisphere(uDirection);
        EndpointRay ray;
        ray.surface = point.si;
        ray.origin = point.si.p;
        ray.ng = point.si.ng;
        ray.direction = normalize(Frame::fromNormal(point.si.ng).toWorld(local));
        ray.cosine = local.z;
        ray.pdfPosition = point.pdfArea;
        ray.pdfDirection = warp::cosineHemispherePdf(local);
        ray.weight = emitted * (kPi / point.pdfArea);
        return ray;
    }

    std::optional<EndpointConnection> connect(const Vec3f& x, const Vec2f& u) const override {
        if (front_.excludes(x)) return std::nullopt;
        const std::optional<ShapeSample> point = parallelogram_ ? sampleArea(u) : shape_->sampleToward(x, u);
        if (!point || !(point->pdfArea > 0)) return std::nullopt;
        const Vec3f d = point->si.p - x;
        const float distance = d.length();
        if (!(distance > 0)) return std::nullopt;
        const Vec3f wi = d / distance;
        const float cosine = -dot(point->si.ng, wi);
        const Rgb emitted = radiance(point->si, -wi);
        if (isBlack(emitted)) return std::nullopt;
        const float pdf = point->pdfArea * sqr(distance) / cosine;
        if (!std::isfinite(pdf) || !(pdf > 0)) return std::nullopt;
        // Made where the caller wants it: a copy of fields just written would wait for the store buffer.
        return std::optional<EndpointConnection>(std::in_place, point->si.p, wi, distance, point->si.ng,
                                                 emitted * (1.0f / pdf), pdf, pdfArea(point->si),
                                                 cosine * kInvPi, cosine);
    }

  protected:
    void scaleEmission(float factor) override {
        radiance_ = makeScaledTexture({radiance_, Rgb(factor)});
        makeTable();
    }

  private:
    void makeTable() {
        if (parallelogram_) table_ = luminanceTable(*radiance_);
    }
    ShapeSample sampleArea(const Vec2f& u) const {
        if (!parallelogram_) return shape_->sampleArea(u);
        float pdf = 0;
        const Vec2f uv = table_.sample(u, pdf);
        ShapeSample sample{parallelogram_->at(uv), 0};
        // By the same function as densities(), so that rounding at a cell's edge cannot tell the two apart.
        sample.pdfArea = pdfArea(sample.si);
        return sample;
    }
    float pdfArea(const SurfaceInteraction& si) const {
        return parallelogram_ ? table_.pdf(si.uv) / area_ : 1.0f / area_;
    }
    float pdfToward(const Vec3f& x, const SurfaceInteraction& si) const {
        return parallelogram_ ? pdfArea(si) : shape_->pdfToward(x, si);
    }

    const Shape* shape_;
    TexturePtr radiance_;
    float area_;
    FrontSide front_;
    std::optional<Parallelogram> parallelogram_;  // only for textured emission
    Distribution2D table_;
};

}  // namespace

LightPtr makeAreaLight(const AreaLightParameters& parameters) {
    if (!parameters.shape || !parameters.radiance) throw Error("area light: shape or radiance is missing");
    return std::make_shared<AreaLight>(parameters);
}

}  // namespace metrolux::core
