#include "base/warp.h"
#include "geometry/affine.h"
#include "geometry/shape.h"

#include <algorithm>

namespace metrolux::core {

namespace {

Vec3d scaledNormal(const Vec3f& p0, const Vec3f& p1, const Vec3f& p2) {
    return (toDouble(p1) - toDouble(p0)).cross(toDouble(p2) - toDouble(p0));
}

template <class T>
T interpolate(const T& a0, const T& a1, const T& a2, const Vec2f& b) {
    return a0 * (1.0f - b.x - b.y) + a1 * b.x + a2 * b.y;
}

bool isVertexAttribute(const TriangleMesh::Attribute& attribute) {
    return attribute.name.starts_with("vertex_");
}

/// How a triangle's texture coordinates run along its edges e1 and e2.
struct TextureAxes {
    double du1 = 0, dv1 = 0, du2 = 0, dv2 = 0;
    double inverse = 0;  ///< 1 / determinant
    bool exist = false;

    TextureAxes(const TriangleMesh& mesh, const uint32_t* v) {
        if (mesh.uvs.empty()) return;
        const Vec2f &t0 = mesh.uvs[v[0]], &t1 = mesh.uvs[v[1]], &t2 = mesh.uvs[v[2]];
        du1 = double(t1.x) - t0.x, dv1 = double(t1.y) - t0.y;
        du2 = double(t2.x) - t0.x, dv2 = double(t2.y) - t0.y;
        const double determinant = du1 * dv2 - dv1 * du2;
        exist = determinant != 0;
        inverse = exist ? 1 / determinant : 0;
    }
    Vec3d derivativeByU(const Vec3d& e1, const Vec3d& e2) const { return (e1 * dv2 - e2 * dv1) * inverse; }
    Vec3d derivativeByV(const Vec3d& e1, const Vec3d& e2) const { return (e2 * du1 - e1 * du2) * inverse; }
};

}  // namespace

void TriangleMesh::finalize() {
    const size_t vertexCount = positions.size();
    if (indices.size() % 3 != 0)
        throw Error("mesh \"{}\": {} indices are not whole triangles", id, indices.size());
    for (size_t i = 0; i < indices.size(); ++i)
        if (indices[i] >= vertexCount)
            throw Error("mesh \"{}\": triangle {} refers to vertex {}, but there are {}", id, i / 3,
                        indices[i], vertexCount);
    const auto check = [&](size_t size, size_t expected, const std::string& what) {
        if (size != expected) throw Error("mesh \"{}\": {} {}, expected {}", id, size, what, expected);
    };
    if (!normals.empty()) check(normals.size(), vertexCount, "vertex normals");
    if (!uvs.empty()) check(uvs.size(), vertexCount, "texture coordinates");
    for (const Attribute& a : attributes) {
        if (a.channels != 1 && a.channels != 3)
            throw Error("mesh \"{}\": attribute \"{}\" has {} channels, expected 1 or 3", id, a.name,
                        a.channels);
        const size_t count = isVertexAttribute(a) ? vertexCount : primitiveCount();
        check(a.values.size(), count * static_cast<size_t>(a.channels), "values of " + a.name);
    }
    for (size_t i = 0; i < vertexCount; ++i)
        if (!isFinite(positions[i])) throw Error("mesh \"{}\": vertex {} is not finite", id, i);
    for (size_t i = 0; i < normals.size(); ++i)
        if (!isFinite(normals[i])) throw Error("mesh \"{}\": the normal of vertex {} is not finite", id, i);
    for (size_t i = 0; i < uvs.size(); ++i)
        if (!std::isfinite(uvs[i].x) || !std::isfinite(uvs[i].y))
            throw Error("mesh \"{}\": the texture coordinates of vertex {} are not finite", id, i);

    areaCdf_.resize(primitiveCount());
    faces_.resize(primitiveCount());
    double total = 0;
    for (size_t i = 0; i < primitiveCount(); ++i) {
        const uint32_t* v = &indices[3 * i];
        const Vec3d p0 = toDouble(positions[v[0]]);
        const Vec3d e1 = toDouble(positions[v[1]]) - p0, e2 = toDouble(positions[v[2]]) - p0;
        const Vec3d scaled = e1.cross(e2);
        total += 0.5 * scaled.length();
        areaCdf_[i] = total;
        Face& face = faces_[i];
        face.normal = geometricNormal(v, scaled);
        const TextureAxes axes(*this, v);
        face.tangent = axes.exist ? toFloat(axes.derivativeByU(e1, e2)) : Frame::fromNormal(face.normal).s;
    }
    totalArea_ = static_cast<float>(total);
    // Embree reads 16 bytes at the last element of the buffers that it shares with the mesh.
    positions.reserve(vertexCount + 2);
    indices.reserve(indices.size() + 4);
    // Each hit reads them somewhere else.
    const auto preferHuge = [](const auto& array) {
        preferHugePages(array.data(), array.size() * sizeof(array[0]));
    };
    preferHuge(positions);
    preferHuge(normals);
    preferHuge(uvs);
    preferHuge(indices);
}

void TriangleMesh::computeVertexNormals() {
    std::vector<Vec3d> sums(positions.size(), Vec3d(0.0));
    for (size_t i = 0; i < primitiveCount(); ++i) {
        const uint32_t* v = &indices[3 * i];
        const Vec3d normal = scaledNormal(positions[v[0]], positions[v[1]], positions[v[2]]).normalized();
        for (int corner = 0; corner < 3; ++corner) {
            const Vec3d p = toDouble(positions[v[corner]]);
            const Vec3d a = (toDouble(positions[v[(corner + 1) % 3]]) - p).normalized();
            const Vec3d b = (toDouble(positions[v[(corner + 2) % 3]]) - p).normalized();
            sums[v[corner]] += normal * std::atan2(a.cross(b).length(), a.dot(b));
        }
    }
    normals.resize(positions.size());
    // A vertex of degenerate faces only keeps a zero normal; interaction() falls back on the geometric one.
    for (size_t i = 0; i < sums.size(); ++i) normals[i] = toFloat(sums[i].normalized());
}

void TriangleMesh::place(uint32_t triangle, const Vec2f& barycentric, SurfaceInteraction& si) const {
    const uint32_t* v = &indices[3 * size_t(triangle)];
    const Vec3f &p0 = positions[v[0]], &p1 = positions[v[1]], &p2 = positions[v[2]];
    const Vec3d e1 = toDouble(p1) - toDouble(p0), e2 = toDouble(p2) - toDouble(p0);
    // In double, so that errors of the barycentric coordinates slide along the plane and p is rounded once
    // only.
    si.p = toFloat(toDouble(p0) + e1 * static_cast<double>(barycentric.x) +
                   e2 * static_cast<double>(barycentric.y));
    si.shape = this;
    si.primitive = triangle;
    si.barycentric = barycentric;

    si.ng = faces_[triangle].normal;
    si.uv = uvs.empty() ? barycentric : interpolate(uvs[v[0]], uvs[v[1]], uvs[v[2]], barycentric);
}

void TriangleMesh::interaction(uint32_t triangle, const Vec2f& barycentric, SurfaceInteraction& si) const {
    place(triangle, barycentric, si);
    const uint32_t* v = &indices[3 * size_t(triangle)];
    si.ns = si.ng;
    if (!normals.empty()) {
        const Vec3f n = interpolate(normals[v[0]], normals[v[1]], normals[v[2]], barycentric);
        const float norm = std::sqrt(lengthSquared(n));
        if (norm > 1e-6f) si.ns = n / (flipNormals ? -norm : norm);
    }

    si.s = Frame::fromNormalAndTangent(si.ns, faces_[triangle].tangent).s;
}

Vec3f TriangleMesh::geometricNormal(const uint32_t* v, const Vec3d& scaled) const {
    const double length = scaled.length();
    Vec3f n = length > 0 ? toFloat(scaled * (1 / length)) : Vec3f(0, 0, 1);
    if (!normals.empty() && dot(n, normals[v[0]] + normals[v[1]] + normals[v[2]]) < 0) n = -n;
    return flipNormals ? -n : n;
}

DirectionCone TriangleMesh::normalCone() const {
    std::vector<Vec3f> faces;  // those that can be hit or sampled
    Vec3d sum(0.0);
    for (size_t i = 0; i < indices.size(); i += 3) {
        const uint32_t* v = &indices[i];
        const Vec3d scaled = scaledNormal(positions[v[0]], positions[v[1]], positions[v[2]]);
        if (!(scaled.length() > 0)) continue;
        faces.push_back(faces_[i / 3].normal);
        sum += toDouble(faces.back()) * scaled.length();
    }
    const double length = sum.length();
    if (!(length > 0) || !std::isfinite(length)) return {};
    DirectionCone cone{toFloat(sum / length), 1};
    for (const Vec3f& n : faces) cone.cosine = std::min(cone.cosine, dot(cone.axis, n));
    return cone;
}

Partials TriangleMesh::partialsAt(const SurfaceInteraction& si) const {
    const uint32_t* v = &indices[3 * size_t(si.primitive)];
    const Vec3d p0 = toDouble(positions[v[0]]);
    const Vec3d e1 = toDouble(positions[v[1]]) - p0, e2 = toDouble(positions[v[2]]) - p0;
    const TextureAxes axes(*this, v);
    const Partials result{toFloat(axes.derivativeByU(e1, e2)), toFloat(axes.derivativeByV(e1, e2))};
    if (axes.exist && isFinite(result.dpdu) && isFinite(result.dpdv)) return result;
    const Frame frame = Frame::fromNormal(faces_[si.primitive].normal);
    return {frame.s, frame.t};
}

ShapeSample TriangleMesh::sampleArea(const Vec2f& u) const {
    ShapeSample result;
    sampleAreaInto(u, result);
    return result;
}

std::optional<ShapeSample> TriangleMesh::sampleToward(const Vec3f&, const Vec2f& u) const {
    std::optional<ShapeSample> result(std::in_place);
    sampleAreaInto(u, *result);
    return result;
}

void TriangleMesh::sampleAreaInto(const Vec2f& u, ShapeSample& result) const {
    if (!(totalArea_ > 0)) return;
    const double total = areaCdf_.back();
    const double target = std::min(static_cast<double>(u.x), static_cast<double>(kOneMinusEpsilon)) * total;
    // The first entry above the target is never that of a triangle of zero area, which equals its
    // predecessor's. Of few it is counted, without branches that depend on the sample.
    constexpr size_t kFew = 8;
    size_t triangle = 0;
    if (areaCdf_.size() <= kFew)
        for (const double sum : areaCdf_) triangle += sum <= target ? 1 : 0;
    else
        triangle = static_cast<size_t>(std::upper_bound(areaCdf_.begin(), areaCdf_.end(), target) -
                                       areaCdf_.begin());
    const double below = triangle > 0 ? areaCdf_[triangle - 1] : 0.0;
    const float rest = static_cast<float>((target - below) / (areaCdf_[triangle] - below));
    const Vec2f inTriangle(std::clamp(rest, 0.0f, kOneMinusEpsilon), u.y);
    place(static_cast<uint32_t>(triangle), warp::squareToTriangle(inTriangle), result.si);
    result.si.ns = result.si.ng;
    result.si.s = Frame::fromNormal(result.si.ng).s;
    result.pdfArea = 1.0f / totalArea_;
}

void TriangleMesh::bounds(Vec3f& lower, Vec3f& upper) const {
    lower = Vec3f(kInfinity), upper = Vec3f(-kInfinity);
    for (const uint32_t index : indices)
        for (int i = 0; i < 3; ++i) {
            lower[i] = std::min(lower[i], positions[index][i]);
            upper[i] = std::max(upper[i], positions[index][i]);
        }
}

int TriangleMesh::attributeChannels(const std::string& name) const {
    for (const Attribute& a : attributes)
        if (a.name == name) return a.channels;
    return 0;
}

bool TriangleMesh::attribute(const std::string& name, const SurfaceInteraction& si, Rgb& value) const {
    for (const Attribute& a : attributes) {
        if (a.name != name) continue;
        const auto at = [&](size_t i) {
            const float* v = &a.values[i * static_cast<size_t>(a.channels)];
            return a.channels == 1 ? Rgb(v[0]) : Rgb(v[0], v[1], v[2]);
        };
        const uint32_t* v = &indices[3 * size_t(si.primitive)];
        value = isVertexAttribute(a) ? Rgb(interpolate(at(v[0]), at(v[1]), at(v[2]), si.barycentric))
                                     : at(si.primitive);
        return true;
    }
    return false;
}

Partials partials(const SurfaceInteraction& si) {
    if (!si.shape) return {si.s, cross(si.ns, si.s)};
    Partials result = si.shape->partialsAt(si);
    if (si.placement) result = {si.placement->vector(result.dpdu), si.placement->vector(result.dpdv)};
    return result;
}

}  // namespace metrolux::core
