/// Grids of OpenVDB, as tests/support/make_vdb_grids.cpp has written them.

#include "io/vdb_file.h"

#include "media_support.h"
#include "paths.h"

#include <gmock/gmock.h>

#include <fstream>

namespace metrolux::core::test {
namespace {

using testing::HasSubstr;

#ifdef METROLUX_OPENVDB

const std::filesystem::path kFolder = std::filesystem::path(METROLUX_BINARY_DIR) / "tests";
const std::filesystem::path kGrids = kFolder / "grids.vdb";

TEST(VdbFile, readsTheFirstGridOfFloatsOrTheNamedOne) {
    const VdbFile density = readVdbFile(kGrids, ""), named = readVdbFile(kGrids, "density");
    // 2 x 3 x 3 voxels, and a layer around them.
    EXPECT_EQ(density.samples.resolution, Imath::V3i(4, 5, 5));
    EXPECT_EQ(density.samples.channels, 1);
    EXPECT_TRUE(std::ranges::equal(density.samples.values, named.samples.values));
    const VdbFile heat = readVdbFile(kGrids, "heat");
    EXPECT_EQ(heat.samples.resolution, Imath::V3i(3));
    EXPECT_EQ(heat.samples.values[13], 7);
}

TEST(VdbFile, voxelsAreWhereTheFileHasThem) {
    const VdbFile file = readVdbFile(kGrids, "density");
    const VolumePtr grid = makeGridVolume(file.samples, {.toWorld = file.toFile});
    const auto at = [&](float i, float j, float k) {
        return grid->value({1 + i / 2, 2 + k / 4, 3 - j / 4}).x;
    };
    EXPECT_NEAR(at(2, -3, 4), 0.5f, 1e-6f);
    EXPECT_NEAR(at(3, -3, 4), 1, 1e-6f);
    EXPECT_NEAR(at(2, -1, 6), 2, 1e-6f);
    EXPECT_NEAR(at(3, -1, 6), 0, 1e-6f);
    EXPECT_NEAR(at(2.25f, -3, 4), 0.625f, 1e-6f) << "between voxels";
    EXPECT_NEAR(at(3.5f, -3, 4), 0.5f, 1e-6f) << "half a voxel outside, as in OpenVDB";
    EXPECT_NEAR(at(4, -3, 4), 0, 1e-6f);
}

TEST(VdbFile, scenesPlaceItsGrids) {
    const auto parts =
        partsOf(withMedia(fmt::format(R"(<shape type="cube"><medium type="heterogeneous" name="interior">
<volume name="sigma_t" type="gridvolume"><string name="filename" value="{}"/><string name="grid" value="density"/>
<transform name="to_world"><scale value="2"/></transform></volume></medium></shape>)",
                                      kGrids.string())));
    ASSERT_EQ(parts.media.size(), 1u);
    // Voxel (3, -3, 4), twice as far from the origin as in the file.
    EXPECT_NEAR(parts.media[0]->extinction({5, 6, 7.5f}).x, 1, 1e-6f);
    EXPECT_NEAR(parts.media[0]->extinction({5.5f, 6, 7.5f}).x, 0.5f, 1e-6f);
}

TEST(VdbFile, refusals) {
    const auto refusal = [](const std::filesystem::path& file, const char* grid, uint64_t bytes = 1 << 20) {
        MemoryBudget memory(bytes);
        return errorOf([&] { readVdbFile(file, grid, &memory); });
    };
    EXPECT_THAT(refusal(kGrids, "smoke"), HasSubstr("grids.vdb: found \"density\" (float), "));
    EXPECT_THAT(refusal(kGrids, "smoke"), HasSubstr(", \"id\" (int32), "));
    EXPECT_THAT(refusal(kGrids, "smoke"), HasSubstr("expected a grid of floats named \"smoke\""));
    EXPECT_THAT(refusal(kGrids, "id"), HasSubstr("expected a grid of floats named \"id\""));
    EXPECT_THAT(refusal(kFolder / "no_floats.vdb", ""),
                HasSubstr("no_floats.vdb: found \"id\" (int32), expected a grid of floats"));
    EXPECT_THAT(refusal(kGrids, "surface"), HasSubstr("is a level set"));
    EXPECT_THAT(refusal(kGrids, "empty"), HasSubstr("has no active voxels"));
    EXPECT_THAT(refusal(kGrids, "frustum"), HasSubstr("perspective"));
    EXPECT_THAT(refusal(kGrids, "negative"), HasSubstr("found -1 in cell (1, 1, 1)"));
    EXPECT_THAT(refusal(kGrids, "wide"), HasSubstr("2000003 x 2000003 x 2000003 voxels need more memory"));
    EXPECT_THAT(refusal(kGrids, "density", 100), HasSubstr("more than are left for the scene"));
    EXPECT_THAT(refusal("/nowhere/a.vdb", ""), HasSubstr("/nowhere/a.vdb: cannot be read"));
    const TemporaryFolder folder;
    EXPECT_THAT(refusal(folder.write("text.vdb", "no grid at all"), ""), HasSubstr("text.vdb: "));
    std::ifstream stream(kGrids, std::ios::binary);
    const std::string bytes((std::istreambuf_iterator<char>(stream)), {});
    EXPECT_THAT(refusal(folder.write("half.vdb", bytes.substr(0, bytes.size() / 2)), ""),
                HasSubstr("half.vdb: "));
}

#else

TEST(VdbFile, saysThatThisWasBuiltWithout) {
    const TemporaryFolder folder;
    EXPECT_THAT(errorOf([&] { readVdbFile(folder.write("a.vdb", ""), ""); }),
                HasSubstr("a.vdb: this program was built without OpenVDB"));
}

#endif

}  // namespace
}  // namespace metrolux::core::test
