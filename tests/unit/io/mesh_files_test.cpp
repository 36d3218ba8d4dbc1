// Mesh files written here: what is read, and that damaged ones are refused with their name and never crash.
#include "base/error.h"
#include "base/rng.h"
#include "io/mesh_io.h"
#include "support/temporary_folder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <bit>
#include <filesystem>
#include <fstream>
#include <functional>
#include <zlib.h>

namespace metrolux::core {
namespace {

namespace fs = std::filesystem;
using Read = std::function<std::shared_ptr<TriangleMesh>(const fs::path&)>;

/// A file that is gone with its scope.
class Scratch {
  public:
    explicit Scratch(const std::string& content) : path_(folder_.write("a.mesh", content)) {}
    const fs::path& path() const { return path_; }

  private:
    test::TemporaryFolder folder_;
    fs::path path_;
};

const Read kObj = [](const fs::path& path) { return readObj(path, {}); };
const Read kPly = [](const fs::path& path) { return readPly(path, {}); };
const Read kSerialized = [](const fs::path& path) { return readSerialized(path, 0, {}); };

std::shared_ptr<TriangleMesh> read(const Read& reader, const std::string& content) {
    const Scratch file(content);
    return reader(file.path());
}

/// Message of the refusal; it names the file.
std::string refusal(const Read& reader, const std::string& content) {
    const Scratch file(content);
    try {
        reader(file.path());
    } catch (const Error& error) {
        EXPECT_THAT(error.what(), testing::HasSubstr(file.path().string()));
        return error.what();
    }
    ADD_FAILURE() << "was read";
    return "";
}

/// Damaged content is refused with the file's name, or read; nothing else happens.
void survives(const Read& reader, const std::string& content) {
    const Scratch file(content);
    try {
        reader(file.path());
    } catch (const Error& error) {
        EXPECT_THAT(error.what(), testing::HasSubstr(file.path().string()));
    }
}

/// All truncations, and random damage.
void survivesDamage(const Read& reader, const std::string& content) {
    const size_t step = std::max<size_t>(content.size() / 300, 1);
    for (size_t size = 0; size < content.size(); size += step) survives(reader, content.substr(0, size));
    CounterRng rng(hashKey(31));
    for (int i = 0; i < 500; ++i) {
        std::string damaged = content;
        for (int n = 0; n <= i % 4; ++n)
            damaged[rng.nextBits() % damaged.size()] = static_cast<char>(rng.nextBits());
        survives(reader, damaged);
    }
    std::string garbage(500, '\0');
    for (char& c : garbage) c = static_cast<char>(rng.nextBits());
    refusal(reader, garbage);
    refusal(reader, "");
}

template <class T>
void put(std::string& out, T value, bool bigEndian = false) {
    auto bytes = std::bit_cast<std::array<char, sizeof(T)>>(value);
    if (bigEndian) std::reverse(bytes.begin(), bytes.end());
    out.append(bytes.data(), bytes.size());
}

// ---- OBJ

constexpr const char* kQuadObj =
    "# a quad\nmtllib none.mtl\no quad\nv 0 0 0\nv 1 0 0 # right\nv 1 1 0\r\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 "
    "1\nvt 0 1\n"
    "vn 0 0 1\nusemtl x\ns 1\nf 1/1/1 2/2/1 3/3/1 4/4/1 # four corners\n";

TEST(MeshObj, QuadBecomesAFan) {
    const auto mesh = read(kObj, kQuadObj);
    EXPECT_THAT(mesh->indices, testing::ElementsAre(0, 1, 2, 0, 2, 3));
    ASSERT_EQ(mesh->positions.size(), 4u);
    EXPECT_EQ(mesh->positions[2], Vec3f(1, 1, 0));
    EXPECT_EQ(mesh->normals[3], Vec3f(0, 0, 1));
    EXPECT_EQ(mesh->uvs[2], Vec2f(1, 1));
    EXPECT_NEAR(mesh->area(), 1, 1e-6);
}

TEST(MeshObj, OptionsApply) {
    const Scratch file(kQuadObj);
    MeshOptions options;
    options.toWorld = Transform::rotate({1, 0, 0}, 90) * Transform::scale({2, 2, 5});
    options.flipTexCoords = true;
    const auto mesh = readObj(file.path(), options);
    EXPECT_LE((mesh->positions[2] - Vec3f(2, 0, 2)).length(), 1e-6f);
    EXPECT_LE((mesh->normals[0] - Vec3f(0, -1, 0)).length(), 1e-6f);
    EXPECT_EQ(mesh->uvs[2], Vec2f(1, 0));
    EXPECT_NEAR(mesh->area(), 4, 1e-5);
    options.faceNormals = true;
    EXPECT_TRUE(readObj(file.path(), options)->normals.empty());
}

TEST(MeshObj, VerticesSplitAndIndicesCountFromTheEnd) {
    // The middle edge has two normals; negative indices are relative.
    const auto mesh = read(
        kObj,
        "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvn 0 0 1\nvn 0 1 1\nf 1//1 2//1 3//1\nf -4//-1 -2//-1 -1//-1\n");
    EXPECT_EQ(mesh->positions.size(), 6u);
    EXPECT_EQ(mesh->positions[3], Vec3f(0, 0, 0));
    EXPECT_TRUE(mesh->uvs.empty());
    // Without normals they are computed.
    EXPECT_EQ(read(kObj, "v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3")->normals[1], Vec3f(0, 0, 1));
}

TEST(MeshObj, RefusesWhatIsWrong) {
    const std::string vertices = "v 0 0 0\nv 1 0 0\nv 1 1 0\n";
    EXPECT_THAT(refusal(kObj, vertices), testing::HasSubstr("no faces"));
    EXPECT_THAT(refusal(kObj, vertices + "f 1 2 4\n"), testing::HasSubstr("refers to vertex 4"));
    EXPECT_THAT(refusal(kObj, vertices + "f 1 2 -4\n"), testing::HasSubstr("refers to vertex -4"));
    EXPECT_THAT(refusal(kObj, vertices + "f 1/1 2/1 3/1\n"), testing::HasSubstr("texture coordinate 1"));
    EXPECT_THAT(refusal(kObj, vertices + "f 1//7 2//7 3//7\n"), testing::HasSubstr("normal 7"));
    EXPECT_THAT(refusal(kObj, vertices + "f 1 2\n"), testing::HasSubstr("no faces"));
    EXPECT_THAT(refusal(kObj, vertices + "f a b c\n"), testing::HasSubstr("\"a\""));
    EXPECT_THAT(refusal(kObj, vertices + "f 0 1 2\n"), testing::HasSubstr("without a position"));
    EXPECT_THAT(refusal(kObj, "v 0 nan 0\n"), testing::HasSubstr("\"nan\" is not a number"));
    EXPECT_THAT(refusal(kObj, "v 0 1\n"), testing::HasSubstr("2 values"));
    EXPECT_THAT(refusal(kObj, "v 1e99 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\n"), testing::HasSubstr("not finite"));
    EXPECT_THAT(refusal(kObj, vertices + "f 1 2 99999999999999999999\n"),
                testing::HasSubstr("not a vertex of a face"));
}

TEST(MeshObj, SurvivesDamage) { survivesDamage(kObj, kQuadObj); }

// ---- PLY

/// A quad and a triangle with attributes, in any format.
std::string plyFile(const std::string& format) {
    std::string out = "ply\nformat " + format + " 1.0\ncomment made by a test\nelement vertex 5\n";
    for (const char* name : {"x", "y", "z", "nx", "ny", "nz", "s", "t"})
        out += fmt::format("property float {}\n", name);
    out +=
        "property double weight_0\nproperty uchar red\nproperty uchar green\nproperty uchar blue\nproperty "
        "uchar alpha\n"
        "element extra 2\nproperty list uchar short things\nproperty int number\n"
        "element face 2\nproperty float heat_x\nproperty float heat_y\nproperty float heat_z\n"
        "property list uchar int vertex_indices\nproperty float single\nend_header\n";
    const bool ascii = format == "ascii", big = format == "binary_big_endian";
    const auto number = [&](auto value) {
        if (ascii)
            out += fmt::format("{} ", static_cast<double>(value));
        else
            put(out, value, big);
    };
    const float points[5][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}, {0.5f, 2}};
    for (int i = 0; i < 5; ++i) {
        const auto& p = points[i];
        for (const float v : {p[0], p[1], 0.0f, 0.0f, 0.0f, 1.0f, p[0], p[1]}) number(v);
        number(0.5 * i);
        for (const uint8_t v : {255, 0, 51 * i, 128}) number(static_cast<uint8_t>(v));
        if (ascii) out += "\n";
    }
    for (int i = 0; i < 2; ++i) {
        number(static_cast<uint8_t>(i + 1));
        for (int n = 0; n <= i; ++n) number(static_cast<int16_t>(-7));
        number(int32_t(12));
    }
    const auto face = [&](std::initializer_list<int32_t> corners, float heat) {
        for (int i = 0; i < 3; ++i) number(heat + static_cast<float>(i));
        number(static_cast<uint8_t>(corners.size()));
        for (const int32_t c : corners) number(c);
        number(-heat);
    };
    face({0, 1, 2, 3}, 10);
    face({3, 2, 4}, 20);
    return out;
}

TEST(MeshPly, AllFormatsAgree) {
    for (const char* format : {"ascii", "binary_little_endian", "binary_big_endian"}) {
        SCOPED_TRACE(format);
        const auto mesh = read(kPly, plyFile(format));
        EXPECT_THAT(mesh->indices, testing::ElementsAre(0, 1, 2, 0, 2, 3, 3, 2, 4));
        EXPECT_EQ(mesh->positions[4], Vec3f(0.5f, 2, 0));
        EXPECT_EQ(mesh->normals[4], Vec3f(0, 0, 1));
        EXPECT_EQ(mesh->uvs[4], Vec2f(0.5f, 2));
        EXPECT_NEAR(mesh->area(), 1.5, 1e-6);
        EXPECT_EQ(mesh->attributeChannels("vertex_weight"), 1);
        EXPECT_EQ(mesh->attributeChannels("vertex_color"), 3);
        EXPECT_EQ(mesh->attributeChannels("face_heat"), 3);
        EXPECT_EQ(mesh->attributeChannels("face_single"), 1);
        SurfaceInteraction si;
        mesh->interaction(2, {0, 1}, si);
        Rgb value;
        ASSERT_TRUE(mesh->attribute("vertex_weight", si, value));
        EXPECT_FLOAT_EQ(value.x, 2);
        ASSERT_TRUE(mesh->attribute("vertex_color", si, value));
        EXPECT_FLOAT_EQ(value.x, 1);
        EXPECT_FLOAT_EQ(value.y, 0);
        EXPECT_NEAR(value.z, std::pow((0.8 + 0.055) / 1.055, 2.4), 1e-5);  // 204 of 255, sRGB
        ASSERT_TRUE(mesh->attribute("face_heat", si, value));
        EXPECT_EQ(value, Rgb(20, 21, 22));
        mesh->interaction(1, {0, 1}, si);
        ASSERT_TRUE(mesh->attribute("face_heat", si, value));
        EXPECT_EQ(value, Rgb(10, 11, 12));
    }
}

std::string smallPly(const std::string& vertexCount, const std::string& faces, const std::string& data) {
    return "ply\nformat ascii 1.0\nelement vertex " + vertexCount +
           "\nproperty float x\nproperty float y\nproperty float z\nelement face " + faces +
           "\nproperty list uchar int vertex_index\nend_header\n" + data;
}

TEST(MeshPly, RefusesWhatIsWrong) {
    const std::string triangle = "0 0 0 1 0 0 1 1 0\n3 0 1 2";
    EXPECT_EQ(read(kPly, smallPly("3", "1", triangle))->primitiveCount(), 1u);
    EXPECT_THAT(refusal(kPly, smallPly("3", "0", "0 0 0 1 0 0 1 1 0")), testing::HasSubstr("no faces"));
    EXPECT_THAT(refusal(kPly, smallPly("4", "1", triangle)), testing::HasSubstr("more than the file"));
    EXPECT_THAT(refusal(kPly, smallPly("99999999999999", "1", triangle)), testing::HasSubstr("truncated"));
    EXPECT_THAT(refusal(kPly, smallPly("3", "18446744073709551615", triangle)),
                testing::HasSubstr("truncated"));
    EXPECT_THAT(refusal(kPly, smallPly("3", "99999999999999999999999", triangle)),
                testing::HasSubstr("not a number of elements"));
    EXPECT_THAT(refusal(kPly, smallPly("-3", "1", triangle)), testing::HasSubstr("-3"));
    EXPECT_THAT(refusal(kPly, smallPly("3", "1", "0 0 0 1 0 0 1 1 0\n3 0 1 3")),
                testing::HasSubstr("vertex 3"));
    EXPECT_THAT(refusal(kPly, smallPly("3", "1", "0 0 0 1 0 0 1 1 0\n3 0 1 -1")),
                testing::HasSubstr("vertex -1"));
    EXPECT_THAT(refusal(kPly, smallPly("3", "1", "0 0 0 1 0 0 1 1 0\n2 0 1")),
                testing::HasSubstr("no faces"));
    EXPECT_THAT(refusal(kPly, smallPly("3", "1", "0 0 0 1 0 0 1 1 0\n2000000 0 1")),
                testing::HasSubstr("more than the file"));
    EXPECT_THAT(refusal(kPly, smallPly("3", "1", "0 0 x 1 0 0 1 1 0\n3 0 1 2")), testing::HasSubstr("\"x\""));
    EXPECT_THAT(refusal(kPly, smallPly("3", "1", "0 0 nan 1 0 0 1 1 0\n3 0 1 2")),
                testing::HasSubstr("not finite"));
    EXPECT_THAT(refusal(kPly, "ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\nend_header\n"),
                testing::HasSubstr("x, y and z"));
    EXPECT_THAT(refusal(kPly, "ply\nformat ascii 1.0\nend_header\n"), testing::HasSubstr("\"face\""));
    EXPECT_THAT(refusal(kPly, "ply\nformat octal 1.0\nend_header\n"), testing::HasSubstr("octal"));
    EXPECT_THAT(refusal(kPly, "solid\n"), testing::HasSubstr("not a PLY"));
    EXPECT_THAT(refusal(kPly, "ply\nformat ascii 1.0\n"), testing::HasSubstr("end_header"));
    // Rows that take no space must not be looped over.
    EXPECT_THAT(refusal(kPly, "ply\nformat ascii 1.0\nelement nothing 18446744073709551615\nend_header\n"),
                testing::HasSubstr("face"));
}

TEST(MeshPly, SurvivesDamage) {
    for (const char* format : {"ascii", "binary_little_endian", "binary_big_endian"})
        survivesDamage(kPly, plyFile(format));
}

// ---- serialized

struct SerializedOptions {
    int version = 4;
    uint32_t flags = 0x1003;
    uint64_t vertices = 3, faces = 1;
    uint32_t lastIndex = 2;
    float height = 0;
    std::string name = "name";
};

std::string compressed(const std::string& raw) {
    uLongf size = compressBound(raw.size());
    std::string out(size, '\0');
    compress(reinterpret_cast<Bytef*>(out.data()), &size, reinterpret_cast<const Bytef*>(raw.data()),
             raw.size());
    out.resize(size);
    return out;
}

std::string serializedMesh(const SerializedOptions& o) {
    std::string raw;
    put(raw, o.flags);
    if (o.version == 4) raw += o.name + '\0';
    put(raw, o.vertices);
    put(raw, o.faces);
    const auto number = [&](float value) {
        if (o.flags & 0x2000)
            put(raw, static_cast<double>(value));
        else
            put(raw, value);
    };
    for (const float v : {0.f, 0.f, o.height, 1.f, 0.f, o.height, 0.f, 1.f, o.height}) number(v);
    if (o.flags & 0x1)
        for (int i = 0; i < 3; ++i)
            for (const float v : {0.f, 0.f, 1.f}) number(v);
    if (o.flags & 0x2)
        for (const float v : {0.f, 0.f, 1.f, 0.f, 0.f, 1.f}) number(v);
    if (o.flags & 0x8)
        for (int i = 0; i < 9; ++i) number(0.1f * static_cast<float>(i));
    for (const uint32_t i : {0u, 1u, o.lastIndex}) put(raw, i);
    std::string file;
    put(file, uint16_t(0x041C));
    put(file, static_cast<uint16_t>(o.version));
    return file + compressed(raw);
}

std::string serializedFile(int version, uint32_t flags) {
    std::string file, table;
    for (int i = 0; i < 3; ++i) {
        version == 4 ? put(table, uint64_t(file.size())) : put(table, static_cast<uint32_t>(file.size()));
        file += serializedMesh({.version = version, .flags = flags, .height = static_cast<float>(i)});
    }
    put(table, uint32_t(3));
    return file + table;
}

TEST(MeshSerialized, VersionsPrecisionsAndTheTable) {
    for (const int version : {3, 4})
        for (const uint32_t flags : {0x1000u, 0x1003u, 0x100bu, 0x2000u, 0x2003u, 0x200bu, 0x3u}) {
            const Scratch file(serializedFile(version, flags));
            for (int index = 0; index < 3; ++index) {
                const auto mesh = readSerialized(file.path(), index, {});
                ASSERT_EQ(mesh->positions.size(), 3u);
                EXPECT_EQ(mesh->positions[1], Vec3f(1, 0, static_cast<float>(index)));
                EXPECT_EQ(mesh->normals[0], Vec3f(0, 0, 1));  // stored or computed
                EXPECT_EQ(mesh->uvs.size(), flags & 2 ? 3u : 0u);
                EXPECT_EQ(mesh->attributeChannels("vertex_color"), flags & 8 ? 3 : 0);
            }
            EXPECT_THROW(readSerialized(file.path(), 3, {}), Error);
            EXPECT_THROW(readSerialized(file.path(), -1, {}), Error);
        }
    EXPECT_TRUE(read(kSerialized, serializedMesh({.flags = 0x1013}))->normals.empty());  // face normals
}

TEST(MeshSerialized, RefusesWhatIsWrong) {
    EXPECT_THAT(refusal(kSerialized, serializedMesh({.vertices = uint64_t(1) << 40})),
                testing::HasSubstr("supported"));
    EXPECT_THAT(refusal(kSerialized, serializedMesh({.vertices = 4000000000})),
                testing::HasSubstr("more than its size"));
    EXPECT_THAT(refusal(kSerialized, serializedMesh({.faces = uint64_t(1) << 62})),
                testing::HasSubstr("more than its size"));
    EXPECT_THAT(refusal(kSerialized, serializedMesh({.faces = 100})), testing::HasSubstr("truncated"));
    EXPECT_THAT(refusal(kSerialized, serializedMesh({.faces = 0})), testing::HasSubstr("no faces"));
    EXPECT_THAT(refusal(kSerialized, serializedMesh({.lastIndex = 3})), testing::HasSubstr("vertex 3"));
    EXPECT_THAT(refusal(kSerialized, serializedMesh({.height = NAN})), testing::HasSubstr("not finite"));
    EXPECT_THAT(refusal(kSerialized, serializedMesh({.name = std::string(1 << 20, 'a')})),
                testing::HasSubstr("name has more than 4096 bytes"));
    EXPECT_TRUE(read(kSerialized, serializedMesh({.name = std::string(4096, 'a')})));
    EXPECT_THAT(refusal(kSerialized, serializedMesh({.version = 5})), testing::HasSubstr("version 5"));
    EXPECT_THAT(refusal(kSerialized, "no mesh at all"), testing::HasSubstr("not a serialized mesh"));
    std::string badTable = serializedFile(4, 0x1003);
    badTable[badTable.size() - 12] = '\x7f';  // offset of the last mesh
    EXPECT_THAT(refusal([](const fs::path& p) { return readSerialized(p, 2, {}); }, badTable),
                testing::HasSubstr("offset"));
    badTable[badTable.size() - 1] = '\x7f';  // number of meshes
    EXPECT_THAT(refusal([](const fs::path& p) { return readSerialized(p, 2, {}); }, badTable),
                testing::HasSubstr("longer than the file"));
}

TEST(MeshSerialized, SurvivesDamage) {
    for (const int index : {0, 2})
        survivesDamage([=](const fs::path& p) { return readSerialized(p, index, {}); },
                       serializedFile(4, 0x1003));
}

TEST(MeshFiles, MissingFilesAreNamed) {
    for (const Read& reader : {kObj, kPly, kSerialized}) {
        try {
            reader("/no/such/mesh.file");
            ADD_FAILURE();
        } catch (const Error& error) {
            EXPECT_THAT(error.what(), testing::HasSubstr("/no/such/mesh.file"));
        }
    }
    EXPECT_THROW(readPly("/tmp", {}), Error);
}

}  // namespace
}  // namespace metrolux::core
