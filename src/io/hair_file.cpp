#include "io/hair_file.h"

#include "base/error.h"

#include <cmath>
#include <cstring>

namespace metrolux::core {
namespace {

constexpr std::string_view kHairMagic = "BINARY_HAIR";

std::vector<std::vector<CurvePoint>> readBinary(const std::filesystem::path& path, const std::string& data,
                                                double radius) {
    size_t at = kHairMagic.size();
    const auto read = [&](auto& value) {
        if (data.size() - at < sizeof(value))
            throw Error("{}: ends after {} bytes, in the middle of its points", path.string(), data.size());
        std::memcpy(&value, data.data() + at, sizeof(value));
        at += sizeof(value);
    };
    uint32_t count = 0;
    read(count);
    if (count > (data.size() - at) / (3 * sizeof(float)))
        throw Error("{}: declares {} points, has room for {}", path.string(), count,
                    (data.size() - at) / (3 * sizeof(float)));
    std::vector<std::vector<CurvePoint>> result;
    bool begins = true;
    for (uint32_t i = 0; i < count; ++i) {
        float x = 0, y = 0, z = 0;
        read(x);
        if (std::isinf(x)) {
            begins = true;
            read(x);
        }
        read(y);
        read(z);
        if (!std::isfinite(x) || !std::isfinite(y) || !std::isfinite(z))
            throw Error("{}: point {} (counted from 0) is not finite", path.string(), i);
        if (begins) result.emplace_back();
        begins = false;
        result.back().push_back({{double(x), double(y), double(z)}, radius});
    }
    return result;
}

}  // namespace

std::vector<std::vector<CurvePoint>> readHairs(const std::filesystem::path& path, const MeshOptions& options,
                                               double radius) {
    const std::string data = readMeshFile(path, options);
    if (!data.starts_with(kHairMagic)) return readCurves(path, options, radius);
    requireMemory(path, options, data.size() / (3 * sizeof(float)) + 1, sizeof(CurvePoint), "the hairs");
    return readBinary(path, data, radius);
}

}  // namespace metrolux::core
