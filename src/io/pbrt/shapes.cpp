#include "io/pbrt/shapes.h"

#include "base/suggest.h"
#include "io/mesh_io.h"
#include "io/mitsuba/field_of_view.h"
#include "io/mitsuba/maker.h"
#include "io/pbrt/curves.h"

#include <algorithm>
#include <numbers>

namespace metrolux::core::pbrt {
namespace {

using mitsuba::MeshArrays;

constexpr double kPi2 = 2 * std::numbers::pi;
/// How far the back of a surface that emits to both sides lies behind it, as a share of its size.
constexpr double kBack = 1e-4;

/// A mesh in the making.
struct Arrays {
    std::vector<float> positions, normals, uvs;
    std::vector<uint32_t> triangles;

    size_t vertices() const { return positions.size() / 3; }
    Vec3d position(size_t i) const { return {positions[3 * i], positions[3 * i + 1], positions[3 * i + 2]}; }
    void add(const Vec3d& p, const Vec3d& n, double u, double v) {
        for (int c = 0; c < 3; ++c) positions.push_back(static_cast<float>(p[c]));
        if (n != Vec3d(0.0))
            for (int c = 0; c < 3; ++c) normals.push_back(static_cast<float>(n[c]));
        uvs.insert(uvs.end(), {static_cast<float>(u), static_cast<float>(v)});
    }
};
using ArraysPtr = std::shared_ptr<Arrays>;

ArraysPtr arraysOf(const TriangleMesh& mesh) {
    auto result = std::make_shared<Arrays>();
    for (size_t i = 0; i < mesh.positions.size(); ++i) {
        const Vec2f uv = mesh.uvs.empty() ? Vec2f(0.0f) : mesh.uvs[i];
        result->add(Vec3d(mesh.positions[i]), mesh.normals.empty() ? Vec3d(0.0) : Vec3d(mesh.normals[i]),
                    double(uv.x), double(uv.y));
    }
    result->triangles = mesh.indices;
    return result;
}

/// A surface of two parameters in [0, 1], as a grid. The outside is on the side of dp/du x dp/dv.
template <class Point>
ArraysPtr gridOf(int columns, int rows, bool smooth, const Point& point) {
    auto result = std::make_shared<Arrays>();
    for (int j = 0; j <= rows; ++j)
        for (int i = 0; i <= columns; ++i) {
            const double u = double(i) / columns, v = double(j) / rows;
            Vec3d normal(0.0);
            const Vec3d p = point(u, v, normal);
            result->add(p, smooth ? normal : Vec3d(0.0), u, v);
        }
    for (int j = 0; j < rows; ++j)
        for (int i = 0; i < columns; ++i) {
            const auto a = static_cast<uint32_t>(j * (columns + 1) + i), b = a + 1,
                       d = a + static_cast<uint32_t>(columns) + 1, c = d + 1;
            result->triangles.insert(result->triangles.end(), {a, b, c, a, c, d});
        }
    return result;
}

class ShapeMaker {
  public:
    ShapeMaker(const Parameters& p, const Transform& toWorld, const ShapeOptions& options, Reading& reading)
        : p_(p),
          toWorld_(toWorld),
          reversed_(options.reversed),
          withBack_(options.withBack),
          isTextured_(options.isTextured),
          needsArea_(options.needsArea),
          reading_(reading) {}

    std::vector<ShapePart> parts;

    void triangleMesh(bool isControl) {
        auto mesh = arrays();
        if (isControl) {
            reading_.warn(p_.error("loopsubdiv is read as its control mesh"));
            p_.ignore({"levels", "scheme"});
        }
        if (p_.has("S")) p_.ignore({"S"});
        const std::vector<double>& indices = p_.numbers("indices", 3);
        if (indices.empty() && mesh->vertices() != 3)
            throw p_.error("has no \"integer indices\", expected some");
        for (const double index : indices) mesh->triangles.push_back(vertex(index, mesh->vertices()));
        if (indices.empty()) mesh->triangles = {0, 1, 2};
        addMesh(std::move(mesh), !isControl);
    }

    void bilinearMesh() {
        const ArraysPtr corners = arrays();
        std::vector<double> indices = p_.numbers("indices", 4);
        if (indices.empty() && corners->vertices() == 4) indices = {0, 1, 2, 3};
        p_.ignore({"emissionfilename"});
        auto mesh = std::make_shared<Arrays>();
        for (size_t i = 0; i + 3 < indices.size(); i += 4) {
            size_t v[4];
            for (size_t k = 0; k < 4; ++k) v[k] = vertex(indices[i + k], corners->vertices());
            addPatch(*corners, v, *mesh);
        }
        addMesh(std::move(mesh), true);
    }

    void plyMesh() {
        const std::string file = p_.requiredString("filename");
        if (p_.has("displacement"))
            reading_.refuse(p_.error("displaced meshes are not supported"), "without its displacement");
        p_.ignore({"displacement", "edgelength"});
        const std::filesystem::path found = reading_.find(file, p_.where());
        const bool flat = !plyHasNormals(found);
        auto result = element("ply");
        result.with("filename", found.string());
        place(result, toWorld_, reversed_);
        if (flat) result.with("face_normals", true);
        ShapePart part{result};
        if (needsArea_ || withBack_) {
            MeshOptions options;
            options.memory = &reading_.memory;
            options.faceNormals = flat;
            if (withBack_) {
                return addMesh(arraysOf(*readPly(found, options)), flat);
            }
            options.toWorld = toWorld_;
            const auto mesh = readPly(found, options);
            part.area = double(mesh->area());
            part.triangles = double(mesh->primitiveCount());
        }
        parts.push_back(std::move(part));
    }

    void curve() {
        const ArraysPtr tube = arraysOf(*curveMesh(p_, reading_));
        if (!tube->triangles.empty()) addMesh(tube, false);
    }

    void sphere() {
        const double r = positive("radius", 1);
        const double low = std::clamp(p_.number("zmin", -r), -r, r),
                     high = std::clamp(p_.number("zmax", r), -r, r);
        const double phi = turn();
        if (low <= -r && high >= r && phi >= kPi2 && !isTextured_ && mitsuba::isSimilarity(toWorld_)) {
            quadric("sphere", 2 * kPi2 * r * r,
                    [r](mitsuba::Maker& e, double back) { e.with("radius", r * (1 - back)); });
            return;
        }
        const double from = std::acos(std::clamp(low / r, -1.0, 1.0)),
                     to = std::acos(std::clamp(high / r, -1.0, 1.0));
        tessellated([=](double u, double v, Vec3d& n) {
            const double theta = from + v * (to - from);
            n = {std::sin(theta) * std::cos(u * phi), std::sin(theta) * std::sin(u * phi), std::cos(theta)};
            return n * r;
        });
    }

    void cylinder() {
        const double r = positive("radius", 1), low = p_.number("zmin", -1), high = p_.number("zmax", 1);
        if (!(low < high))
            throw p_.error(fmt::format("found zmin {} and zmax {}, expected less and more", low, high));
        const double phi = turn();
        if (phi >= kPi2 && mitsuba::isSimilarity(toWorld_)) {
            quadric("cylinder", kPi2 * r * (high - low), [=](mitsuba::Maker& e, double back) {
                e.with("radius", r * (1 - back));
                e.with("p0", Vec3d(0, 0, low));
                e.with("p1", Vec3d(0, 0, high));
            });
            return;
        }
        tessellated([=](double u, double v, Vec3d& n) {
            n = {std::cos(u * phi), std::sin(u * phi), 0};
            return n * r + Vec3d(0, 0, low + v * (high - low));
        });
    }

    void disk() {
        const double r = positive("radius", 1), hole = p_.number("innerradius", 0),
                     height = p_.number("height", 0);
        const double phi = turn();
        if (!(hole > 0) && phi >= kPi2 && !isTextured_) {
            const Transform own = Transform::translate({0, 0, height}) *
                                  Transform::scale({static_cast<float>(r), static_cast<float>(r), 1});
            const Transform map = toWorld_;
            for (const bool back : {false, true}) {
                if (back && !withBack_) break;
                auto result = element("disk");
                const double behind = (reversed_ ? kBack : -kBack) * r;
                place(result,
                      mitsuba::settledMap(map * Transform::translate({0, 0, back ? behind : 0}) * own),
                      reversed_ != back);
                parts.push_back({result, diskArea(r)});
            }
            return;
        }
        tessellated([=](double u, double v, Vec3d& n) {
            n = {0, 0, 1};
            const double d = r + v * (hole - r);
            return Vec3d(d * std::cos(u * phi), d * std::sin(u * phi), height);
        });
    }

  private:
    mitsuba::Maker element(const char* type) const { return {"shape", type, p_.where()}; }
    static void place(mitsuba::Maker& element, const Transform& toWorld, bool flip) {
        element.with("to_world", toWorld);
        if (flip) element.with("flip_normals", true);
    }

    double positive(const char* name, double fallback) const {
        const double value = p_.number(name, fallback);
        if (!(value > 0))
            throw p_.error(fmt::format("found the {} {}, expected more than zero", name, value));
        return value;
    }
    /// phimax in radians.
    double turn() const {
        const double degrees = p_.number("phimax", 360);
        if (!(degrees > 0)) throw p_.error(fmt::format("found phimax {}, expected more than zero", degrees));
        return std::min(degrees, 360.0) * (kPi2 / 360);
    }
    /// Of the unit cube's image in the world, per volume^(2/3): the factor of areas under a similarity.
    double areaFactor() const { return std::pow(std::abs(toWorld_.determinant3()), 2.0 / 3); }
    double diskArea(double r) const {
        const Vec3d x(toWorld_.at(0, 0), toWorld_.at(1, 0), toWorld_.at(2, 0)),
            y(toWorld_.at(0, 1), toWorld_.at(1, 1), toWorld_.at(2, 1));
        return kPi2 / 2 * r * r * x.cross(y).length();
    }

    template <class Fill>
    void quadric(const char* type, double area, const Fill& fill) {
        for (const bool back : {false, true}) {
            if (back && !withBack_) break;
            auto result = element(type);
            fill(result, back ? (reversed_ ? -kBack : kBack) : 0);
            place(result, toWorld_, reversed_ != back);
            parts.push_back({result, area * areaFactor()});
        }
    }
    template <class Point>
    void tessellated(const Point& point) {
        constexpr int kColumns = 96, kRows = 48;
        reading_.memory.take(kColumns * kRows * 64, "the shape");
        addMesh(gridOf(kColumns, kRows, true, point), false);
    }

    /// P, N and uv of a mesh.
    ArraysPtr arrays() const {
        auto result = std::make_shared<Arrays>();
        const std::vector<double>&positions = p_.numbers("P", 3), &normals = p_.numbers("N", 3);
        const std::vector<double>& uvs = p_.has("uv") ? p_.numbers("uv", 2) : p_.numbers("st", 2);
        if (positions.empty()) throw p_.error("has no \"point3 P\", expected some");
        reading_.memory.take((positions.size() + normals.size() + uvs.size()) * sizeof(float), "the mesh");
        const size_t n = positions.size() / 3;
        const auto copy = [&](const std::vector<double>& from, std::vector<float>& to, size_t size,
                              const char* name) {
            if (!from.empty() && from.size() != size * n)
                throw p_.error(fmt::format("found {} of \"{}\" for {} vertices, expected as many",
                                           from.size() / size, name, n));
            to.assign(from.begin(), from.end());
        };
        copy(positions, result->positions, 3, "P");
        copy(normals, result->normals, 3, "N");
        copy(uvs, result->uvs, 2, "uv");
        return result;
    }
    uint32_t vertex(double index, size_t vertices) const {
        if (!(index >= 0 && index < double(vertices)) || index != std::floor(index))
            throw p_.error(fmt::format("found the index {}, expected 0 to {}", index, vertices - 1));
        return static_cast<uint32_t>(index);
    }

    /// Two triangles where the four corners lie in a plane, a grid where not.
    void addPatch(const Arrays& corners, const size_t (&v)[4], Arrays& mesh) const {
        const Vec3d p00 = corners.position(v[0]), p10 = corners.position(v[1]), p01 = corners.position(v[2]),
                    p11 = corners.position(v[3]);
        const Vec3d normal = (p10 - p00).cross(p01 - p00);
        const bool isFlat =
            std::abs((p11 - p00).dot(normal)) <= 1e-5 * normal.length() * (p11 - p00).length();
        constexpr int kCurved = 16;
        const int n = isFlat ? 1 : kCurved;
        reading_.memory.take(
            static_cast<uint64_t>((n + 1) * (n + 1)) * 32 + static_cast<uint64_t>(n * n) * 24, "the mesh");
        const auto numbers = [&](const std::vector<float>& values, size_t size, double u, double w) {
            Vec3d sum(0.0);
            const double weights[4] = {(1 - u) * (1 - w), u * (1 - w), (1 - u) * w, u * w};
            for (size_t k = 0; k < 4; ++k)
                for (size_t c = 0; c < size; ++c)
                    sum[static_cast<int>(c)] += weights[k] * double(values[size * v[k] + c]);
            return sum;
        };
        const ArraysPtr grid =
            gridOf(n, n, !isFlat || !corners.normals.empty(), [&](double u, double w, Vec3d& out) {
                const Vec3d du = (p10 - p00) * (1 - w) + (p11 - p01) * w,
                            dv = (p01 - p00) * (1 - u) + (p11 - p10) * u;
                out =
                    (corners.normals.empty() ? du.cross(dv) : numbers(corners.normals, 3, u, w)).normalized();
                return numbers(corners.positions, 3, u, w);
            });
        if (!corners.uvs.empty())
            for (size_t i = 0; i < grid->vertices(); ++i) {
                const Vec3d uv =
                    numbers(corners.uvs, 2, double(grid->uvs[2 * i]), double(grid->uvs[2 * i + 1]));
                grid->uvs[2 * i] = static_cast<float>(uv.x);
                grid->uvs[2 * i + 1] = static_cast<float>(uv.y);
            }
        // Vertices without a normal would be smoothed: all or none of a mesh have one.
        if (grid->normals.empty() && !mesh.normals.empty())
            for (size_t i = 0; i < grid->vertices(); ++i)
                for (int c = 0; c < 3; ++c)
                    grid->normals.push_back(static_cast<float>(normal.normalized()[c]));
        if (!grid->normals.empty() && mesh.normals.empty() && mesh.vertices() > 0) giveNormals(mesh);
        const auto offset = static_cast<uint32_t>(mesh.vertices());
        mesh.positions.insert(mesh.positions.end(), grid->positions.begin(), grid->positions.end());
        mesh.normals.insert(mesh.normals.end(), grid->normals.begin(), grid->normals.end());
        mesh.uvs.insert(mesh.uvs.end(), grid->uvs.begin(), grid->uvs.end());
        for (const uint32_t index : grid->triangles) mesh.triangles.push_back(index + offset);
    }
    /// Those of the faces, to a mesh of which no two share a vertex but in one plane.
    static void giveNormals(Arrays& mesh) {
        mesh.normals.assign(mesh.positions.size(), 0);
        for (size_t i = 0; i + 2 < mesh.triangles.size(); i += 3) {
            const uint32_t* t = &mesh.triangles[i];
            const Vec3d n = (mesh.position(t[1]) - mesh.position(t[0]))
                                .cross(mesh.position(t[2]) - mesh.position(t[0]))
                                .normalized();
            for (int k = 0; k < 3; ++k)
                for (int c = 0; c < 3; ++c)
                    mesh.normals[3 * t[k] + static_cast<uint32_t>(c)] = static_cast<float>(n[c]);
        }
    }

    /// `flat`: where it has no normals its faces are flat.
    void addMesh(ArraysPtr mesh, bool flat) {
        for (const bool back : {false, true}) {
            if (back && !withBack_) break;
            if (back) mesh = behind(*mesh);
            auto result = element("mesh");
            result.with("arrays",
                        MeshArrays{mesh->positions, mesh->normals, mesh->uvs, mesh->triangles, {}, mesh});
            place(result, toWorld_, reversed_ != back);
            if (flat && mesh->normals.empty()) result.with("face_normals", true);
            parts.push_back({result, areaOf(*mesh), double(mesh->triangles.size() / 3)});
        }
    }
    double areaOf(const Arrays& mesh) const {
        double sum = 0;
        const auto world = [&](uint32_t i) { return toWorld_.exactPoint(mesh.position(i)); };
        for (size_t i = 0; i + 2 < mesh.triangles.size(); i += 3) {
            const Vec3d a = world(mesh.triangles[i]);
            sum += (world(mesh.triangles[i + 1]) - a).cross(world(mesh.triangles[i + 2]) - a).length() / 2;
        }
        return sum;
    }
    /// The mesh, moved to the back by a little.
    ArraysPtr behind(const Arrays& mesh) const {
        reading_.memory.take(mesh.positions.size() * 4 * sizeof(float), "the mesh");
        auto result = std::make_shared<Arrays>(mesh);
        Arrays normals = mesh;
        if (normals.normals.empty()) giveNormals(normals);
        Vec3d lower(1e300), upper(-1e300);
        for (size_t i = 0; i < mesh.vertices(); ++i)
            for (int c = 0; c < 3; ++c) {
                lower[c] = std::min(lower[c], mesh.position(i)[c]);
                upper[c] = std::max(upper[c], mesh.position(i)[c]);
            }
        const double step = (reversed_ ? 1 : -1) * kBack * (upper - lower).length();
        for (size_t i = 0; i < mesh.positions.size(); ++i)
            result->positions[i] += static_cast<float>(step * double(normals.normals[i]));
        return result;
    }

    const Parameters& p_;
    Transform toWorld_;
    bool reversed_, withBack_, isTextured_, needsArea_;
    Reading& reading_;
};

struct ShapeType {
    const char* name;
    void (*make)(ShapeMaker&);
};
constexpr ShapeType kShapeTypes[] = {
    {"trianglemesh", [](ShapeMaker& s) { s.triangleMesh(false); }},
    {"plymesh", [](ShapeMaker& s) { s.plyMesh(); }},
    {"bilinearmesh", [](ShapeMaker& s) { s.bilinearMesh(); }},
    {"loopsubdiv", [](ShapeMaker& s) { s.triangleMesh(true); }},
    {"sphere", [](ShapeMaker& s) { s.sphere(); }},
    {"cylinder", [](ShapeMaker& s) { s.cylinder(); }},
    {"disk", [](ShapeMaker& s) { s.disk(); }},
    {"curve", [](ShapeMaker& s) { s.curve(); }},
};

}  // namespace

std::vector<std::string> shapeTypes() {
    std::vector<std::string> names;
    for (const ShapeType& type : kShapeTypes) names.emplace_back(type.name);
    return names;
}

std::vector<ShapePart> makeShape(const std::string& type, const Parameters& parameters,
                                 const Transform& toWorld, const ShapeOptions& options, Reading& reading) {
    ShapeMaker maker(parameters, toWorld, options, reading);
    for (const ShapeType& known : kShapeTypes) {
        if (type != known.name) continue;
        known.make(maker);
        return std::move(maker.parts);
    }
    const std::string nearest = nearestName(type, shapeTypes());
    reading.refuse(
        parameters.error(fmt::format("the shape \"{}\" is not supported{}, expected one of {}", type,
                                     nearest.empty() ? "" : fmt::format(" (did you mean \"{}\"?)", nearest),
                                     fmt::join(shapeTypes(), ", "))),
        "it is left out");
    for (const Parameter& p : parameters.all()) parameters.find(p.name);
    return {};
}

}  // namespace metrolux::core::pbrt
