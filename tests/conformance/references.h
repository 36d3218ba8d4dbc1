#pragma once
/// The render tests of Mitsuba 3 in ../shared/conformance and ../shared/conformance-media, and the test that Mitsuba applies to them.

#include "image/image_io.h"
#include "paths.h"

#include <filesystem>
#include <ostream>
#include <string>
#include <vector>

namespace metrolux::core::test {

struct ConformanceScene {
    std::string name;  ///< "bsdf_spheres/test_envmap"
    std::filesystem::path file, reference, variance;
};
inline void PrintTo(const ConformanceScene& scene, std::ostream* out) { *out << scene.name; }

/// All scenes there that have a reference, sorted by name.
std::vector<ConformanceScene> conformanceScenes();

/// Reference and variance of one sample, both in XYZ.
struct Reference {
    ImageData image, variance;
};
Reference readReference(const ConformanceScene& scene);

/// Linear Rec. 709 to XYZ, in place.
void toXyz(std::vector<float>& rgb);

struct ZTest {
    double share = 0;            ///< of the pixel-channels with p above alpha
    std::vector<float> pValues;  ///< one for each pixel-channel
};
/// z = |image - reference| sqrt(samples / max(variance, 1e-4)), two-sided; alpha = 1 - (1 - 0.01)^(1 /
/// pixels).
ZTest zTest(const std::vector<float>& imageXyz, const Reference& reference, int samples);
/// The least share that passes.
inline constexpr double kZTestShare = 0.9975;

/// Writes image, reference, error and p-values (white: 1, black: 0) below METROLUX_BINARY_DIR/conformance.
void writeFailure(const std::string& name, std::vector<float> imageXyz, const Reference& reference,
                  const std::vector<float>& pValues);
/// Notes a row of the table of docs/lab/conformance.md in
/// METROLUX_BINARY_DIR/conformance/<scene>-<integrator>.row.
void writeRow(const std::string& scene, const std::string& integrator, const std::string& result,
              double seconds);

}  // namespace metrolux::core::test
